// SPDX-License-Identifier: Zlib
#pragma once

// The kernels of verlet_kernel.h, compiled for each instruction set of x86-64, or for NEON of AArch64, with
// GCC or Clang. On other platforms every body is stepped alone.
#if defined(__GNUC__) || defined(__clang__)
#if defined(__x86_64__)
#define LIMBER_HAS_X86_LANES
#elif defined(__aarch64__)
#define LIMBER_HAS_NEON_LANES
#endif
#endif

// This header includes nothing: what the files of the kernels include is compiled for their instruction set.
namespace limber::kernel {

template <class V>
struct Body;
template <class V>
struct MovedPoints;
struct SpringBatchBody;
struct PlaneBody;
struct BatchPoints;

/// Steps laneCount() bodies with equal springs, volume terms and inverse masses by stepAlone(), and writes
/// its result for each to `change`. Arrays that would be of packs have the numbers of all bodies side by
/// side. `moved`: the arguments of sumUp(); nullptr: not wanted.
using LaneStep = void(const Body<double>& body, const MovedPoints<double>* moved, double* change, double tick,
                      int substeps);
#if defined(LIMBER_HAS_X86_LANES)
LaneStep stepSse2, stepAvx2, stepAvx512;
#elif defined(LIMBER_HAS_NEON_LANES)
LaneStep stepNeon;
#endif

/// Steps a body; see stepAlone() of verlet_kernel.h, also for the result. Needs AVX2 or NEON.
double stepSpringBatches(const SpringBatchBody& body, double tick, int substeps);

/// All forces, and one sweep over the dampers, for bodies that are stepped together with others.
void computeBatchForces(const SpringBatchBody& body, double crossing);
void dampBatch(const SpringBatchBody& body, bool whole, bool forward);

/// The parts of this step, for bodies that are stepped by several threads. Each is computed for some points,
/// springs or tetrahedra; `begin` and `end` are multiples of four. `crossing`: the share of crossingForce().
void addBatchSprings(const SpringBatchBody& body, unsigned begin, unsigned end, double crossing);
void addBatchVolumes(const SpringBatchBody& body);
void addBatchTetrahedra(const SpringBatchBody& body, unsigned begin, unsigned end);
void clearBatchForces(const SpringBatchBody& body, const BatchPoints& points);
void kickBatchPoints(const SpringBatchBody& body, double dt, const BatchPoints& points);
void driftBatchPoints(const SpringBatchBody& body, double dt, const BatchPoints& points);
void dampBatchSprings(const SpringBatchBody& body, bool whole, bool forward, unsigned begin, unsigned end);

/// Copy a quantity of the ends of springs in strips (StripBody) between the points and their slots. Loading
/// positions also clears the forces of the slots; unloading forces replaces those of the points. They do
/// nothing for other bodies.
void loadSlots(const SpringBatchBody& body, const BatchPoints& slots, unsigned quantity);
void unloadSlots(const SpringBatchBody& body, const BatchPoints& slots, unsigned quantity);

/// Solve the contacts of groups before a drift of dt from `time`, and after the kick that follows it: see
/// solvePositions() and solveVelocities() of plane_contacts.h. Need AVX2 or NEON.
void stopBatchPoints(const PlaneBody& body, unsigned begin, unsigned end, double time, double dt);
void settleBatchPoints(const PlaneBody& body, unsigned begin, unsigned end);

}  // namespace limber::kernel

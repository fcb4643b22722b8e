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

#include <cstddef>
#include <vector>

namespace limber {

/// 64 bytes: an array of these has the alignment of the registers of every instruction set.
struct alignas(64) CacheLine {
  double value[8];
};

using AlignedNumbers = std::vector<CacheLine>;

inline double* numbers(AlignedNumbers& array) { return array.front().value; }

/// Makes room for `count` numbers; never shrinks. New numbers are 0.
inline void reserveNumbers(AlignedNumbers& array, std::size_t count) {
  if (array.size() * 8 < count) array.resize((count + 7) / 8, CacheLine{});
}

}  // namespace limber

namespace limber::kernel {

struct ContactCalls;
template <class V>
struct Capsule;

/// kernel::Volumes for both kinds of bodies below. gradient and sums are packs in a LaneBody; for the others
/// see SpringBatchBody::volumes. `components` is 0 without a volume term.
struct VolumeBody {
  unsigned components = 0, points = 0;
  const unsigned *firstTriangle = nullptr, *corners = nullptr, *componentOf = nullptr;
  const double *restVolume = nullptr, *modulus = nullptr, *gasPressure = nullptr, *ambient = nullptr;
  double *gradient = nullptr, *sums = nullptr;
  double timeStep = 0.0;
};

/// kernel::Tetrahedra for both kinds of bodies below. stabilityScale is packs in a LaneBody. In a
/// SpringBatchBody the tetrahedra are padded to a multiple of four.
struct TetrahedronBody {
  unsigned count = 0;
  const unsigned* corners = nullptr;
  const double *inverseRest = nullptr, *stabilityScale = nullptr, *modulus = nullptr, *crushModulus = nullptr;
};

/// A kernel::Body for laneCount() bodies with equal springs, volume terms and inverse masses. The constants
/// of these are plain numbers; those that differ between the bodies are packs of laneCount() doubles.
struct LaneBody {
  unsigned points, springs;
  const unsigned *a, *b;
  double *position, *velocity, *force, *earlierForce;
  const double *acceleration, *inverseMass;
  const double *restLength, *extensionStiffness, *compressionStiffness;
  double* direction;
  double* stretch;             ///< scratch; nullptr: no spring has two stiffnesses
  const double* crossingLoss;  ///< see crossingForce()
  VolumeBody volumes;
  TetrahedronBody tetrahedra;
  unsigned planes;  ///< see Planes
  const unsigned* planePoints;
  double* planeNumbers;                         ///< #planes x a Plane of packs
  const double *regionCenter, *regionDistance;  ///< see SearchRegions; nullptr: not needed
  int sweeps;                                   ///< over the dampers in a substep; 0: no dampers
  const double *dampHalf, *dampFull;
  const ContactCalls* contacts;
  double* change;       ///< output, one per lane, see computeForcesAndChange()
  const double* start;  ///< the other arguments of motionSums()
  const double *fractions, *weightedRest;
  double* sums;  ///< output, a MotionSums of packs; nullptr: not wanted
};

/// The ends of springs in strips (Strips of division.h).
struct StripBody {
  /// Numbers of a slot: for each of these quantities x of its points, one from each strip, then y and z.
  static constexpr unsigned kPosition = 0, kVelocity = 12, kForce = 24, kInverseMass = 36, kNumbers = 48;

  unsigned slots = 0;         ///< 0: not in strips
  unsigned points = 0;        ///< of the body
  double* numbers = nullptr;  ///< kNumbers x #slots, and one more that a shifted batch reads
};

/// One body. Each point has four doubles: x, y, z, 0. Each spring has one number per array. The number of
/// springs is a multiple of four.
struct SpringBatchBody {
  unsigned points, springs;
  const unsigned *a, *b;  ///< points; in strips one per batch: the first number of its first spring's end
  const unsigned char* apart;  ///< per batch of four springs: whether they share no point; not used in strips
  StripBody strips;
  double *position, *velocity, *force, *earlierForce;
  const double *acceleration, *inverseMass;
  const double *restLength, *extensionStiffness, *compressionStiffness;
  double* inverseLength;       ///< output: 1/m, 0 while slack
  double* stretch;             ///< scratch; nullptr: no spring has two stiffnesses
  const double* crossingLoss;  ///< see crossingForce()
  VolumeBody volumes;  ///< one number per component; 4 doubles per point in gradient, 8 per component in sums
  TetrahedronBody tetrahedra;
  int sweeps;  ///< over the dampers in a substep; 0: no dampers
  const double *dampHalf, *dampFull;
  const ContactCalls* contacts;
};

/// Contacts of points with a plane each, in groups of four, and those points, each with four doubles. Points
/// that fill up a group repeat its first one, without a contact.
struct PlaneBody {
  static constexpr unsigned kFixed = static_cast<unsigned>(-1);

  const unsigned* points;     ///< 4 x #groups
  double* planes;             ///< #groups x a Plane of four doubles per number
  const unsigned* capsuleOf;  ///< #groups: the capsule that the planes follow; kFixed: none
  const Capsule<double>* capsules;
  double radius;  ///< m, of points on capsules
  const double* position;
  double* velocity;
  const double* inverseMass;
};

/// The points, or slots, from `begin` to `end`, or those with these entries of `numbers`, if it is set.
struct BatchPoints {
  unsigned begin, end;
  const unsigned* numbers = nullptr;
};

/// Steps a body; see stepAlone() of verlet_kernel.h, also for the result. Needs AVX2 or NEON.
double stepSpringBatches(const SpringBatchBody& body, double tick, int substeps);

/// The parts of this step, for bodies that are stepped together with others or by several threads. Each is
/// computed for some points, springs or tetrahedra; `begin` and `end` are multiples of four. They need AVX2
/// or NEON. `crossing`: the share of crossingForce().
void addBatchSprings(const SpringBatchBody& body, unsigned begin, unsigned end, double crossing);
void addBatchVolumes(const SpringBatchBody& body);
void addBatchTetrahedra(const SpringBatchBody& body, unsigned begin, unsigned end);
void clearBatchForces(const SpringBatchBody& body, const BatchPoints& points);
void kickBatchPoints(const SpringBatchBody& body, double dt, const BatchPoints& points);
void driftBatchPoints(const SpringBatchBody& body, double dt, const BatchPoints& points);
void dampBatchSprings(const SpringBatchBody& body, bool whole, bool forward, unsigned begin, unsigned end);

/// Solve the contacts of groups before a drift of dt from `time`, and after the kick that follows it: see
/// solvePositions() and solveVelocities() of plane_contacts.h. Need AVX2 or NEON.
void stopBatchPoints(const PlaneBody& body, unsigned begin, unsigned end, double time, double dt);
void settleBatchPoints(const PlaneBody& body, unsigned begin, unsigned end);

/// Copy quantities of the ends of springs in strips between their slots and the points. They do nothing for
/// other bodies.
void loadSlotInverseMasses(const SpringBatchBody& body, const BatchPoints& slots);
void loadSlotPositions(const SpringBatchBody& body, const BatchPoints& slots);  ///< also clears slots' forces
void unloadSlotForces(const SpringBatchBody& body,
                      const BatchPoints& slots);  ///< replaces the points' forces
void loadSlotVelocities(const SpringBatchBody& body, const BatchPoints& slots);
void unloadSlotVelocities(const SpringBatchBody& body, const BatchPoints& slots);

#if defined(LIMBER_HAS_X86_LANES)
void stepSse2(const LaneBody& body, double tick, int substeps);
void stepAvx2(const LaneBody& body, double tick, int substeps);
void stepAvx512(const LaneBody& body, double tick, int substeps);
#elif defined(LIMBER_HAS_NEON_LANES)
void stepNeon(const LaneBody& body, double tick, int substeps);
#endif

}  // namespace limber::kernel

// SPDX-License-Identifier: Zlib
#pragma once

// The kernels of verlet_kernel.h as compiled for each instruction set. x86-64 with GCC or Clang; elsewhere
// every body is stepped by itself.
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
#define LIMBER_HAS_LANES
#endif

#include <cstddef>
#include <vector>

namespace limber {

/// 64 bytes, so that a register of any instruction set can be read from an array of these.
struct alignas(64) CacheLine {
  double value[8];
};

using AlignedNumbers = std::vector<CacheLine>;

inline double* numbers(AlignedNumbers& array) { return array.front().value; }

/// Makes room for `count` numbers; never shrinks. What is new is 0.
inline void reserveNumbers(AlignedNumbers& array, std::size_t count) {
  if (array.size() * 8 < count) array.resize((count + 7) / 8, CacheLine{});
}

}  // namespace limber

namespace limber::kernel {

struct ContactCalls;

/// Of both kinds of bodies below: kernel::Volumes with packs or quads for numbers, `components` 0 without.
struct VolumeBody {
  unsigned components = 0, points = 0;
  const unsigned *firstTriangle = nullptr, *corners = nullptr, *componentOf = nullptr;
  const double *restVolume = nullptr, *modulus = nullptr, *pressure = nullptr;
  double *gradient = nullptr, *sums = nullptr;
  double timeStep = 0.0;
};

/// Of both kinds of bodies below: kernel::Tetrahedra with packs for numbers; of a SpringBatchBody, with one
/// number per tetrahedron, filled up to a multiple of four, and one modulus.
struct TetrahedronBody {
  unsigned count = 0;
  const unsigned* corners = nullptr;
  const double *inverseRest = nullptr, *stabilityScale = nullptr, *modulus = nullptr, *crushModulus = nullptr;
};

/// A kernel::Body whose numbers are packs of `laneCount` doubles.
struct LaneBody {
  unsigned points, springs;
  const unsigned *a, *b;
  double *position, *velocity, *force, *earlierForce;
  const double *acceleration, *inverseMass;
  const double *restLength, *extensionStiffness, *compressionStiffness;
  double* direction;
  VolumeBody volumes;
  TetrahedronBody tetrahedra;
  bool damped;
  const double *dampHalf, *dampFull;
  const ContactCalls* contacts;
  double* change;  ///< written: one per lane, see computeForcesAndChange
};

/// One body whose points are quads x, y, z, 0 of doubles; what is one number per spring comes as it is. The
/// number of springs is a multiple of four.
struct SpringBatchBody {
  unsigned points, springs;
  const unsigned *a, *b;
  const unsigned char* apart;  ///< per four springs: whether they share no point
  double *position, *velocity, *force, *earlierForce;
  const double *acceleration, *inverseMass;
  const double *restLength, *extensionStiffness, *compressionStiffness;
  double* inverseLength;  ///< written: 1/m, 0 while slack
  VolumeBody volumes;     ///< one number per component; gradients are quads, sums two quads per component
  TetrahedronBody tetrahedra;
  bool damped;
  const double *dampHalf, *dampFull;
  const ContactCalls* contacts;
};

/// Needs AVX2. Returns computeForcesAndChange.
double stepSpringBatches(const SpringBatchBody& body, double tick, int substeps);
/// The parts of such a step, for bodies that are stepped together with others. Need AVX2.
void computeBatchForces(const SpringBatchBody& body);
double computeBatchForcesAndChange(const SpringBatchBody& body);
void kickSpringBatches(const SpringBatchBody& body, double dt);
void driftSpringBatches(const SpringBatchBody& body, double dt);
void dampSpringBatches(const SpringBatchBody& body, bool whole, bool forward);

#if defined(LIMBER_HAS_LANES)
void stepSse2(const LaneBody& body, double tick, int substeps);
void stepAvx2(const LaneBody& body, double tick, int substeps);
void stepAvx512(const LaneBody& body, double tick, int substeps);
#endif

}  // namespace limber::kernel

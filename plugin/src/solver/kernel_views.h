// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/lane_kernels.h"
#include "solver/point_state.h"
#include "solver/spring_arrays.h"
#include "solver/tetrahedron_volumes.h"
#include "solver/verlet_kernel.h"
#include "solver/volume_term.h"

namespace limber {

/// The arrays of one body as the kernel of verlet_kernel.h takes them.
inline kernel::Springs<double> kernelSprings(SpringArrays& s) {
  return {static_cast<kernel::Index>(s.size()),
          s.a.data(),
          s.b.data(),
          s.restLength.data(),
          s.extensionStiffness.data(),
          s.compressionStiffness.data(),
          s.direction.data()};
}

inline kernel::Points<double> kernelPoints(PointState& p) {
  return {static_cast<kernel::Index>(p.position.cols()),
          p.position.data(),
          p.velocity.data(),
          p.force.data(),
          p.acceleration.data(),
          p.inverseMass.data()};
}

inline kernel::VolumeBody volumeBody(VolumeArrays& volumes) {
  const kernel::Volumes<double> v = kernelVolumes(volumes);
  return {v.components, v.points,   v.firstTriangle, v.corners, v.componentOf, v.restVolume,
          v.modulus,    v.pressure, v.gradient,      v.sums,    v.timeStep};
}

inline kernel::TetrahedronBody tetrahedronBody(const TetrahedronVolumes& volumes) {
  const kernel::Tetrahedra<double> t = kernelTetrahedra(volumes);
  return {t.count, t.corners, t.inverseRest, t.hold, t.modulus, t.crushModulus};
}

}  // namespace limber

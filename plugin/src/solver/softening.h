// SPDX-License-Identifier: Zlib
#pragma once

// Softer constants for bodies whose budget of substeps does not resolve their stiffness.

#include "solver/springs.h"
#include "solver/volumes.h"

#include <memory>
#include <mutex>
#include <vector>

namespace limber {

/// The elastic constants of a body.
struct ElasticConstants {
  SharedConstants<SpringConstants> springs;
  SharedConstants<VolumeConstants> volumes;
  SharedConstants<TetrahedronConstants> tetrahedra;
};

/// Elastic constants that Verlet's substeps resolve, and what they were made from.
struct SoftenedConstants {
  ElasticConstants constants;
  double share = 1.0;    ///< smallest share of a spring's stiffness, or of a volume modulus, that is left
  double largest = 0.0;  ///< rad^2/s^2, see softened()
  Points inverseMass;    ///< 3 x #points, 1/kg
};

/// Returns constants with which the square of the body's fastest oscillation about its rest shape is at most
/// `largest` (rad^2/s^2), and that of its springs at any deformation.
///
/// The bounds of springs, closed surfaces and tetrahedra add up. Those that are small beside `largest` keep
/// their stiffness, the others are softened in proportion: moduli and pressures, also the ambient one, as a
/// whole; springs one by one, so that those which are slow enough keep theirs. Rest lengths, masses and
/// dampers stay.
SoftenedConstants softened(const ElasticConstants& full, const Points& restShape, const Points& inverseMass,
                           double largest);

/// The softened constants of bodies of one model. Bodies with equal masses and limits share them, so that
/// they can be stepped in SIMD lanes. Several threads may use it.
class SharedSoftening {
 public:
  /// See softened(). The result lives as long as a body uses it.
  std::shared_ptr<const SoftenedConstants> of(const ElasticConstants& full, const Points& restShape,
                                              const Points& inverseMass, double largest);

 private:
  std::mutex lock_;
  std::vector<std::weak_ptr<const SoftenedConstants>> made_;
};

}  // namespace limber

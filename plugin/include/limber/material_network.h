// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_builder.h>
#include <limber/soft_body_settings.h>

namespace limber {

struct MaterialMesh {
  double spacing = 0.0;        ///< m, of the lattice the tetrahedra come from; 0: from `points`
  std::uint32_t points = 300;  ///< about this many point masses, 8 or more, when no spacing is given
  Progress progress;           ///< returning false ends it with an error: there is no early result
};

/// A body of a material instead of a mesh of springs: the inside of a closed mesh filled with tetrahedra,
/// whose edges are springs of constants near  sum over its tetrahedra V / L^2  (Van Gelder 1998:
/// k = E sum V / L^2), fitted so that the body is as stiff in all directions, and calibrated once so that its
/// measured Young's modulus is the one asked for (stiffnessPerModulus). Mass shares are those of the
/// tetrahedra's volume, 0.2 of their mean at least. The render surface is the mesh, skinned. Concave surfaces
/// are followed to about half a spacing. Errors: those of weld(); a mesh that is not closed, with the number
/// of its open edges, or that encloses nothing; a piece of it that is thinner than the lattice can follow;
/// sizes out of range; progress that returned false.
Result<SharedNetwork> buildMaterialNetwork(const TriangleMesh& mesh, const MaterialMesh& settings = {});

struct Material {
  double youngsModulus = 1e5;  ///< Pa, above 0
  double poissonRatio = 0.25;  ///< 0.25 (about that of springs alone) to below 0.5 (by the volume term)
  double density = 1000.0;     ///< kg/m^3, above 0
};

/// The settings of a body of this material: spring constants, volume modulus, and the total mass at the
/// settings' scale; all else as in `settings`. Modulus and ratio are those of small deformations, measured on
/// the network: a few linear solves, seconds for 5 000 points. Errors: a network that was not made by
/// buildMaterialNetwork; a value out of range.
Result<SoftBodySettings> withMaterial(const SpringNetwork& network, const Material& material,
                                      SoftBodySettings settings = {});

}  // namespace limber

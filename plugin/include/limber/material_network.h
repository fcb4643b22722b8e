// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_builder.h>
#include <limber/soft_body_settings.h>

namespace limber {

struct MaterialMesh {
  double spacing = 0.0;  ///< m, of the lattice from which the tetrahedra are made; 0: chosen from `points`
  std::uint32_t points = 300;  ///< approximate number of point masses, 8 or more; used when spacing is 0
  Progress progress;  ///< when it returns false, the build ends with an error (there is no partial result)
};

/// Builds the network of a body that behaves like a material. The inside of a closed mesh is filled with
/// tetrahedra. Their edges become springs with constants near  k = E sum V / L^2,  the sum over the
/// tetrahedra around the edge (Van Gelder 1998). The constants are fitted so that the body is equally stiff
/// in all directions, and calibrated once so that the measured Young's modulus equals the requested one
/// (stiffnessPerModulus). Mass fractions follow the volume of the tetrahedra, with a minimum of 0.2 of the
/// mean. The render surface is the mesh with a skin. Concave surfaces are followed to about half a spacing.
/// Errors: those of weld(); a mesh that is not closed (with the number of its open edges) or encloses no
/// volume; a component that is too thin for the lattice; sizes out of range; progress that returned false.
Result<SharedNetwork> buildMaterialNetwork(const TriangleMesh& mesh, const MaterialMesh& settings = {});

struct Material {
  double youngsModulus = 1e5;  ///< Pa, above 0
  double poissonRatio = 0.25;  ///< from 0.25 (about the value of springs alone) to below 0.5 (by the volume
                               ///< term)
  double density = 1000.0;     ///< kg/m^3, above 0
};

/// Returns the settings of a body of this material: spring constants, volume modulus, and the total mass at
/// the scale in `settings`. All other values are those of `settings`. Modulus and ratio hold for small
/// deformations. They are measured on the network with a few linear solves, which take seconds for 5 000
/// points. Errors: a network that was not made by buildMaterialNetwork; a value out of range.
Result<SoftBodySettings> withMaterial(const SpringNetwork& network, const Material& material,
                                      SoftBodySettings settings = {});

}  // namespace limber

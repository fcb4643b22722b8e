// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/spring_network.h>

#include <cstdint>

namespace limber {

/// Which springs are added to the edges of the mesh so that the body keeps its shape.
enum class BraceRule : std::uint8_t {
  None,        ///< the edges alone
  EqualLength  ///< a spring between any two points whose distance is the length of some edge (C. Hart's rule:
               ///< on a cube it adds the second diagonal of each face; on a sphere it adds nothing)
};

struct NetworkSettings {
  double weldTolerance = 0.0;  ///< metres, see weld()
  BraceRule braces = BraceRule::EqualLength;
  double braceWeight = 1.0;  ///< stiffnessScale of braces, above 0
};

/// Solid (or open surface) from a mesh: unique positions become point masses, unique triangle edges become
/// springs, the mass is shared equally. Errors: those of weld(); a brace weight that is not above 0.
Result<SharedNetwork> buildNetwork(const TriangleMesh& mesh, const NetworkSettings& settings = {});

struct RopeSettings {
  double length = 1.0;          ///< metres, along +x from the origin
  std::uint32_t segments = 16;  ///< at least 1; #points = segments + 1
  double bendingScale =
      0.1;  ///< stiffness of the skip-one springs relative to the segments; 0 leaves them out
};

/// A chain of points along +x. Errors: length not above 0, no segments, negative bending.
Result<SharedNetwork> buildRope(const RopeSettings& settings = {});

struct ClothSettings {
  double width = 1.0;          ///< metres along x
  double depth = 1.0;          ///< metres along z
  std::uint32_t columns = 16;  ///< cells along x, at least 1; #points = (columns + 1) * (rows + 1)
  std::uint32_t rows = 16;     ///< cells along z, at least 1
  double shearScale = 0.5;     ///< both diagonals of each cell; 0 leaves them out
  double bendingScale = 0.1;   ///< skip-one springs along x and z; 0 leaves them out
};

/// A sheet in the plane y = 0, centred at the origin, normal +y. Point (column i, row j) has index
/// j * (columns + 1) + i; i runs along +x, j along +z. Errors: sizes not above 0, no cells, negative scales.
///
///     o---o---o     structural: along x and z
///     | X | X |     shear:      both diagonals
///     o---o---o     bending:    o-------o  every second point along x and z
Result<SharedNetwork> buildCloth(const ClothSettings& settings = {});

}  // namespace limber

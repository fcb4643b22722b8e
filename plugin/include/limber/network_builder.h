// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/spring_network.h>

#include <cstdint>
#include <functional>

namespace limber {

/// Rule for the springs that are added to the edges of the mesh so that the body keeps its shape.
enum class BraceRule : std::uint8_t {
  None,         ///< edges only
  EqualLength,  ///< a spring between any two points whose distance equals the length of some edge (C. Hart's
                ///< rule: on a cube it adds the second diagonal of each face; on a sphere it adds nothing)
  TwoRing,      ///< a spring between any two points that share a neighbour
  Pipeline      ///< chords through the inside, then springs against soft modes, then springs against folding
                ///< (bracing.h). Flat and wide open components have no inside and get the two-ring
};

/// Rule for the distribution of the body's mass among its points.
enum class MassRule : std::uint8_t {
  Equal,  ///< equal masses, as in C. Hart's paper
  Area,  ///< in proportion to a third of the area of the triangles around a point, limited to 0.2 to 10 times
         ///< the mean
  Moments  ///< mass, centre of mass and inertia match those of the solid as far as the points allow; each
           ///< point has at least 0.2 times the mean, points of the surface at most 10 times
};

/// Reports the progress of a long computation: its present part, and the fraction done of that part, 0 to 1.
/// The return value false requests an early end.
using Progress = std::function<bool(const char* what, double done)>;

struct NetworkSettings {
  double weldTolerance = 0.0;  ///< metres, see weld()
  BraceRule braces = BraceRule::Pipeline;
  double braceWeight = 0.0;  ///< stiffnessScale of braces, above 0; 0: 0.5 for Pipeline, 1 for the others
  double maxBracesPerPoint = 1.5;  ///< mean over the points of a piece, above 0; only for Pipeline and pieces
                                   ///< that have an inside: flat and open ones get the complete two-ring
  double timeLimit = 0.0;  ///< s; Pipeline adds no more springs after this time; 0: no limit. If the limit is
                           ///< reached, the network depends on the speed of the machine
  std::uint64_t seed = 1;  ///< of the random deformations of Pipeline
  MassRule masses = MassRule::Equal;
  Progress progress;  ///< may be empty; called on the calling thread
};

/// Builds a solid (or open surface) from a mesh: unique positions become point masses, unique triangle edges
/// become springs. Closed surfaces whose normals point inward are flipped, in the surface and in the render
/// surface. Deterministic. Errors: those of weld(); a setting out of range.
Result<SharedNetwork> buildNetwork(const TriangleMesh& mesh, const NetworkSettings& settings = {});

struct RopeSettings {
  double length = 1.0;          ///< metres, along +x from the origin
  std::uint32_t segments = 16;  ///< at least 1; #points = segments + 1
  double bendingScale = 0.1;    ///< stiffness of the skip-one springs relative to the segments; 0 leaves them
                                ///< out
};

/// Builds a chain of points along +x. Errors: length not above 0, no segments, more than ten million points,
/// negative bending scale.
Result<SharedNetwork> buildRope(const RopeSettings& settings = {});

struct ClothSettings {
  double width = 1.0;          ///< metres along x
  double depth = 1.0;          ///< metres along z
  std::uint32_t columns = 16;  ///< cells along x, at least 1; #points = (columns + 1) * (rows + 1)
  std::uint32_t rows = 16;     ///< cells along z, at least 1
  double shearScale = 0.5;     ///< both diagonals of each cell; 0 leaves them out
  double bendingScale = 0.1;   ///< skip-one springs along x and z; 0 leaves them out
};

/// Builds a sheet in the plane y = 0, centred at the origin, normal +y. Point (column i, row j) has the
/// index j * (columns + 1) + i; i increases along +x, j along +z. Errors: sizes not above 0, no cells, more
/// than ten million points, negative scales.
///
///     o---o---o     structural: along x and z
///     | X | X |     shear:      both diagonals
///     o---o---o     bending:    o-------o  every second point along x and z
Result<SharedNetwork> buildCloth(const ClothSettings& settings = {});

}  // namespace limber

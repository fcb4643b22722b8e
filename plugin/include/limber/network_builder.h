// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/spring_network.h>

#include <cstdint>
#include <functional>

namespace limber {

/// Which springs are added to the edges of the mesh so that the body keeps its shape.
enum class BraceRule : std::uint8_t {
  None,         ///< the edges alone
  EqualLength,  ///< a spring between any two points whose distance is the length of some edge (C. Hart's
                ///< rule: on a cube it adds the second diagonal of each face; on a sphere it adds nothing)
  TwoRing,      ///< a spring between any two points that share a neighbour
  Pipeline      ///< chords through the inside, then springs for what is soft, then for what folds: bracing.h.
                ///< Flat and wide open components have no inside and get the two-ring
};

/// How the body's mass is shared among its points.
enum class MassRule : std::uint8_t {
  Equal,   ///< the paper's
  Area,    ///< by a third of the area of the triangles around a point, from 0.2 to 10 times the mean share
  Moments  ///< so that mass, centre of mass and inertia are those of the solid, where the points allow it:
           ///< 0.2 times the mean share and more, at most 10 times for points of the surface
};

/// How far a long work is: what it does, and 0 to 1 of that. Returning false asks it to end early.
using Progress = std::function<bool(const char* what, double done)>;

struct NetworkSettings {
  double weldTolerance = 0.0;  ///< metres, see weld()
  BraceRule braces = BraceRule::Pipeline;
  double braceWeight = 0.0;  ///< stiffnessScale of braces, above 0; 0: 0.5 for Pipeline, 1 for the others
  double maxBracesPerPoint = 1.5;  ///< braces per point at most, above 0; Pipeline only, and there of pieces
                                   ///< that have an inside: flat and open ones get the two-ring whole
  double timeLimit = 0.0;  ///< Pipeline stops adding after this time; 0: never. With a limit that is
                           ///< reached the network depends on the machine's speed.
  std::uint64_t seed = 1;  ///< of the deformations that Pipeline tries
  MassRule masses = MassRule::Equal;
  Progress progress;  ///< called from time to time on the calling thread, or empty
};

/// Solid (or open surface) from a mesh: unique positions become point masses, unique triangle edges become
/// springs. Closed surfaces that face inward are turned, in the surface and as it is drawn. Deterministic.
/// Errors: those of weld(); a setting out of range.
Result<SharedNetwork> buildNetwork(const TriangleMesh& mesh, const NetworkSettings& settings = {});

struct RopeSettings {
  double length = 1.0;          ///< metres, along +x from the origin
  std::uint32_t segments = 16;  ///< at least 1; #points = segments + 1
  double bendingScale =
      0.1;  ///< stiffness of the skip-one springs relative to the segments; 0 leaves them out
};

/// A chain of points along +x. Errors: length not above 0, no segments, more than ten million points,
/// negative bending.
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
/// j * (columns + 1) + i; i runs along +x, j along +z. Errors: sizes not above 0, no cells, more than ten
/// million points, negative scales.
///
///     o---o---o     structural: along x and z
///     | X | X |     shear:      both diagonals
///     o---o---o     bending:    o-------o  every second point along x and z
Result<SharedNetwork> buildCloth(const ClothSettings& settings = {});

}  // namespace limber

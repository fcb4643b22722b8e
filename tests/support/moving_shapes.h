// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/surface_contacts.h"
#include "support/constants.h"

#include <random>

namespace limber::test {

inline constexpr double kMargin = 0.007;  ///< m, search distance for contacts
/// m: positions of about 1 m have a rounding error of 1e-16 m, which a few products multiply.
inline constexpr double kRounding = 1e-12;

/// A surface and its points, at rest until `motion` is set. Call surface() after each change.
struct MovingShape {
  SurfaceTopology topology;
  Points position, motion;  ///< m, m over the tick
  double radius = 0.0;      ///< m
  SurfaceBoxes boxes;

  const MovingSurface& surface();
  void move(const Eigen::Affine3d& by) { position = (by * position).eval(); }
  void setMotion(const Eigen::Vector3d& all) { motion.colwise() = all; }

 private:
  MovingSurface view_;
};

MovingShape makeShape(const Points& points, const SurfaceFeatures& features, double radius);

/// Returns a box around the origin, with 8 points and 12 triangles.
MovingShape boxShape(const Eigen::Vector3d& sizes, double radius, bool rigid = false);
MovingShape sphereShape(double radius);

/// Returns a rope along x from the origin. `length` (m) is that of one segment.
MovingShape ropeShape(int segments, double length, double radius);

/// Returns a cloth in the plane y = 0 around the origin: cells x cells squares of `width` (m), facing up.
MovingShape clothShape(int cells, double width, double radius);

/// Returns the convex hull of random points on the unit sphere.
MovingShape hullShape(int points, double radius, std::mt19937& random);

/// Returns the welded icosphere of small_meshes.
MovingShape ballShape(int splits, double radius);

/// `bearing`: see ContactSearch.
std::vector<SurfaceContact> contactsOf(MovingShape& a, MovingShape& b, double margin,
                                       const std::vector<std::uint64_t>& bearing = {});

Eigen::Vector3d placeAt(const MovingShape& shape, const SurfacePoint& point, double time);

Eigen::Vector3d randomVector(std::mt19937& random);  ///< coordinates from -1 to 1
Eigen::Affine3d randomTurn(std::mt19937& random);

}  // namespace limber::test

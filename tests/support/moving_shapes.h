// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/surface_contacts.h"
#include "support/constants.h"

#include <random>

namespace limber::test {

inline constexpr double kMargin = 0.007;  ///< m, how far apart contacts are searched for
/// m: positions of about 1 m are rounded to 1e-16 of that, and products of a few follow.
inline constexpr double kRounding = 1e-12;

/// A surface with its points: at rest until `motion` is set. Call surface() after each change.
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

/// Around the origin, 8 points and 12 triangles.
MovingShape boxShape(const Eigen::Vector3d& sizes, double radius, bool rigid = false);
MovingShape sphereShape(double radius);

/// Along x from the origin, so many segments of that length.
MovingShape ropeShape(int segments, double length, double radius);

/// In the plane y = 0 around the origin, cells x cells squares of that width, facing up.
MovingShape clothShape(int cells, double width, double radius);

/// The hull of points drawn from the unit sphere's surface.
MovingShape hullShape(int points, double radius, std::mt19937& random);

/// The welded icosphere of small_meshes.
MovingShape ballShape(int splits, double radius);

std::vector<SurfaceContact> contactsOf(MovingShape& a, MovingShape& b, double margin);

Eigen::Vector3d placeAt(const MovingShape& shape, const SurfacePoint& place, double time);

Eigen::Vector3d randomVector(std::mt19937& random);  ///< coordinates from -1 to 1
Eigen::Affine3d randomTurn(std::mt19937& random);

}  // namespace limber::test

// SPDX-License-Identifier: Zlib
#include "support/moving_shapes.h"

#include "support/small_meshes.h"

#include <limber/mesh.h>

#include <gtest/gtest.h>

namespace limber::test {
namespace {

using Eigen::Vector3d;

Points columns(const std::vector<Vector3d>& points) {
  Points result(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) result.col(static_cast<Eigen::Index>(i)) = points[i];
  return result;
}

/// Returns all triples of points with all other points behind their plane. No four points share a plane.
std::vector<Triangle> hullOf(const Points& points) {
  std::vector<Triangle> triangles;
  const auto count = static_cast<std::uint32_t>(points.cols());
  for (std::uint32_t i = 0; i < count; ++i)
    for (std::uint32_t j = 0; j < count; ++j)
      for (std::uint32_t k = 0; k < count; ++k) {
        if (i >= j || i >= k || j == k) continue;
        const Vector3d n = (points.col(j) - points.col(i)).cross(points.col(k) - points.col(i));
        if ((n.transpose() * (points.colwise() - points.col(i))).maxCoeff() < 1e-12)
          triangles.push_back({i, j, k});
      }
  return triangles;
}

}  // namespace

const MovingSurface& MovingShape::surface() {
  view_ = {&topology, &position, &motion, radius, &boxes};
  fitBoxes(view_, boxes);
  return view_;
}

MovingShape makeShape(const Points& points, const SurfaceFeatures& features, double radius) {
  MovingShape shape;
  Result<SurfaceTopology> topology = makeSurfaceTopology(points, features);
  EXPECT_TRUE(topology) << topology.error();
  if (topology) shape.topology = *topology;
  shape.position = points;
  shape.motion = Points::Zero(3, points.cols());
  shape.radius = radius;
  return shape;
}

MovingShape boxShape(const Vector3d& sizes, double radius, bool rigid) {
  Points points(3, 8);
  for (int i = 0; i < 8; ++i)
    points.col(i) = sizes.cwiseProduct(Vector3d(i & 1, i >> 1 & 1, i >> 2) - Vector3d::Constant(0.5));
  SurfaceFeatures features;
  features.rigid = rigid;
  const std::uint32_t quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& q : quads) {
    features.triangles.push_back({q[0], q[1], q[2]});
    features.triangles.push_back({q[0], q[2], q[3]});
  }
  return makeShape(points, features, radius);
}

MovingShape sphereShape(double radius) {
  SurfaceFeatures features;
  features.vertices = {0};
  return makeShape(Points::Zero(3, 1), features, radius);
}

MovingShape ropeShape(int segments, double length, double radius) {
  Points points = Points::Zero(3, segments + 1);
  SurfaceFeatures features;
  for (int i = 0; i <= segments; ++i) points(0, i) = i * length;
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(segments); ++i)
    features.segments.push_back({i, i + 1});
  return makeShape(points, features, radius);
}

MovingShape clothShape(int cells, double width, double radius) {
  const int side = cells + 1;
  Points points = Points::Zero(3, side * side);
  SurfaceFeatures features;
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * side + j); };
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      points.col(at(i, j)) = width * Vector3d(i - 0.5 * cells, 0.0, j - 0.5 * cells);
      if (i == cells || j == cells) continue;
      features.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
      features.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  return makeShape(points, features, radius);
}

MovingShape hullShape(int points, double radius, std::mt19937& random) {
  Points positions(3, points);
  for (int i = 0; i < points; ++i) positions.col(i) = randomTurn(random) * Vector3d::UnitX();
  SurfaceFeatures features;
  features.triangles = hullOf(positions);
  return makeShape(positions, features, radius);
}

MovingShape ballShape(int splits, double radius) {
  const auto welded = weld(small_meshes::icosphere(splits));
  EXPECT_TRUE(welded);
  SurfaceFeatures features;
  features.triangles = welded->triangles;
  return makeShape(columns(welded->points), features, radius);
}

std::vector<SurfaceContact> contactsOf(MovingShape& a, MovingShape& b, double margin,
                                       const std::vector<std::uint64_t>& bearing) {
  ContactSearch search;
  search.bearing = bearing;
  std::vector<SurfaceContact> found;
  findSurfaceContacts(a.surface(), b.surface(), margin, search, found);
  return found;
}

Vector3d placeAt(const MovingShape& shape, const SurfacePoint& point, double time) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    sum += point.weights[static_cast<Eigen::Index>(i)] *
           (shape.position.col(point.points[i]) + time * shape.motion.col(point.points[i]));
  return sum;
}

Vector3d randomVector(std::mt19937& random) {
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  const double x = coordinate(random), y = coordinate(random);
  return {x, y, coordinate(random)};
}

Eigen::Affine3d randomTurn(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double w = normal(random), x = normal(random), y = normal(random);
  return Eigen::Affine3d(Eigen::Quaterniond(w, x, y, normal(random)).normalized());
}

}  // namespace limber::test

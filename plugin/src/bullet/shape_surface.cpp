// SPDX-License-Identifier: Zlib
#include "bullet/shape_surface.h"

#include "bullet/bullet_objects.h"

#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;
using Corners = std::vector<Vector3d>;

/// Of a round shape: the polyhedron's faces are at most 0.12 % of its radius within it.
constexpr int kAround = 64;

/// Edges between triangles whose normals are closer than this (cosine) are flat.
constexpr double kFlat = 0.9999;

Points pointsOf(const Corners& corners) {
  Points points(3, static_cast<Eigen::Index>(corners.size()));
  for (std::size_t i = 0; i < corners.size(); ++i) points.col(static_cast<Eigen::Index>(i)) = corners[i];
  return points;
}

Vector3d normalOf(const SurfaceTopology& topology, std::uint32_t triangle) {
  const Triangle& t = topology.triangles[triangle];
  const Points& x = topology.rest;
  return (x.col(t[1]) - x.col(t[0])).cross(x.col(t[2]) - x.col(t[0])).normalized();
}

bool isFlat(const SurfaceTopology& topology, std::uint32_t edge) {
  const auto& sides = topology.edgeTriangles[edge];
  if (sides[0] == kNoFeature || sides[1] == kNoFeature) return false;
  return normalOf(topology, sides[0]).dot(normalOf(topology, sides[1])) > kFlat;
}

/// An empty surface if the shape is degenerate.
ShapeSurface surfaceOf(const Corners& corners, const SurfaceFeatures& features, double radius) {
  ShapeSurface surface;
  Result<SurfaceTopology> topology = makeSurfaceTopology(pointsOf(corners), features);
  if (!topology) return surface;
  surface.topology = std::move(*topology);
  surface.radius = radius;
  for (std::uint32_t e = 0; e < surface.topology.edges.size(); ++e)
    if (!isFlat(surface.topology, e)) surface.sharpEdges.push_back(e);
  return surface;
}

SurfaceFeatures rigidFeatures() {
  SurfaceFeatures features;
  features.rigid = true;
  return features;
}

/// The corners of a face of a hull, in order, as a fan of triangles.
void addFace(const btConvexHullComputer& hull, int face, SurfaceFeatures& features) {
  const btConvexHullComputer::Edge* first = &hull.edges[face];
  const auto corner = [](const btConvexHullComputer::Edge* edge) {
    return static_cast<std::uint32_t>(edge->getSourceVertex());
  };
  for (const auto* edge = first->getNextEdgeOfFace(); edge->getNextEdgeOfFace() != first;
       edge = edge->getNextEdgeOfFace())
    features.triangles.push_back({corner(first), corner(edge), corner(edge->getNextEdgeOfFace())});
}

ShapeSurface hullOf(const std::vector<btVector3>& points, double radius) {
  btConvexHullComputer hull;
  hull.compute(&points[0].x(), static_cast<int>(sizeof(btVector3)), static_cast<int>(points.size()), 0, 0);
  Corners corners;
  Vector3d center = Vector3d::Zero();
  for (int i = 0; i < hull.vertices.size(); ++i) corners.push_back(toEigen(hull.vertices[i]));
  for (const Vector3d& corner : corners) center += corner / static_cast<double>(corners.size());
  SurfaceFeatures features = rigidFeatures();
  for (int i = 0; i < hull.faces.size(); ++i) addFace(hull, hull.faces[i], features);
  for (Triangle& t : features.triangles) {
    const Vector3d normal = (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]);
    if (normal.dot(corners[t[0]] - center) < 0.0) std::swap(t[1], t[2]);
  }
  return surfaceOf(corners, features, radius);
}

ShapeSurface sphereSurface(const btSphereShape& sphere) {
  SurfaceFeatures features = rigidFeatures();
  features.vertices = {0};
  return surfaceOf({Vector3d::Zero()}, features, double(sphere.getRadius()));
}

ShapeSurface capsuleSurface(const btCapsuleShape& capsule) {
  SurfaceFeatures features = rigidFeatures();
  features.segments = {{0, 1}};
  Vector3d half = Vector3d::Zero();
  half[capsule.getUpAxis()] = double(capsule.getHalfHeight());
  return surfaceOf({-half, half}, features, double(capsule.getRadius()));
}

ShapeSurface boxSurface(const btBoxShape& box) {
  const btVector3 half = box.getHalfExtentsWithMargin();
  std::vector<btVector3> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(),
                         i & 4 ? half.z() : -half.z());
  return hullOf(corners, 0.0);
}

ShapeSurface polyhedronSurface(const btPolyhedralConvexShape& shape) {
  std::vector<btVector3> corners(static_cast<std::size_t>(shape.getNumVertices()));
  for (int i = 0; i < shape.getNumVertices(); ++i) shape.getVertex(i, corners[static_cast<std::size_t>(i)]);
  return hullOf(corners, double(shape.getMargin()));
}

/// Directions on circles around an axis: every one of a round shape's rims is met kAround times.
ShapeSurface roundSurface(const btConvexShape& shape, int axis) {
  std::vector<btVector3> corners;
  for (int ring = -8; ring <= 8; ++ring)
    for (int i = 0; i < kAround; ++i) {
      const double height = ring * double(SIMD_HALF_PI) / 8.5, angle = 2.0 * double(SIMD_PI) * i / kAround;
      btVector3 direction(0, 0, 0);
      direction[axis] = static_cast<btScalar>(std::sin(height));
      direction[(axis + 1) % 3] = static_cast<btScalar>(std::cos(height) * std::cos(angle));
      direction[(axis + 2) % 3] = static_cast<btScalar>(std::cos(height) * std::sin(angle));
      corners.push_back(shape.localGetSupportingVertex(direction));
    }
  return hullOf(corners, 0.0);
}

int axisOf(const btConvexShape& shape) {
  if (shape.getShapeType() == CYLINDER_SHAPE_PROXYTYPE)
    return static_cast<const btCylinderShape&>(shape).getUpAxis();
  if (shape.getShapeType() == CONE_SHAPE_PROXYTYPE)
    return static_cast<const btConeShape&>(shape).getConeUpIndex();
  return 1;
}

/// Collects triangles; corners in exactly the same place are one.
struct TriangleList final : btInternalTriangleIndexCallback, btTriangleCallback {
  struct Less {
    bool operator()(const Vector3d& a, const Vector3d& b) const {
      return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    }
  };
  std::map<Vector3d, std::uint32_t, Less> numbers;
  Corners corners;
  std::vector<Triangle> triangles;

  std::uint32_t numberOf(const Vector3d& corner) {
    const auto [it, isNew] = numbers.try_emplace(corner, static_cast<std::uint32_t>(corners.size()));
    if (isNew) corners.push_back(corner);
    return it->second;
  }
  void processTriangle(btVector3* triangle, int, int) override {
    Triangle t;
    for (std::size_t i = 0; i < 3; ++i) t[i] = numberOf(toEigen(triangle[i]));
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
  }
  void internalProcessTriangleIndex(btVector3* triangle, int part, int index) override {
    processTriangle(triangle, part, index);
  }
};

/// Bullet tells no vertices of these.
ShapeSurface triangleMeshHull(const btConvexTriangleMeshShape& shape) {
  TriangleList list;
  const btVector3 most(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
  shape.getMeshInterface()->InternalProcessAllTriangles(&list, -most, most);
  std::vector<btVector3> corners;
  for (const Vector3d& corner : list.corners) corners.push_back(toBullet(corner));
  return corners.empty() ? ShapeSurface() : hullOf(corners, double(shape.getMargin()));
}

}  // namespace

ShapeSurface makeShapeSurface(const btCollisionShape& shape) {
  switch (shape.getShapeType()) {
    case SPHERE_SHAPE_PROXYTYPE:
      return sphereSurface(static_cast<const btSphereShape&>(shape));
    case CAPSULE_SHAPE_PROXYTYPE:
      return capsuleSurface(static_cast<const btCapsuleShape&>(shape));
    case BOX_SHAPE_PROXYTYPE:
      return boxSurface(static_cast<const btBoxShape&>(shape));
    case CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE:
      return triangleMeshHull(static_cast<const btConvexTriangleMeshShape&>(shape));
    default:
      break;
  }
  if (!shape.isConvex()) return {};
  // of a mesh that Bullet treats as convex it does not know the corners
  if (shape.isPolyhedral() && static_cast<const btPolyhedralConvexShape&>(shape).getNumVertices() > 0)
    return polyhedronSurface(static_cast<const btPolyhedralConvexShape&>(shape));
  const auto& convex = static_cast<const btConvexShape&>(shape);
  return roundSurface(convex, axisOf(convex));
}

ShapeSurface makePatchSurface(const btConcaveShape& shape, const btVector3& low, const btVector3& high) {
  TriangleList list;
  shape.processAllTriangles(&list, low, high);
  SurfaceFeatures features = rigidFeatures();
  features.triangles = std::move(list.triangles);
  return surfaceOf(list.corners, features, double(shape.getMargin()));
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

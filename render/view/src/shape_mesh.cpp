// SPDX-License-Identifier: Zlib
#include "limber/view/shape_mesh.h"

#include "limber/view/convert.h"

#include <BulletCollision/CollisionShapes/btShapeHull.h>
#include <btBulletCollisionCommon.h>

#include <array>
#include <cstdint>
#include <map>

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using render::Scenery;

/// Half the side of the shown piece of a plane, and of the box in which the triangles of a mesh are
/// collected, m.
constexpr float kPlaneHalfSize = 50.0f;
constexpr double kFar = 1e6;

/// Of a capsule. The number of rings is odd, so that none lies at the equator.
constexpr std::uint32_t kRings = 17, kSegments = 32;

void append(Scenery& mesh, const Scenery& part, const btTransform& transform) {
  const std::uint32_t first = mesh.shape.pointCount;
  for (std::size_t i = 0; i < part.points.size(); i += 3) {
    const render::Vec3 p =
        toVec3(transform * btVector3(btScalar(part.points[i]), btScalar(part.points[i + 1]),
                                     btScalar(part.points[i + 2])));
    mesh.points.insert(mesh.points.end(), {p.x, p.y, p.z});
  }
  mesh.shape.pointCount += part.shape.pointCount;
  for (const std::uint32_t vertex : part.shape.triangles) {
    const bool isPoint = part.shape.vertexToPoint.empty();
    mesh.shape.triangles.push_back(first + (isPoint ? vertex : part.shape.vertexToPoint[vertex]));
  }
}

Scenery capsuleMesh(const btCapsuleShape& capsule) {
  Scenery mesh = render::makeUvSphere({}, float(capsule.getRadius()), kRings, kSegments);
  const int up = capsule.getUpAxis();
  for (std::size_t i = 0; i < mesh.points.size(); i += 3) {
    float* p = mesh.points.data() + i;
    p[1] += (p[1] > 0.0f ? 1.0f : -1.0f) * float(capsule.getHalfHeight());
    // rotate the axes, do not swap two of them: a mirrored mesh would show its inside
    const std::array<float, 3> y{p[0], p[1], p[2]};
    if (up == 0) p[0] = y[1], p[1] = y[2], p[2] = y[0];
    if (up == 2) p[0] = y[2], p[1] = y[0], p[2] = y[1];
  }
  return mesh;
}

Scenery hullMesh(const btConvexShape& convex) {
  constexpr int kFine = 1;
  btShapeHull hull(&convex);
  Scenery mesh;
  if (!hull.buildHull(convex.getMargin(), kFine)) return mesh;
  mesh.shape.pointCount = static_cast<std::uint32_t>(hull.numVertices());
  for (int i = 0; i < hull.numVertices(); ++i) {
    const render::Vec3 p = toVec3(hull.getVertexPointer()[i]);
    mesh.points.insert(mesh.points.end(), {p.x, p.y, p.z});
  }
  mesh.shape.triangles.assign(hull.getIndexPointer(), hull.getIndexPointer() + hull.numIndices());
  return mesh;
}

/// Corners at the same place become one point.
struct TriangleCollector final : btTriangleCallback {
  Scenery mesh;
  std::map<std::array<float, 3>, std::uint32_t> places;
  void processTriangle(btVector3* corners, int, int) override {
    for (int k = 0; k < 3; ++k) {
      const render::Vec3 p = toVec3(corners[k]);
      const auto [found, isNew] = places.try_emplace({p.x, p.y, p.z}, mesh.shape.pointCount);
      if (isNew) {
        mesh.points.insert(mesh.points.end(), {p.x, p.y, p.z});
        ++mesh.shape.pointCount;
      }
      mesh.shape.triangles.push_back(found->second);
    }
  }
};

Scenery concaveMesh(const btConcaveShape& concave) {
  TriangleCollector collector;
  const btVector3 far(kFar, kFar, kFar);
  concave.processAllTriangles(&collector, -far, far);
  // triangle meshes collide on both sides
  collector.mesh.shape.twoSided = true;
  return collector.mesh;
}

Scenery planeMesh(const btStaticPlaneShape& plane) {
  Scenery floor = render::makeFloor({}, kPlaneHalfSize);
  const btVector3 up = plane.getPlaneNormal();
  const btTransform transform(shortestArcQuat(btVector3(0, 1, 0), up), plane.getPlaneConstant() * up);
  Scenery rotated = floor;
  rotated.points.clear();
  rotated.shape.pointCount = 0;
  rotated.shape.triangles.clear();
  append(rotated, floor, transform);
  return rotated;
}

Scenery compoundMesh(const btCompoundShape& compound) {
  Scenery mesh;
  for (int i = 0; i < compound.getNumChildShapes(); ++i) {
    const Scenery child = meshOf(*compound.getChildShape(i));
    append(mesh, child, compound.getChildTransform(i));
    mesh.shape.twoSided |= child.shape.twoSided;
  }
  return mesh;
}

Scenery surfaceOf(const btCollisionShape& shape) {
  if (shape.isCompound()) return compoundMesh(static_cast<const btCompoundShape&>(shape));
  switch (shape.getShapeType()) {
    case BOX_SHAPE_PROXYTYPE:
      return render::makeBox({}, toVec3(static_cast<const btBoxShape&>(shape).getHalfExtentsWithMargin()));
    case SPHERE_SHAPE_PROXYTYPE:
      return render::makeUvSphere({}, float(static_cast<const btSphereShape&>(shape).getRadius()));
    case CAPSULE_SHAPE_PROXYTYPE:
      return capsuleMesh(static_cast<const btCapsuleShape&>(shape));
    case STATIC_PLANE_PROXYTYPE:
      return planeMesh(static_cast<const btStaticPlaneShape&>(shape));
    default:
      break;
  }
  if (shape.isConvex()) return hullMesh(static_cast<const btConvexShape&>(shape));
  if (shape.isConcave()) return concaveMesh(static_cast<const btConcaveShape&>(shape));
  return {};
}

}  // namespace

render::Scenery meshOf(const btCollisionShape& shape) {
  render::Scenery mesh = surfaceOf(shape);
  mesh.shape.name = shape.getName();
  return mesh;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view

// SPDX-License-Identifier: Zlib

// This file makes and caches the surfaces of Bullet's shapes, and moves those of the rigid objects near soft
// bodies to their positions in a tick.

#include "bullet/kinematic_motion.h"
#include "bullet/point_contacts.h"
#include "bullet/tick_contacts.h"

#include <LinearMath/btConvexHullComputer.h>

#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>
#include <utility>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- surfaces of shapes ------------------------------------------------------------------------------------

namespace {

using Eigen::Vector3d;
using Corners = std::vector<Vector3d>;

/// Corners around a round shape. The polyhedron's faces are inside it by at most 0.48 % of its radius.
constexpr int kCornersAround = 32;

/// Cosine of an angle. Edges between triangles with a smaller angle between their normals are flat.
constexpr double kFlatTolerance = 0.9999;

Vector3d normalOf(const SurfaceTopology& topology, std::uint32_t triangle) {
  const Triangle& t = topology.triangles[triangle];
  const Points& x = topology.rest;
  return (x.col(t[1]) - x.col(t[0])).cross(x.col(t[2]) - x.col(t[0])).normalized();
}

bool isFlat(const SurfaceTopology& topology, std::uint32_t edge) {
  const auto& sides = topology.edgeTriangles[edge];
  if (sides[0] == kNoFeature || sides[1] == kNoFeature) return false;
  return normalOf(topology, sides[0]).dot(normalOf(topology, sides[1])) > kFlatTolerance;
}

/// Returns an empty surface if the shape is degenerate.
ShapeSurface surfaceOf(const Corners& corners, SurfaceFeatures features, double radius) {
  ShapeSurface surface;
  if (corners.empty()) return surface;
  features.rigid = true;
  const Eigen::Map<const Points> points(corners[0].data(), 3, static_cast<Eigen::Index>(corners.size()));
  Result<SurfaceTopology> topology = makeSurfaceTopology(points, features);
  if (!topology) return surface;
  surface.topology = std::move(*topology);
  surface.radius = radius;
  for (std::uint32_t e = 0; e < surface.topology.edges.size(); ++e)
    if (!isFlat(surface.topology, e)) surface.sharpEdges.push_back(e);
  return surface;
}

/// Adds a face of a hull as a fan of triangles.
void addFace(const btConvexHullComputer& hull, int face, SurfaceFeatures& features) {
  const btConvexHullComputer::Edge* first = &hull.edges[face];
  const auto corner = [](const btConvexHullComputer::Edge* edge) {
    return static_cast<std::uint32_t>(edge->getSourceVertex());
  };
  for (const auto* edge = first->getNextEdgeOfFace(); edge->getNextEdgeOfFace() != first;
       edge = edge->getNextEdgeOfFace())
    features.triangles.push_back({corner(first), corner(edge), corner(edge->getNextEdgeOfFace())});
}

/// Returns the vertices of the hull of the points. Bullet rounds them to 1e-4 of the hull's size: edges would
/// be inside the solid, which then covers their contacts. So each is the point nearest to it, unless that is
/// another vertex already.
Corners cornersOf(const btConvexHullComputer& hull, const std::vector<btVector3>& points) {
  Corners corners;
  std::vector<unsigned char> taken(points.size(), 0);
  for (int i = 0; i < hull.vertices.size(); ++i) {
    const btVector3& vertex = hull.vertices[i];
    const auto nearest = std::min_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
      return a.distance2(vertex) < b.distance2(vertex);
    });
    const bool isFree = !std::exchange(taken[static_cast<std::size_t>(nearest - points.begin())], 1);
    corners.push_back(toEigen(isFree ? *nearest : vertex));
  }
  return corners;
}

ShapeSurface hullOf(const std::vector<btVector3>& points, double radius) {
  if (points.empty()) return {};
  btConvexHullComputer hull;
  hull.compute(&points[0].x(), static_cast<int>(sizeof(btVector3)), static_cast<int>(points.size()), 0, 0);
  const Corners corners = cornersOf(hull, points);
  Vector3d center = Vector3d::Zero();
  for (const Vector3d& corner : corners) center += corner / static_cast<double>(corners.size());
  SurfaceFeatures features;
  for (int i = 0; i < hull.faces.size(); ++i) addFace(hull, hull.faces[i], features);
  for (Triangle& t : features.triangles) {
    const Vector3d normal = (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]);
    if (normal.dot(corners[t[0]] - center) < 0.0) std::swap(t[1], t[2]);
  }
  return surfaceOf(corners, features, radius);
}

ShapeSurface sphereSurface(const btSphereShape& sphere) {
  SurfaceFeatures features;
  features.vertices = {0};
  return surfaceOf({Vector3d::Zero()}, features, double(sphere.getRadius()));
}

ShapeSurface capsuleSurface(const btCapsuleShape& capsule) {
  SurfaceFeatures features;
  features.segments = {{0, 1}};
  Vector3d half = Vector3d::Zero();
  half[capsule.getUpAxis()] = double(capsule.getHalfHeight());
  return surfaceOf({-half, half}, features, double(capsule.getRadius()));
}

ShapeSurface boxSurface(const btBoxShape& box) {
  const btVector3 half = box.getHalfExtentsWithMargin();
  std::vector<btVector3> corners;
  corners.reserve(8);
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(),
                         i & 4 ? half.z() : -half.z());
  return hullOf(corners, 0.0);
}

/// Calls visit(corner) for the corners of a polyhedron. Returns whether there are any: not for round shapes,
/// nor for a mesh that Bullet treats as convex.
template <class Visit>
bool forEachCorner(const btCollisionShape& shape, Visit visit) {
  if (!shape.isPolyhedral()) return false;
  const auto& polyhedron = static_cast<const btPolyhedralConvexShape&>(shape);
  for (int i = 0; i < polyhedron.getNumVertices(); ++i) {
    btVector3 corner;
    polyhedron.getVertex(i, corner);
    visit(corner);
  }
  return polyhedron.getNumVertices() > 0;
}

/// Adds the ends of all spheres along the axes: bodies rest on level spheres at their height. One supporting
/// vertex would be on one of the spheres alone.
void addEnds(const btMultiSphereShape& shape, std::vector<btVector3>& corners) {
  const btVector3& scaling = shape.getLocalScaling();
  for (int i = 0; i < shape.getSphereCount(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      for (const btScalar side : {btScalar(-1), btScalar(1)}) {
        btVector3 end = shape.getSpherePosition(i);
        end[axis] += side * shape.getSphereRadius(i);
        corners.push_back(end * scaling);
      }
}

/// Angles (degrees) of directions above the equator. Those of multi-spheres, whose profile may be any, are
/// even. Cylinders and cones only have rims, rounded by their margin, and caps: the first and the last
/// direction find the side and the cap, others divide the rim.
constexpr double kAnyProfile[] = {0, 10.6, 21.2, 31.8, 42.4, 52.9, 63.5, 74.1, 84.7};
constexpr double kRims[] = {0.5, 22.5, 45, 67.5, 89.5};

/// Takes the shape's supporting vertices in directions on circles around the axis. Every rim of a round shape
/// gets kCornersAround of them.
ShapeSurface roundSurface(const btConvexShape& shape, int axis) {
  std::vector<btVector3> corners;
  const auto addRing = [&](double degrees) {
    const double height = degrees * double(SIMD_RADS_PER_DEG);
    for (int i = 0; i < kCornersAround; ++i) {
      const double angle = 2.0 * double(SIMD_PI) * i / kCornersAround;
      btVector3 direction(0, 0, 0);
      direction[axis] = static_cast<btScalar>(std::sin(height));
      direction[(axis + 1) % 3] = static_cast<btScalar>(std::cos(height) * std::cos(angle));
      direction[(axis + 2) % 3] = static_cast<btScalar>(std::cos(height) * std::sin(angle));
      corners.push_back(shape.localGetSupportingVertex(direction));
    }
  };
  const auto addRings = [&](const auto& above) {
    for (const double degrees : above) addRing(-degrees), addRing(degrees);
  };
  if (shape.getShapeType() == MULTI_SPHERE_SHAPE_PROXYTYPE)
    addEnds(static_cast<const btMultiSphereShape&>(shape), corners), addRings(kAnyProfile);
  else
    addRings(kRims);
  return hullOf(corners, 0.0);
}

/// Marks the edges along the side: those of triangles that all face away from the axis.
void findSide(const btCylinderShape& cylinder, int axis, ShapeSurface& surface) {
  constexpr double kFacing = 0.01;  // cosine, less than half of that of a rim's triangles
  const SurfaceTopology& t = surface.topology;
  surface.sideRadius = std::min(double(cylinder.getHalfExtentsWithMargin()[(axis + 1) % 3]),
                                double(cylinder.getHalfExtentsWithMargin()[(axis + 2) % 3]));
  surface.sideEdges.assign(t.edges.size(), 0);
  const auto isOnSide = [&](std::uint32_t triangle) {
    return triangle != kNoFeature && std::abs(normalOf(t, triangle)[axis]) < kFacing;
  };
  for (std::size_t e = 0; e < t.edges.size(); ++e) {
    const auto& [first, second] = t.edgeTriangles[e];
    surface.sideEdges[e] = isOnSide(first) && isOnSide(second);
  }
}

int axisOf(const btConvexShape& shape) {
  if (shape.getShapeType() == CYLINDER_SHAPE_PROXYTYPE)
    return static_cast<const btCylinderShape&>(shape).getUpAxis();
  if (shape.getShapeType() == CONE_SHAPE_PROXYTYPE)
    return static_cast<const btConeShape&>(shape).getConeUpIndex();
  return 1;
}

/// Collects triangles. Corners at exactly the same position are one.
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

const btVector3 kLargestBox(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);

/// Makes the hull from the mesh, because Bullet does not return the vertices of such a shape.
ShapeSurface triangleMeshHull(const btConvexTriangleMeshShape& shape) {
  TriangleList list;
  shape.getMeshInterface()->InternalProcessAllTriangles(&list, -kLargestBox, kLargestBox);
  std::vector<btVector3> corners;
  for (const Vector3d& corner : list.corners) corners.push_back(toBullet(corner));
  return hullOf(corners, double(shape.getMargin()));
}

/// Returns whether the shape is a mesh that may also move freely.
bool isDynamicMesh(const btCollisionShape& shape) { return shape.getShapeType() == GIMPACT_SHAPE_PROXYTYPE; }

/// Returns the triangles that overlap a box in the shape's coordinates. They are two-sided.
ShapeSurface sheetSurface(const btConcaveShape& shape, const btVector3& low, const btVector3& high) {
  TriangleList list;
  shape.processAllTriangles(&list, low, high);
  SurfaceFeatures features;
  features.triangles = std::move(list.triangles);
  return surfaceOf(list.corners, features, double(shape.getMargin()));
}

/// Returns an empty surface for shapes without edges and vertices (planes), static meshes and compounds.
ShapeSurface makeShapeSurface(const btCollisionShape& shape) {
  switch (shape.getShapeType()) {
    case GIMPACT_SHAPE_PROXYTYPE:
      return sheetSurface(static_cast<const btConcaveShape&>(shape), -kLargestBox, kLargestBox);
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
  std::vector<btVector3> corners;
  if (forEachCorner(shape, [&](const btVector3& corner) { corners.push_back(corner); }))
    return hullOf(corners, double(shape.getMargin()));
  const auto& convex = static_cast<const btConvexShape&>(shape);
  ShapeSurface surface = roundSurface(convex, axisOf(convex));
  if (shape.getShapeType() == CYLINDER_SHAPE_PROXYTYPE)
    findSide(static_cast<const btCylinderShape&>(shape), axisOf(convex), surface);
  return surface;
}

}  // namespace

LocalBox localBoxOf(const btTransform& pose, const Vector3d& low, const Vector3d& high) {
  LocalBox box;
  btTransformAabb(toBullet(low), toBullet(high), btScalar(0), pose.inverse(), box.low, box.high);
  return box;
}

// --- cached shapes -----------------------------------------------------------------------------------------

namespace {

void addToHash(std::uint64_t& hash, std::uint64_t value) {
  hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
  hash ^= hash >> 29;
}

void addVector(std::uint64_t& hash, const btVector3& v) {
  for (int i = 0; i < 3; ++i) {
    const double value = double(v[i]);
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    addToHash(hash, bits);
  }
}

/// Adds supporting vertices, which distinguish round shapes with the same bounding box, as cylinders along
/// different axes.
void addSupports(std::uint64_t& hash, const btConvexShape& shape) {
  for (int i = 0; i < 8; ++i)
    addVector(hash, shape.localGetSupportingVertex(btVector3(i & 1 ? btScalar(1) : btScalar(-1),
                                                             i & 2 ? btScalar(0.8) : btScalar(-0.8),
                                                             i & 4 ? btScalar(0.6) : btScalar(-0.6))));
}

/// Returns a hash of the triangles that overlap a box in the shape's coordinates, and of `seed`.
std::uint64_t hashOfTriangles(const btConcaveShape& shape, const btVector3& low, const btVector3& high,
                              std::uint64_t seed) {
  struct Hasher final : btTriangleCallback {
    std::uint64_t hash;
    void processTriangle(btVector3* triangle, int, int) override {
      for (int i = 0; i < 3; ++i) addVector(hash, triangle[i]);
    }
  };
  Hasher hasher;
  hasher.hash = seed;
  shape.processAllTriangles(&hasher, low, high);
  return hasher.hash;
}

/// Returns a hash of all that defines a convex shape or a GImpact mesh: type, margin and corners, with
/// scaling.
std::uint64_t hashOfShape(const btCollisionShape& shape) {
  std::uint64_t hash = static_cast<std::uint64_t>(shape.getShapeType());
  btVector3 low, high;
  shape.getAabb(btTransform::getIdentity(), low, high);
  for (const btVector3& v : {low, high, btVector3(shape.getMargin(), 0, 0)}) addVector(hash, v);
  if (isDynamicMesh(shape))
    return hashOfTriangles(static_cast<const btConcaveShape&>(shape), -kLargestBox, kLargestBox, hash);
  const int type = shape.getShapeType();
  // the bounding box defines the shape
  if (type == BOX_SHAPE_PROXYTYPE || type == SPHERE_SHAPE_PROXYTYPE || !shape.isConvex()) return hash;
  if (!forEachCorner(shape, [&](const btVector3& corner) { addVector(hash, corner); }))
    addSupports(hash, static_cast<const btConvexShape&>(shape));
  return hash;
}

}  // namespace

std::uint64_t stampOf(const btCollisionObject& object) {
  const btCollisionShape& shape = *object.getCollisionShape();
  if (!shape.isConvex()) return 0;
  std::uint64_t hash = hashOfShape(shape);
  for (const std::uint64_t part :
       {std::uint64_t{reinterpret_cast<std::uintptr_t>(&object)},
        std::uint64_t{reinterpret_cast<std::uintptr_t>(&shape)}, static_cast<std::uint64_t>(idOf(object))})
    addToHash(hash, part);
  return hash | 1;
}

const ShapeSurface& ShapeCache::surfaceOf(const btCollisionShape& shape) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = entries_[&shape];
  // others may hold the surface until the tick is over
  if (entry.surface && std::exchange(entry.lastUsed, tick_) == tick_) return *entry.surface;
  entry.lastUsed = tick_;
  const std::uint64_t hash = hashOfShape(shape);
  if (!entry.surface || entry.hash != hash) {
    entry.hash = hash;
    entry.surface = std::make_unique<ShapeSurface>(makeShapeSurface(shape));
  }
  return *entry.surface;
}

std::unique_lock<std::mutex> ShapeCache::lockMesh(const btCollisionShape& shape) {
  return isDynamicMesh(shape) ? std::unique_lock<std::mutex>(mutex_) : std::unique_lock<std::mutex>();
}

void ShapeCache::forgetOld() {
  constexpr std::uint64_t kLongTime = 512;
  if (++tick_ % kLongTime != 0) return;
  for (auto it = entries_.begin(); it != entries_.end();)
    it = it->second.lastUsed + kLongTime < tick_ ? entries_.erase(it) : std::next(it);
}

// --- surfaces of objects in a tick -------------------------------------------------------------------------

namespace {

/// Returns the displacement (m) of a point of the object in a tick.
Vector3d motionOf(const btCollisionObject& object, const Vector3d& position, double tick) {
  const btRigidBody* rigid = btRigidBody::upcast(&object);
  Vector3d motion = tick * velocityOf(object, toBullet(position), tick);
  if (rigid && isFree(*rigid)) motion += fallOf(*rigid, tick);
  return motion;
}

/// Returns `box` enlarged by the object's motion. It contains, at the time of the object's pose, all points
/// of the object that enter `box` within the tick. The motion is linear in the position, so no point moves
/// farther than the farthest corner of the object's bounds.
SweptBox enlargedByMotion(const btCollisionObject& object, SweptBox box, double tick) {
  const Eigen::AlignedBox3d bounds = boxOf(object);
  Vector3d largest = Vector3d::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d position = bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    largest = largest.cwiseMax(motionOf(object, position, tick).cwiseAbs());
  }
  box.low.head<3>() -= largest.array();
  box.high.head<3>() += largest.array();
  return box;
}

/// Makes the part with the shape's surface at a pose. motionOf(position) is the displacement (m) of a point.
template <class MotionOf>
void placePart(RigidPart& part, const ShapeSurface& surface, const btTransform& pose, MotionOf motionOf) {
  const Points& rest = surface.topology.rest;
  part.surface = &surface;
  part.moved = false;
  part.position.resize(3, rest.cols());
  part.motion.resize(3, rest.cols());
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    const Vector3d position = worldPoint(pose, rest.col(i));
    part.position.col(i) = position;
    part.motion.col(i) = motionOf(position);
  }
  part.moving = {&surface.topology, &part.position, &part.motion, surface.radius, &part.boxes};
  fitBoxes(part.moving, part.boxes);
}

void storeStart(RigidPart& part) {
  if (part.moved) return;
  part.start = part.position;
  part.whole = part.motion;
  part.moved = true;
}

}  // namespace

void movePart(RigidPart& part, double share, double ahead) {
  storeStart(part);
  part.position = part.start + share * part.whole;
  part.motion = ahead * part.whole;
  fitBoxes(part.moving, part.boxes);
}

void movePart(RigidPart& part, const btTransform& from, const RigidState& to, double ahead) {
  storeStart(part);
  const Eigen::Matrix3d rotation = (to.rotation * toEigen(from.getRotation()).conjugate()).toRotationMatrix();
  const Vector3d origin = toEigen(from.getOrigin());
  for (Eigen::Index i = 0; i < part.start.cols(); ++i) {
    const Vector3d arm = rotation * (part.start.col(i) - origin);
    part.position.col(i) = to.position + arm;
    part.motion.col(i) = ahead * to.velocityAt(arm);
  }
  fitBoxes(part.moving, part.boxes);
}

void RigidSurfaces::clear() {
  for (const std::size_t index : usedIndices_) partsOfObject_[index].clear();
  usedIndices_.clear();
  used_ = 0;
  shapes_->forgetOld();
}

bool RigidSurfaces::hasParts(const btCollisionShape& shape) {
  if (shape.isConvex() || isDynamicMesh(shape)) return !shapes_->surfaceOf(shape).topology.elements.empty();
  if (!shape.isCompound()) return false;
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int i = 0; i < compound.getNumChildShapes(); ++i)
    if (hasParts(*compound.getChildShape(i))) return true;
  return false;
}

const std::vector<RigidPart*>& RigidSurfaces::partsNear(const btCollisionObject& object, const SweptBox& box,
                                                        double tick) {
  near_.clear();
  const btCollisionShape& shape = *object.getCollisionShape();
  const SweptBox enlarged = shape.isCompound() ? enlargedByMotion(object, box, tick) : box;
  addNear(object, shape, object.getWorldTransform(), 0, enlarged, tick);
  return near_;
}

void RigidSurfaces::addNear(const btCollisionObject& object, const btCollisionShape& shape,
                            const btTransform& pose, std::uint64_t number, const SweptBox& box, double tick) {
  if (shape.isConvex() || isDynamicMesh(shape)) return addPart(object, shape, pose, number, tick);
  if (!shape.isCompound()) return;
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  const std::size_t first = children_.size();
  forEachChildIn(localBoxOf(pose, box.low.head<3>(), box.high.head<3>()), compound,
                 [&](int child) { children_.push_back(child); });
  std::sort(children_.begin() + static_cast<std::ptrdiff_t>(first), children_.end());
  for (std::size_t i = first, end = children_.size(); i < end; ++i) {
    const int child = children_[i];
    const std::uint64_t childNumber = number * 0x100000001b3u + static_cast<std::uint64_t>(child) + 1;
    addNear(object, *compound.getChildShape(child), pose * compound.getChildTransform(child), childNumber,
            box, tick);
  }
  children_.resize(first);
}

void RigidSurfaces::addPart(const btCollisionObject& object, const btCollisionShape& shape,
                            const btTransform& pose, std::uint64_t number, double tick) {
  const auto index = static_cast<std::size_t>(object.getWorldArrayIndex());
  if (index >= partsOfObject_.size()) partsOfObject_.resize(index + 1);
  std::vector<NumberedPart>& parts = partsOfObject_[index];
  const auto isBefore = [](const NumberedPart& k, std::uint64_t n) { return k.number < n; };
  auto it = std::lower_bound(parts.begin(), parts.end(), number, isBefore);
  if (it == parts.end() || it->number != number) {
    const ShapeSurface& surface = shapes_->surfaceOf(shape);
    if (surface.topology.elements.empty()) return;
    if (parts.empty()) usedIndices_.push_back(index);
    if (used_ == parts_.size()) parts_.emplace_back();
    RigidPart& part = parts_[used_++];
    part.number = number;
    placePart(part, surface, pose,
              [&](const Vector3d& position) { return motionOf(object, position, tick); });
    it = parts.insert(it, {number, &part});
  }
  near_.push_back(it->part);
}

// --- concave objects ---------------------------------------------------------------------------------------

namespace {

bool contains(const LocalBox& box, const LocalBox& other) {
  for (int i = 0; i < 3; ++i)
    if (other.low[i] < box.low[i] || other.high[i] > box.high[i]) return false;
  return true;
}

/// Returns the box in the object's coordinates, for the object's poses at the start and the end of the tick,
/// and wider by the shape's margin.
LocalBox boxIn(const btCollisionObject& object, const SweptBox& world) {
  const double margin = double(object.getCollisionShape()->getMargin());
  const Vector3d low = world.low.head<3>().array() - margin, high = world.high.head<3>().array() + margin;
  LocalBox box = localBoxOf(object.getWorldTransform(), low, high);
  if (!isKinematic(object)) return box;
  const LocalBox endBox = localBoxOf(object.getInterpolationWorldTransform(), low, high);
  box.low.setMin(endBox.low), box.high.setMax(endBox.high);
  return box;
}

}  // namespace

RigidPart* trianglesIn(const SweptBox& box, const btCollisionObject& object, ConcavePatch& patch) {
  const LocalBox near = boxIn(object, box);
  const btTransform& pose = object.getWorldTransform();
  const auto& shape = *static_cast<const btConcaveShape*>(object.getCollisionShape());
  // the shape may be replaced, scaled, refitted, or read from heights that the application changes
  const auto presentHash = [&] { return hashOfTriangles(shape, patch.box.low, patch.box.high, 0); };
  const bool isMade = contains(patch.box, near) && patch.hash == presentHash();
  if (!isMade) {
    // a body that slides or rolls then rarely needs a new patch
    const btVector3 margin = btScalar(0.25) * (near.high - near.low);
    patch.box = {near.low - margin, near.high + margin};
    patch.surface = sheetSurface(shape, patch.box.low, patch.box.high);
    patch.hash = presentHash();
  }
  if (!isMade || isKinematic(object) || !(patch.pose == pose))
    placePart(patch.part, patch.surface, pose,
              [&](const Vector3d& position) { return kinematicDisplacement(object, position); });
  patch.pose = pose;
  return patch.surface.topology.elements.empty() ? nullptr : &patch.part;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

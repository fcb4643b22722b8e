// SPDX-License-Identifier: Zlib

// This file makes the contacts of a point with a static or kinematic object. They are planes where the object
// is flat or moves. Elsewhere they follow its surface within the tick.

#include "bullet/bullet_objects.h"
#include "bullet/kinematic_motion.h"
#include "bullet/point_contacts.h"
#include "bullet/rigid_shapes.h"
#include "bullet/soft_body_data.h"
#include "mesh/closest_points.h"
#include "solver/point_state.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Fraction of the radius. A point whose search distance is not longer is slow. The search distance includes
/// a constant third of the radius.
constexpr double kSlowSearchDistance = 0.6;

/// Fraction of the radius. A point that is nearer to a triangle's plane may be on the wrong side of it. The
/// depth of a resting contact is much smaller.
constexpr double kMaxDepth = 0.5;

/// Fraction of a spring's length. A point that is nearer to a triangle is on it.
constexpr double kOnTriangleTolerance = 1e-9;

// --- cached contacts ---------------------------------------------------------------------------------------

// A point at rest on a flat face does not need Bullet's narrowphase in every tick.

/// Fraction of the radius: the largest displacement of a point relative to the partner for which its contact
/// stays valid. On a face nothing changes. At an edge or on a ball of 1 m the surface departs from the plane
/// by (0.1 r)^2 / 2.
constexpr btScalar kMaxCachedDisplacement = btScalar(0.1);

/// Stores a contact with a convex partner, and replaces the previous one. In world coordinates; `position` is
/// the point's centre.
void storeContact(CachedContact& cached, std::uint64_t stamp, const btCollisionObject& partner,
                  const btVector3& surface, const btVector3& normal, const btVector3& position) {
  if (stamp == 0) return;
  const btTransform& pose = partner.getWorldTransform();
  cached.partner = stamp;
  cached.surface = pose.invXform(surface);
  cached.normal = normal * pose.getBasis();
  cached.position = pose.invXform(position);
}

/// Returns whether the stored contact is one with this partner and still valid.
bool isCacheValid(const CachedContact& cached, std::uint64_t stamp, const btCollisionObject& partner,
                  const btVector3& position, btScalar radius) {
  if (stamp == 0 || cached.partner != stamp) return false;
  const btScalar displacement = kMaxCachedDisplacement * radius;
  return (partner.getWorldTransform().invXform(position) - cached.position).length2() <=
         displacement * displacement;
}

// --- contacts of one pair ----------------------------------------------------------------------------------

/// Returns the largest distance (m) by which a box in the shape appears too far away to Bullet's narrowphase.
/// It sweeps a ball with the radius of the margin m around a smaller box, whose corners are sqrt(3) m inside
/// the corners of the box: sqrt(3) m - m.
btScalar roundingOf(const btCollisionShape& shape) {
  constexpr double kCorner = 0.7320508075688772;
  if (shape.getShapeType() == BOX_SHAPE_PROXYTYPE) return btScalar(kCorner) * shape.getMargin();
  btScalar rounding = 0;
  if (!shape.isCompound()) return rounding;
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int i = 0; i < compound.getNumChildShapes(); ++i)
    rounding = btMax(rounding, roundingOf(*compound.getChildShape(i)));
  return rounding;
}

/// Makes the contacts of one point with one partner. Points of surfaces collide with the exact box
/// (nearestOnBox()), point masses in the world with Bullet's rounded one.
class PlaneContactCollector final : public btCollisionWorld::ContactResultCallback {
 public:
  PlaneContactCollector(SoftBodyData& body, std::uint32_t point, const btCollisionObject& partner,
                        double searchRegion, btScalar tick)
      : body_(&body),
        point_(point),
        partner_(&partner),
        searchDistance_(searchRegion),
        tick_(tick),
        first_(body.contacts.size()) {
    const btScalar rounding = isSurfaceBody(body) ? roundingOf(*partner.getCollisionShape()) : 0;
    m_closestDistanceThreshold = static_cast<btScalar>(searchRegion) + rounding;
  }

  btScalar addSingleResult(btManifoldPoint& contact, const btCollisionObjectWrapper* first, int, int,
                           const btCollisionObjectWrapper* second, int, int) override {
    const bool pointIsFirst = first->getCollisionObject() != partner_;
    const btCollisionObjectWrapper& theirs = pointIsFirst ? *second : *first;
    if (isSurfaceBody(*body_) && theirs.getCollisionShape()->getShapeType() == BOX_SHAPE_PROXYTYPE) {
      addOnBox(*static_cast<const btBoxShape*>(theirs.getCollisionShape()), theirs.getWorldTransform());
      return 0;
    }
    if (contact.getDistance() > static_cast<btScalar>(searchDistance_)) return 0;
    const btVector3 normal = pointIsFirst ? contact.m_normalWorldOnB : -contact.m_normalWorldOnB;
    surface_ = pointIsFirst ? contact.m_positionWorldOnB : contact.m_positionWorldOnA;
    normal_ = normal;
    ++found_;
    add(toEigen(normal), surface_);
    return 0;
  }

  void addOnBox(const btBoxShape& box, const btTransform& pose) {
    const Eigen::Vector3d x = body_->state.position.col(point_);
    const NearestOnBox nearest = nearestOnBox(box, pose, x);
    const double height = nearest.normal.dot(x - nearest.surface);
    if (height - double(body_->masses.shape->getRadius()) <= searchDistance_)
      add(nearest.normal, toBullet(nearest.surface));
  }

  /// Stores the contact for later ticks if it is the only one.
  void storeContact(CachedContact& cached, std::uint64_t stamp) const {
    const btVector3 position = toBullet(Eigen::Vector3d(body_->state.position.col(point_)));
    if (found_ == 1) limber::storeContact(cached, stamp, *partner_, surface_, normal_, position);
  }

  /// Adds a contact whose plane follows the pieces of `owner` in `around` within the step. `contact` is its
  /// first plane; nullptr: the point cannot touch them yet.
  void addFollowing(HeldNeighbourhood& around, std::uint32_t owner, const HeldContact* contact) {
    PlaneContact row = makeRow();
    row.around = &around;
    row.owner = owner;
    row.away = !contact;
    if (contact) row.normal = contact->normal, row.touch = contact->touch;
    push(row);
  }

  void add(const Eigen::Vector3d& normal, const btVector3& surface) {
    PlaneContact row = makeRow();
    row.normal = normal.normalized();
    row.surfaceVelocity = kinematicDisplacement(*partner_, toEigen(surface)) / double(tick_);
    row.touch = toEigen(surface) + double(body_->masses.shape->getRadius()) * row.normal;
    for (std::size_t i = first_; i < body_->contacts.size(); ++i)
      if (body_->contacts[i].normal.dot(row.normal) > kSameSurface) {
        if (gap(row) < gap(body_->contacts[i])) body_->contacts[i] = row;
        return;
      }
    push(row);
  }

 private:
  PlaneContact makeRow() const {
    PlaneContact row;
    row.point = point_;
    row.friction = double(gCalculateCombinedFrictionCallback(&materialOf(*body_, point_), partner_));
    row.restitution = double(gCalculateCombinedRestitutionCallback(&materialOf(*body_, point_), partner_));
    row.bounceThreshold = body_->speeds.bounce;
    row.recoverySpeed = body_->speeds.recovery;
    return row;
  }

  void push(const PlaneContact& row) {
    body_->contacts.push_back(row);
    body_->contactPartners.push_back(partner_);
  }

  double gap(const PlaneContact& row) const {
    return row.normal.dot(body_->state.position.col(point_) - row.touch);
  }

  SoftBodyData* body_;
  std::uint32_t point_;
  const btCollisionObject* partner_;
  double searchDistance_;  ///< m, beyond the radius
  btScalar tick_;
  std::size_t first_;
  int found_ = 0;
  btVector3 surface_, normal_;  // of the last contact found
};

void addPlaneRow(PlaneContactCollector& rows, const SoftBodyData& body, std::uint32_t i,
                 const btCollisionObject& partner, double searchRegion) {
  const auto& plane = *static_cast<const btStaticPlaneShape*>(partner.getCollisionShape());
  const btTransform& pose = partner.getWorldTransform();
  const Eigen::Vector3d normal = toEigen(pose.getBasis() * plane.getPlaneNormal());
  const btVector3 onPlane = pose * (plane.getPlaneNormal() * plane.getPlaneConstant());
  const Eigen::Vector3d x = body.state.position.col(i);
  const double height = normal.dot(x - toEigen(onPlane));
  if (height - double(body.masses.shape->getRadius()) > searchRegion) return;
  rows.add(normal, toBullet(Eigen::Vector3d(x - height * normal)));
}

/// Adds the contact that Bullet found in the last tick. On a flat face it is still valid, because a slow
/// point has not left the face. Returns false if there is none or the point is too fast.
bool addCachedRow(PlaneContactCollector& rows, const SoftBodyData& body, std::uint32_t i,
                  const btCollisionObject& partner, double searchRegion) {
  const PointMass& point = *body.masses.bodies[i];
  const btPersistentManifold* manifold = point.cachedContact;
  const double radius = double(body.masses.shape->getRadius());
  if (!manifold || searchRegion > kSlowSearchDistance * radius) return false;
  const bool pointIsFirst = manifold->getBody0() == &point;
  if ((pointIsFirst ? manifold->getBody1() : manifold->getBody0()) != &partner) return false;
  const btManifoldPoint& contact = manifold->getContactPoint(0);
  const btVector3 normal = pointIsFirst ? contact.m_normalWorldOnB : -contact.m_normalWorldOnB;
  rows.add(toEigen(normal),
           partner.getWorldTransform() * (pointIsFirst ? contact.m_localPointB : contact.m_localPointA));
  return true;
}

/// Does the same for a point outside the world, for which Bullet has no manifold.
bool addStoredRow(PlaneContactCollector& rows, const SoftBodyData& body, std::uint32_t i,
                  const btCollisionObject& partner, std::uint64_t stamp, double searchRegion) {
  const CachedContact& cached = body.surface.contacts[i];
  const double radius = double(body.masses.shape->getRadius());
  const btVector3 position = toBullet(Eigen::Vector3d(body.state.position.col(i)));
  if (searchRegion > kSlowSearchDistance * radius ||
      !isCacheValid(cached, stamp, partner, position, body.masses.shape->getRadius()))
    return false;
  const btTransform& pose = partner.getWorldTransform();
  rows.add(toEigen(pose.getBasis() * cached.normal), pose * cached.surface);
  return true;
}

/// Adds the contacts that Bullet's narrowphase finds.
void addFoundRows(PlaneContactCollector& rows, SoftBodyData& body, std::uint32_t i,
                  const btCollisionObject& partner, std::uint64_t stamp) {
  body.world->contactPairTest(&probeAt(body, i), const_cast<btCollisionObject*>(&partner), rows);
  if (isSurfaceBody(body)) rows.storeContact(body.surface.contacts[i], stamp);
}

/// Returns whether the user may have excluded pairs with points of the body: not if the points are hidden.
bool mayBeExcluded(const SoftBodyData& body) { return body.masses.exposed || !body.anchors.empty(); }

double heightAbove(const HeldPiece& sheet, const Eigen::Vector3d& x) {
  return sheet.center.dot(x - sheet.axes.col(0));
}

/// Returns the distance (m) of x from the triangle.
double distanceTo(const HeldPiece& sheet, const Eigen::Vector3d& x) {
  const Eigen::Vector3d weights =
      nearestBarycentric({sheet.axes.col(0), sheet.axes.col(1), sheet.axes.col(2)}, x);
  return (sheet.axes * weights - x).norm();
}

/// Returns whether the segment from x to y crosses the triangle.
bool crosses(const HeldPiece& sheet, const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
  const double from = heightAbove(sheet, x), to = heightAbove(sheet, y);
  if (from == to || (from > 0.0) == (to > 0.0)) return false;
  return distanceTo(sheet, x + from / (from - to) * (y - x)) <= kOnTriangleTolerance * (y - x).norm();
}

/// Returns whether a spring of point i crosses the triangle.
bool hasSpringThrough(const SoftBodyData& body, std::uint32_t i, const HeldPiece& sheet) {
  const auto& x = body.state.position;
  const auto goes = [&](const NetworkSpring& s) {
    return (s.a == i && crosses(sheet, x.col(i), x.col(s.b))) ||
           (s.b == i && crosses(sheet, x.col(i), x.col(s.a)));
  };
  return std::any_of(body.model->network->springs.begin(), body.model->network->springs.end(), goes);
}

/// Sets the side of triangles for points that lie in them. This happens when a body is put on terrain
/// exactly, or a little too deep: the centre of a touching point is a radius away. If a spring of the point
/// crosses the triangle, the point belongs on the side of the body's centre of mass.
void chooseSides(const SoftBodyData& body, std::uint32_t i, HeldPiece* begin, HeldPiece* end) {
  const double radius = double(body.masses.shape->getRadius());
  const Eigen::Vector3d x = body.state.position.col(i);
  for (HeldPiece* piece = begin; piece != end; ++piece) {
    if (piece->kind != HeldPiece::Kind::Sheet) continue;
    if (!(std::abs(heightAbove(*piece, x)) < piece->margin + kMaxDepth * radius)) continue;
    // most of these planes belong to triangles farther away; the test of all springs costs more
    if (distanceTo(*piece, x) > piece->margin + radius) continue;
    if (!hasSpringThrough(body, i, *piece)) continue;
    piece->metAbove = true;
    piece->side = heightAbove(*piece, centerOfMass(body.state)) < 0.0 ? -1 : 1;
  }
}

/// Returns the nearest point on flat pieces. A sheet counts as one infinite plane. Sets `next` to the piece
/// after them.
HeldPoint nearestOnFlat(const HeldPiece* first, const HeldPiece* end, const Eigen::Vector3d& x,
                        const HeldPiece*& next) {
  next = endOfSolid(first, end);
  if (first->kind != HeldPiece::Kind::Sheet) return nearestOn(first, next, x);
  const HeldPiece* below = first;
  for (; next != end && next->owner == first->owner; ++next)
    if (next->metAbove) below = next;
  const double height = heightAbove(*below, x), side = below->metAbove ? below->side
                                                       : height < 0.0  ? -1.0
                                                                       : 1.0;
  return {side * below->center, side * height - below->margin, true};
}

/// Adds plane contacts: all surfaces nearby are flat.
void addFlatRows(SoftBodyData& body, std::uint32_t i, const SearchRegion& searchRegion, btScalar tick) {
  const HeldSurroundings& all = body.held;
  const Eigen::Vector3d x = body.state.position.col(i);
  const HeldPiece* end = all.pieces.data() + all.pieces.size();
  const HeldPiece* first = all.pieces.data() + body.staticPieces;
  for (const auto& [partner, endOfOwners] : body.staticPartners) {
    PlaneContactCollector rows(body, i, *partner, searchRegion.distance, tick);
    for (const HeldPiece* next = first; first != end && first->owner < endOfOwners; first = next) {
      const HeldPoint nearest = nearestOnFlat(first, end, x, next);
      if (nearest.height - double(body.masses.shape->getRadius()) <= searchRegion.distance)
        rows.add(nearest.normal, toBullet(Eigen::Vector3d(x - nearest.height * nearest.normal)));
    }
  }
}

/// Adds contacts that follow the surfaces nearby: for each owner one per direction in which it is near.
void addFollowingRows(SoftBodyData& body, std::uint32_t i, const SearchRegion& searchRegion, btScalar tick) {
  if (body.neighbourhoodCount == body.neighbourhoods.size())
    body.neighbourhoods.push_back(std::make_unique<HeldNeighbourhood>());
  HeldNeighbourhood& around = *body.neighbourhoods[body.neighbourhoodCount++];
  around = {&body.held, body.staticPieces, body.held.pieces.size(), double(body.masses.shape->getRadius())};
  findContacts(around, body.state.position.col(i), Eigen::Vector3d::Zero(), searchRegion.distance);
  std::uint32_t owner = 0;
  for (const auto& [partner, endOfOwners] : body.staticPartners) {
    PlaneContactCollector rows(body, i, *partner, searchRegion.distance, tick);
    for (; owner < endOfOwners; ++owner) {
      bool any = false;
      for (const HeldContact& c : body.held.contacts) {
        if (c.owner != owner) continue;
        rows.addFollowing(around, owner, &c);
        any = true;
      }
      if (!any) rows.addFollowing(around, owner, nullptr);
    }
  }
}

}  // namespace

void addStaticRows(SoftBodyData& body, std::uint32_t i, const SearchRegion& searchRegion, btScalar tick) {
  body.staticPartners.clear();
  body.staticPieces = body.held.pieces.size();
  std::uint32_t owners = 0;
  const Eigen::AlignedBox3d box(searchRegion.low, searchRegion.high);
  for (std::size_t p = 0; p < body.partners.size(); ++p) {
    const btCollisionObject* partner = body.partners[p];
    if (isMoved(*partner) || !box.intersects(body.partnerBoxes[p])) continue;
    if (mayBeExcluded(body) && !canHit(body, i, *partner)) continue;
    owners = addPieces(*partner, box, *body.shapes, owners, body.held.pieces);
    body.staticPartners.emplace_back(partner, owners);
  }
  const HeldPiece *begin = body.held.pieces.data() + body.staticPieces,
                  *end = body.held.pieces.data() + body.held.pieces.size();
  if (begin == end) return;
  chooseSides(body, i, body.held.pieces.data() + body.staticPieces,
              body.held.pieces.data() + body.held.pieces.size());
  if (!areFlatAround(begin, end, body.state.position.col(i), double(body.masses.shape->getRadius()),
                     searchRegion.distance))
    return addFollowingRows(body, i, searchRegion, tick);
  addFlatRows(body, i, searchRegion, tick);
  body.held.pieces.resize(body.staticPieces);
}

void addRows(SoftBodyData& body, std::uint32_t i, const btCollisionObject& partner, std::uint64_t stamp,
             const Eigen::Vector3d& velocity, double time, btScalar tick) {
  if (!isMoved(partner)) return;
  const double travel = kinematicDisplacement(partner, body.state.position.col(i)).norm();
  const SearchRegion searchRegion = searchRegionFrom(body, i, velocity, time, kSearchPerMotion * travel);
  if (!overlaps(searchRegion, partner)) return;
  if (mayBeExcluded(body) && !canHit(body, i, partner)) return;
  const double distance = searchRegion.distance;
  // the object may carry the point along, without a new search
  body.searchDistance[i] = std::max(body.searchDistance[i], distance);
  PlaneContactCollector rows(body, i, partner, distance, tick);
  const int shape = partner.getCollisionShape()->getShapeType();
  if (shape == STATIC_PLANE_PROXYTYPE)
    addPlaneRow(rows, body, i, partner, distance);
  else if (shape == BOX_SHAPE_PROXYTYPE && isSurfaceBody(body))
    rows.addOnBox(*static_cast<const btBoxShape*>(partner.getCollisionShape()), partner.getWorldTransform());
  else if (!(isSurfaceBody(body) ? addStoredRow(rows, body, i, partner, stamp, distance)
                                 : addCachedRow(rows, body, i, partner, distance)))
    addFoundRows(rows, body, i, partner, stamp);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

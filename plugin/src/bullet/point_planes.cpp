// SPDX-License-Identifier: Zlib

// This file makes the contacts of a point with rigid objects. On static and kinematic objects they are planes
// where the object is flat or moves; elsewhere they follow its surface within the tick.

#include "bullet/kinematic_motion.h"
#include "bullet/point_contacts.h"
#include "bullet/tick_contacts.h"
#include "mesh/surface.h"

#include <algorithm>
#include <optional>

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

using Eigen::Vector3d;

// --- Bullet's narrowphase ----------------------------------------------------------------------------------

/// Calls found(partner's wrapper, gap, normal, position on the partner) for each contact of a point with a
/// partner. `normal` is from the partner to the point.
template <class Found>
struct NarrowphaseResults final : btCollisionWorld::ContactResultCallback {
  const btCollisionObject* partner;
  Found found;

  NarrowphaseResults(const btCollisionObject& p, btScalar distance, Found f) : partner(&p), found(f) {
    m_closestDistanceThreshold = distance;
  }
  btScalar addSingleResult(btManifoldPoint& contact, const btCollisionObjectWrapper* first, int, int,
                           const btCollisionObjectWrapper* second, int, int) override {
    if (first->getCollisionObject() != partner)
      found(*second, contact.getDistance(), contact.m_normalWorldOnB, contact.m_positionWorldOnB);
    else
      found(*first, contact.getDistance(), -contact.m_normalWorldOnB, contact.m_positionWorldOnA);
    return 0;
  }
};

/// Finds the contacts of point i with a partner up to a distance (m).
template <class Found>
void findContacts(SoftBodyData& body, std::uint32_t i, const btCollisionObject& partner, btScalar distance,
                  Found found) {
  NarrowphaseResults<Found> results(partner, distance, found);
  const std::lock_guard<std::mutex> lock(*body.worldLock);
  body.world->contactPairTest(&probeAt(body, i), const_cast<btCollisionObject*>(&partner), results);
}

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

/// m, from a convex shape without its margin, up to which Bullet's GJK is not used, see findNearestOutside().
constexpr double kNearForGjk = 0.003;

/// Finds the nearest point on an object or a part of it. Bullet's narrowphase rounds the edges of boxes with
/// their margin, usually 4 cm, and loses the margins of parts nearer than a millimetre: points sink into
/// coins. Returns false where only Bullet can tell: for triangles, and deep inside a smooth convex part.
bool findNearest(SoftBodyData& body, const btCollisionShape& shape, const btTransform& pose,
                 const Vector3d& x, HeldPoint& nearest) {
  if (const std::optional<HeldPiece> solid = solidOf(shape, pose)) {
    nearest = nearestOn(&*solid, &*solid + 1, x);
    return true;
  }
  if (!shape.isConvex() || shape.getShapeType() == TRIANGLE_SHAPE_PROXYTYPE) return false;
  const auto& convex = static_cast<const btConvexShape&>(shape);
  const bool found = findNearestOutside(convex, pose, x, nearest);
  const double margin = double(shape.getMargin());
  if (found && nearest.height + margin > kNearForGjk) return true;
  return findNearestOnFaces(convex, pose, *body.shapes, x, margin + kNearForGjk, body.held.pieces, nearest) ||
         found;
}

// --- rows of one pair --------------------------------------------------------------------------------------

/// Adds the contacts of one point with one partner. Points of surfaces collide with the exact box, point
/// masses in the world with Bullet's rounded one.
struct PlaneRows {
  SoftBodyData& body;
  std::uint32_t point;
  std::uint32_t number;   ///< of the partner in body.heldPartners
  double searchDistance;  ///< m, beyond the radius
  btScalar tick;
  const btCollisionObject& partner = body.heldPartners[number].object();
  std::size_t first = body.contacts.size();

  double radius() const { return radiusOf(body); }
  Vector3d position() const { return body.state.position.col(point); }

  void add(const Vector3d& normal, const btVector3& surface) {
    PlaneContact row = makeRow();
    row.normal = normal.normalized();
    row.touch = toEigen(surface) + (radius() - standingDepth(*body.world, partner, row.normal)) * row.normal;
    // the point's centre is a radius above its surface: it moves as the object does there, as far as it turns
    // with it
    const Vector3d place = row.touch - (1.0 - turning(row.normal)) * radius() * row.normal;
    const SurfaceVelocity motion =
        surfaceVelocityOf(partner, kinematicDisplacement(partner, place), row.normal, double(tick));
    row.surfaceVelocity = motion.velocity, row.surfaceAcceleration = motion.acceleration;
    for (std::size_t i = first; i < body.contacts.size(); ++i)
      if (body.contacts[i].normal.dot(row.normal) > kSameSurface) {
        if (gap(row) < gap(body.contacts[i])) body.contacts[i] = row;
        return;
      }
    body.contacts.push_back(row);
  }

  /// Adds the surface below the point's centre if it is near.
  void addBelow(const HeldPoint& below) {
    if (below.height - radius() <= searchDistance)
      add(below.normal, toBullet(position() - below.height * below.normal));
  }

  /// Adds a contact whose plane follows the pieces of `owner` in `around` within the step. `contact` is its
  /// first plane; nullptr: the point cannot touch them yet.
  void addFollowing(HeldNeighbourhood& around, std::uint32_t owner, const HeldContact* contact) {
    PlaneContact row = makeRow();
    row.around = &around;
    row.owner = owner;
    row.away = !contact;
    if (contact) row.normal = contact->normal, row.touch = contact->touch;
    body.contacts.push_back(row);
  }

  /// Returns the share of the partner's rotation that the point's surroundings have: 1 of a rope around a
  /// drum, 0 of a parcel on rollers.
  double turning(const Vector3d& normal) const {
    if (!body.localSpins.areKnown) return 0.0;
    return turningShare(body.localSpins.spins.col(point), spinOf(partner, double(tick)), normal);
  }

  PlaneContact makeRow() const {
    PlaneContact row;
    row.point = point;
    row.partner = number;
    setMaterial(row, materialOf(body, point), partner, body.speeds);
    return row;
  }

  double gap(const PlaneContact& row) const { return row.normal.dot(position() - row.touch); }
};

// --- kinematic objects that move ---------------------------------------------------------------------------

// A slow point on a flat face does not need Bullet's narrowphase in every tick.

/// Adds the contact that Bullet found in the last tick. On a flat face it is still valid, because a slow
/// point has not left the face. Returns false if there is none.
bool addCachedRow(PlaneRows& rows) {
  const PointMass& point = *rows.body.masses.bodies[rows.point];
  const btPersistentManifold* manifold = point.cachedContact;
  if (!manifold) return false;
  const bool pointIsFirst = manifold->getBody0() == &point;
  if ((pointIsFirst ? manifold->getBody1() : manifold->getBody0()) != &rows.partner) return false;
  const btManifoldPoint& contact = manifold->getContactPoint(0);
  const btVector3 normal = pointIsFirst ? contact.m_normalWorldOnB : -contact.m_normalWorldOnB;
  rows.add(toEigen(normal),
           rows.partner.getWorldTransform() * (pointIsFirst ? contact.m_localPointB : contact.m_localPointA));
  return true;
}

/// Fraction of the radius: the largest displacement of a point relative to the partner for which its contact
/// stays valid. On a face nothing changes. At an edge or on a ball of 1 m the surface departs from the plane
/// by (0.1 r)^2 / 2.
constexpr btScalar kMaxCachedDisplacement = btScalar(0.1);

/// Does the same for a point outside the world, for which Bullet has no manifold.
bool addStoredRow(PlaneRows& rows) {
  const CachedContact& cached = rows.body.surface.contacts[rows.point];
  const std::uint64_t stamp = rows.body.heldPartners[rows.number].stamp;
  if (stamp == 0 || cached.partner != stamp) return false;
  const btTransform& pose = rows.partner.getWorldTransform();
  const btScalar largest = kMaxCachedDisplacement * static_cast<btScalar>(rows.radius());
  if ((pose.invXform(toBullet(rows.position())) - cached.position).length2() > largest * largest)
    return false;
  rows.add(toEigen(pose.getBasis() * cached.normal), pose * cached.surface);
  return true;
}

/// Adds the contacts with what is nearest of the partner. Stores that of a surface's point with a convex
/// partner for later ticks if it is the only one.
void addNearestRows(PlaneRows& rows) {
  SoftBodyData& body = rows.body;
  const bool surfaceBody = isSurfaceBody(body);
  const btScalar distance = static_cast<btScalar>(rows.searchDistance);
  const std::uint64_t stamp = body.heldPartners[rows.number].stamp;
  const btTransform& pose = rows.partner.getWorldTransform();
  const Vector3d x = rows.position();
  int count = 0;
  CachedContact only;
  const auto add = [&](const HeldPoint& nearest, const btVector3& surface) {
    if (nearest.height - rows.radius() > double(distance)) return;
    only = {stamp, pose.invXform(surface), toBullet(nearest.normal) * pose.getBasis(),
            pose.invXform(toBullet(x))};
    ++count;
    rows.add(nearest.normal, surface);
  };
  const auto addNearest = [&](const btCollisionShape& shape, const btTransform& at) {
    HeldPoint nearest;
    if (!surfaceBody || !findNearest(body, shape, at, x, nearest)) return false;
    add(nearest, toBullet(x - nearest.height * nearest.normal));
    return true;
  };
  const auto addFound = [&](const btCollisionObjectWrapper& theirs, btScalar gap, const btVector3& normal,
                            const btVector3& surface) {
    if (!addNearest(*theirs.getCollisionShape(), theirs.getWorldTransform()))
      add({toEigen(normal), double(gap) + rows.radius(), false}, surface);
  };
  const btCollisionShape& shape = *rows.partner.getCollisionShape();
  if (!addNearest(shape, pose))
    findContacts(body, rows.point, rows.partner, distance + (surfaceBody ? roundingOf(shape) : btScalar(0)),
                 addFound);
  if (surfaceBody && stamp != 0 && count == 1) body.surface.contacts[rows.point] = only;
}

// --- static objects ----------------------------------------------------------------------------------------

/// Returns whether the user has excluded the pair. Points that are hidden and not attached are in none.
bool isExcluded(const SoftBodyData& body, std::uint32_t i, const btCollisionObject& partner) {
  return (body.masses.exposed || !body.anchors.empty()) && !canHit(body, i, partner);
}

double heightAbove(const HeldPiece& sheet, const Vector3d& x) {
  return sheet.center.dot(x - sheet.axes.col(0));
}

/// Returns the distance (m) of x from the triangle.
double distanceTo(const HeldPiece& sheet, const Vector3d& x) {
  const Vector3d weights = nearestBarycentric({sheet.axes.col(0), sheet.axes.col(1), sheet.axes.col(2)}, x);
  return (sheet.axes * weights - x).norm();
}

/// Returns whether the segment from x to y crosses the triangle.
bool crosses(const HeldPiece& sheet, const Vector3d& x, const Vector3d& y) {
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
  const double radius = radiusOf(body);
  const Vector3d x = body.state.position.col(i);
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
HeldPoint nearestOnFlat(const HeldPiece* first, const HeldPiece* end, const Vector3d& x,
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

/// The pieces around a point, indices in SoftBodyData::held.
struct PieceRange {
  std::size_t begin, end;

  HeldPiece* first(SoftBodyData& body) const { return body.held.pieces.data() + begin; }
  HeldPiece* last(SoftBodyData& body) const { return body.held.pieces.data() + end; }
};

/// Adds plane contacts: all surfaces nearby are flat.
void addFlatRows(SoftBodyData& body, std::uint32_t i, const SearchRegion& searchRegion, PieceRange range,
                 btScalar tick) {
  const Vector3d x = body.state.position.col(i);
  const HeldPiece *first = range.first(body), *end = range.last(body);
  for (const auto& [partner, endOfOwners] : body.staticPartners) {
    PlaneRows rows{body, i, partner, searchRegion.distance, tick};
    for (const HeldPiece* next = first; first != end && first->owner < endOfOwners; first = next)
      rows.addBelow(nearestOnFlat(first, end, x, next));
  }
}

/// Largest number of pieces in the region of a point's whole motion. The region is smaller where more would
/// be in it: each piece costs time, in flat places once and elsewhere in each substep.
constexpr std::size_t kMaxPieces = 128;

/// Adds contacts that follow the surfaces nearby: for each owner one per direction in which it is near, at
/// least one, and three of triangles.
void addFollowingRows(SoftBodyData& body, std::uint32_t i, const SearchRegion& searchRegion, PieceRange range,
                      btScalar tick) {
  if (body.neighbourhoodCount == body.neighbourhoods.size())
    body.neighbourhoods.push_back(std::make_unique<HeldNeighbourhood>());
  HeldNeighbourhood& around = *body.neighbourhoods[body.neighbourhoodCount++];
  around.all = &body.held;
  around.begin = range.begin, around.end = range.end;
  around.radius = radiusOf(body);
  around.clear = 0.0;
  findContacts(around, body.state.position.col(i), Vector3d::Zero(), searchRegion.distance);
  std::uint32_t owner = 0;
  const HeldPiece *piece = range.first(body), *end = range.last(body);
  for (const auto& [partner, endOfOwners] : body.staticPartners) {
    PlaneRows rows{body, i, partner, searchRegion.distance, tick};
    for (; owner < endOfOwners; ++owner) {
      while (piece != end && piece->owner < owner) ++piece;
      // further triangles may become contacts within the step: in a groove a point touches two, in a pit
      // three
      int missing = piece != end && piece->kind == HeldPiece::Kind::Sheet ? 3 : 1;
      for (const HeldContact& c : around.contacts) {
        if (c.owner != owner) continue;
        rows.addFollowing(around, owner, &c);
        --missing;
      }
      for (; missing > 0; --missing) rows.addFollowing(around, owner, nullptr);
    }
  }
}

/// Finds the partners at rest that point i may touch in the box. Returns their pieces, or `limit` of them: of
/// a single convex solid those that all points share, else copies at the end of SoftBodyData::held.
PieceRange findPieces(SoftBodyData& body, std::uint32_t i, const Eigen::AlignedBox3d& box,
                      std::size_t limit) {
  auto& partners = body.staticPartners;
  partners.clear();
  for (std::uint32_t p = 0; p < body.heldPartners.size(); ++p) {
    const HeldPartner& held = body.heldPartners[p];
    if (!isMoved(held.object()) && box.intersects(held.box) && !isPushedOut(body, held, i) &&
        !isExcluded(body, i, held.object()))
      partners.emplace_back(p, 1);
  }
  std::vector<HeldPiece>& pieces = body.held.pieces;
  const auto solidOf = [&](std::uint32_t partner) { return body.heldPartners[partner].solid; };
  if (partners.size() == 1 && solidOf(partners[0].first) != HeldPartner::kNoSolid)
    return {solidOf(partners[0].first), solidOf(partners[0].first) + 1};
  const std::size_t begin = pieces.size();
  std::uint32_t owners = 0;
  for (auto& [partner, endOfOwners] : partners) {
    if (const std::size_t solid = solidOf(partner); solid != HeldPartner::kNoSolid) {
      pieces.push_back(HeldPiece(pieces[solid]));
      pieces.back().owner = owners++;
    } else {
      owners = addPieces(body.heldPartners[partner].object(), box, *body.shapes, owners, pieces,
                         limit == kNoLimit ? kNoLimit : begin + limit);
    }
    endOfOwners = owners;
  }
  return {begin, pieces.size()};
}

/// Finds the pieces in a region. Makes it smaller, down to a distance (m), while they are too many and the
/// watch can search again.
PieceRange findFewPieces(SoftBodyData& body, std::uint32_t i, double minDistance,
                         SearchRegion& searchRegion) {
  double& most = body.held.maxSearchDistance;
  if (body.watch->on && searchRegion.distance > most)
    searchRegion = searchRegionAround(body, i, std::max(most, minDistance));
  for (;;) {
    const bool mayShrink = body.watch->on && searchRegion.distance > minDistance;
    const std::size_t before = body.held.pieces.size();
    const PieceRange range = findPieces(body, i, searchRegion.box, mayShrink ? kMaxPieces + 1 : kNoLimit);
    if (!mayShrink || range.end - range.begin <= kMaxPieces) return range;
    body.held.pieces.resize(before);
    most = std::max(0.5 * searchRegion.distance, minDistance);
    searchRegion = searchRegionAround(body, i, most);
  }
}

}  // namespace

double addStaticRows(SoftBodyData& body, std::uint32_t i, const PointSearch& search, btScalar tick) {
  SearchRegion searchRegion = searchRegionFrom(body, i, search.velocity, search.time);
  const double wholeDistance = searchRegion.distance;
  for (std::uint32_t p = 0; body.surface.overlapTicks > 0 && p < body.heldPartners.size(); ++p) {
    const HeldPartner& held = body.heldPartners[p];
    if (isPushedOut(body, held, i) && !isExcluded(body, i, held.object()))
      PlaneRows{body, i, p, searchRegion.distance, tick}.addBelow(
          {held.out, held.out.dot(body.state.position.col(i)) - held.end, true});
  }
  const std::size_t before = body.held.pieces.size();
  const double minDistance = searchRegionFrom(body, i, search.velocity, search.minTime).distance;
  const PieceRange range = findFewPieces(body, i, minDistance, searchRegion);
  HeldPiece *first = range.first(body), *last = range.last(body);
  if (first == last) return searchRegion.distance;
  chooseSides(body, i, first, last);
  const bool staysInRegion =
      searchRegion.distance == wholeDistance || search.time * search.velocity.norm() < searchRegion.distance;
  if ((search.replacesPlanes || staysInRegion) &&
      areFlatAround(first, last, body.state.position.col(i), radiusOf(body), searchRegion.distance,
                    body.held.edgeKeys)) {
    addFlatRows(body, i, searchRegion, range, tick);
    body.held.pieces.resize(before);
  } else {
    addFollowingRows(body, i, searchRegion, range, tick);
  }
  return searchRegion.distance;
}

void addRows(SoftBodyData& body, std::uint32_t i, std::uint32_t number, const Vector3d& velocity, double time,
             btScalar tick) {
  const btCollisionObject& partner = body.heldPartners[number].object();
  if (!isMoved(partner)) return;
  const double travel = kinematicDisplacement(partner, body.state.position.col(i)).norm();
  const SearchRegion searchRegion = searchRegionFrom(body, i, velocity, time, kSearchPerMotion * travel);
  if (!overlaps(searchRegion, partner) || isExcluded(body, i, partner)) return;
  const double distance = searchRegion.distance;
  // the object may carry the point along, without a new search
  body.searchDistance[i] = std::max(body.searchDistance[i], distance);
  PlaneRows rows{body, i, number, distance, tick};
  const btCollisionShape& shape = *partner.getCollisionShape();
  const btTransform& pose = partner.getWorldTransform();
  const bool surfaceBody = isSurfaceBody(body);
  if (const std::optional<HeldPiece> solid =
          isPlane(partner) || surfaceBody ? solidOf(shape, pose) : std::nullopt)
    return rows.addBelow(nearestOn(&*solid, &*solid + 1, rows.position()));
  if (surfaceBody && body.surface.contacts.empty()) body.surface.contacts.resize(pointCount(body));
  const bool isSlow = distance <= kSlowSearchDistance * rows.radius();
  if (!isSlow || !(surfaceBody ? addStoredRow : addCachedRow)(rows)) addNearestRows(rows);
}

// --- dynamic rigid bodies ----------------------------------------------------------------------------------

namespace {

/// Returns a bound (m) on the motion of the partner's surface in the tick.
double displacementInTick(const btRigidBody& partner, double tick) {
  const double speed = double(partner.getLinearVelocity().length()) + double(rotationSpeed(partner));
  return tick * (speed + tick * double(partner.getTotalForce().length() * partner.getInvMass()));
}

/// Adds a contact of point i. Of contacts in the same direction, from `first` on, only the nearest counts.
void addPair(SoftBodyData& body, std::uint32_t i, const btRigidBody& partner, const Vector3d& normal,
             const Vector3d& surface, std::size_t first, TickContacts& found) {
  TickContact c;
  c.source = {nullptr, &body, nullptr, handleOf(objectInWorld(partner)), i};
  c.a = softPoint(body.index, i);
  c.b = rigidContactPoint(found, partner, toBullet(surface));
  c.normal = normal;
  c.gap = normal.dot(body.state.position.col(i) - surface) - radiusOf(body);
  setMaterial(c, materialOf(body, i), partner, body.speeds);
  for (std::size_t k = first; k < found.contacts.size(); ++k)
    if (found.contacts[k].normal.dot(normal) > kSameSurface) {
      if (c.gap < found.contacts[k].gap) found.contacts[k] = c;
      return;
    }
  found.contacts.push_back(c);
}

void addPairs(SoftBodyData& body, std::uint32_t i, const btRigidBody& partner, double tick,
              TickContacts& found) {
  const double motion = kSearchPerMotion * displacementInTick(partner, tick);
  const SearchRegion searchRegion = searchRegionOf(body, i, tick, motion);
  if (!overlaps(searchRegion, partner) || !canHit(body, i, partner)) return;
  const std::size_t first = found.contacts.size();
  const Vector3d x = body.state.position.col(i);
  const auto addIfNear = [&](const HeldPoint& nearest) {
    if (nearest.height - radiusOf(body) <= searchRegion.distance)
      addPair(body, i, partner, nearest.normal, x - nearest.height * nearest.normal, first, found);
  };
  if (HeldPoint nearest;
      findNearest(body, *partner.getCollisionShape(), partner.getWorldTransform(), x, nearest))
    return addIfNear(nearest);
  findContacts(
      body, i, partner, static_cast<btScalar>(searchRegion.distance),
      [&](const btCollisionObjectWrapper& theirs, btScalar gap, const btVector3& normal, const btVector3&) {
        HeldPoint nearest = {toEigen(normal).normalized(), double(gap) + radiusOf(body), false};
        findNearest(body, *theirs.getCollisionShape(), theirs.getWorldTransform(), x, nearest);
        addIfNear(nearest);
      });
}

}  // namespace

void gatherPairs(SoftBodyData& body, btRigidBody& partner, btScalar tick, TickContacts& found) {
  if (!partner.isActive() && partner.getActivationState() != DISABLE_SIMULATION) wakeInStep(partner);
  for (std::uint32_t i = 0; i < pointCount(body); ++i) addPairs(body, i, partner, double(tick), found);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This file finds the contacts of surfaces in a tick: with dynamic rigid bodies, static and kinematic
// objects, other soft bodies and themselves.

#include "bullet/surface_gather.h"

#include "bullet/bullet_objects.h"
#include "bullet/linked_group.h"
#include "bullet/point_contacts.h"
#include "bullet/rigid_shapes.h"
#include "bullet/tick_contacts.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Fraction of the radius. Surfaces nearer than this are in contact even if they do not approach.
constexpr double kMargin = 1.0 / 3.0;

/// Returns the largest motion (m) of a point in the tick towards a surface that it may touch.
double impactOf(const SoftBodyData& body, double tick) {
  double largest = 0.0;
  for (const PlaneContact& row : body.contacts)
    largest =
        std::max(largest, -tick * row.normal.dot(body.state.velocity.col(row.point) - row.surfaceVelocity));
  return largest;
}

const MovingSurface& movingSurface(SoftBodyData& body, double tick) {
  SurfaceData& s = body.surface;
  if (!s.motionValid) {
    s.motion = tick * body.state.velocity + tick * tick * body.state.acceleration;
    s.moving = {&body.model->topology, &body.state.position, &s.motion,
                double(body.masses.shape->getRadius()), &s.boxes};
    s.impact = impactOf(body, tick);
    s.motionValid = true;
  }
  return s.moving;
}

const MovingSurface& boxedSurface(SoftBodyData& body, double tick) {
  const MovingSurface& moving = movingSurface(body, tick);
  if (!body.surface.boxesValid) fitBoxes(moving, body.surface.boxes);
  body.surface.boxesValid = true;
  return moving;
}

/// Returns a box around the moving surface, with a margin for contacts. Does not fit the whole tree of boxes.
SweptBox searchBox(const MovingSurface& soft) {
  SweptBox box = sweptBounds(soft);
  double depth = 0.0;
  for (const double limit : soft.topology->depthLimit) depth = std::max(depth, limit);
  box.low -= depth + kMargin * soft.radius;
  box.high += depth + kMargin * soft.radius;
  return box;
}

bool areNear(const MovingSurface& a, const MovingSurface& b, double margin) {
  if (a.boxes->nodes.empty() || b.boxes->nodes.empty()) return false;
  return separation(a.boxes->nodes[0], b.boxes->nodes[0]) <= margin;
}

/// Returns the cache of the last search with a part of a partner, or an empty one if there was no search in
/// the last tick.
ContactCache& searchWith(SoftBodyData& body, const btCollisionObject& partner, std::uint64_t part) {
  std::vector<CachedSearch>& searches = body.surface.searches;
  const int id = partner.getBroadphaseHandle()->m_uniqueId;
  const auto isThis = [&](const CachedSearch& s) {
    return s.partner == &partner && s.id == id && s.part == part;
  };
  auto it = std::find_if(searches.begin(), searches.end(), isThis);
  if (it == searches.end()) {
    it = std::find_if(searches.begin(), searches.end(), [](const CachedSearch& s) { return !s.partner; });
    if (it == searches.end()) it = searches.emplace(searches.end());
    it->partner = &partner;
    it->id = id;
    it->part = part;
    it->cache.topologyA = nullptr;
  }
  it->used = true;
  return it->cache;
}

template <class Entry>
void forgetIfUnused(Entry& entry) {
  if (!entry.used) entry.partner = {};
  entry.used = false;
}

/// Releases the entries of partners that are no longer near; new partners reuse their memory.
void forgetOldSearches(SoftBodyData& body) {
  for (CachedSearch& search : body.surface.searches) forgetIfUnused(search);
  for (const auto& patch : body.surface.patches) forgetIfUnused(*patch);
}

ContactPoint softContactPoint(const SoftBodyData& body, const SurfacePoint& surfacePoint) {
  ContactPoint p;
  p.kind = ContactPoint::Kind::Soft;
  p.body = body.index;
  p.count = surfacePoint.kind == FeatureKind::OnVertex ? 1 : surfacePoint.kind == FeatureKind::OnEdge ? 2 : 3;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    p.point[i] = surfacePoint.points[i];
    p.weight[i] = surfacePoint.weights[i];
  }
  return p;
}

const btCollisionObject& frictionObject(const SoftBodyData& body) { return *body.surface.object; }

/// Makes a contact without the point on side b.
Contact contactOf(const SoftBodyData& body, const btCollisionObject& partner, const SurfaceContact& c) {
  Contact pair;
  pair.a = softContactPoint(body, c.a);
  pair.normal = c.normal;
  pair.gap = c.gap;
  pair.friction = double(gCalculateCombinedFrictionCallback(&frictionObject(body), &partner));
  pair.restitution = double(gCalculateCombinedRestitutionCallback(&frictionObject(body), &partner));
  pair.bounceThreshold = body.speeds.bounce;
  pair.recoverySpeed = body.speeds.recovery;
  return pair;
}

ContactSource sourceOf(SoftBodyData& body, const btCollisionObject& partner, std::uint64_t key) {
  ContactSource source;
  source.body = &body;
  source.partner = handleOf(objectInWorld(partner));
  source.key = key;
  return source;
}

/// Returns whether a point of the feature is attached to the partner. Such points, and the edges and
/// triangles that end in them, do not collide with it.
bool isAttached(const SoftBodyData& body, const SurfacePoint& surfacePoint,
                const btCollisionObject& partner) {
  return std::any_of(surfacePoint.points.begin(), surfacePoint.points.end(),
                     [&](std::uint32_t point) { return isAttached(body, point, partner); });
}

// --- dynamic rigid bodies ----------------------------------------------------------------------------------

/// Returns the common point of both impulses: the position of the soft side's points when they touch. With
/// two different points a couple would remain.
btVector3 commonPoint(const MovingSurface& soft, const MovingSurface& rigid, const SurfaceContact& c) {
  return toBullet(Vector3d(positionOf(rigid, c.b) + (rigid.radius + soft.radius) * c.normal));
}

/// Returns a key that is the same for the same contact of the same part in every tick.
std::uint64_t keyOf(const SurfaceContact& c, const RigidPart& part) {
  return c.key ^ (part.number * 0x9e3779b97f4a7c15u);
}

/// Makes a contact of a candidate without the contact point on side b.
Contact contactOf(const SurfaceCandidate& m, const SurfaceContact& c) {
  Contact pair = contactOf(*m.body, m.other ? frictionObject(*m.other) : *m.partner, c);
  // the smaller one of the two; a body that has slept from the start has none
  if (m.other && m.other->speeds.recovery > 0.0)
    pair.recoverySpeed = std::min(pair.recoverySpeed, m.other->speeds.recovery);
  return pair;
}

ContactSource sourceOf(const SurfaceCandidate& m, const SurfaceContact& c) {
  if (!m.other) return sourceOf(*m.body, *m.partner, keyOf(c, *m.part));
  ContactSource source = sourceOf(*m.body, frictionObject(*m.other), c.key);
  source.other = m.other;
  return source;
}

double featureSize(const MovingSurface& surface) {
  const double size = surface.topology->featureSize;
  return size > 0.0 ? size : surface.radius;
}

/// Returns the surface on side b.
const MovingSurface& surfaceB(const SurfaceCandidate& m) {
  if (m.other) return m.other->surface.moving;
  return m.part->moving;
}

/// Returns the gap (m) below which surfaces of a candidate are in contact even if they do not approach.
double margin(const SurfaceCandidate& m) {
  const double radius = m.body->surface.moving.radius;
  return kMargin * (m.other ? std::min(radius, m.other->surface.moving.radius) : radius);
}

double smallerFeatures(const SurfaceCandidate& m) {
  return std::min(featureSize(m.body->surface.moving), featureSize(surfaceB(m)));
}

double longestDisplacement(const Points& motion, const Vector3d& common) {
  return std::sqrt((motion.colwise() - common).colwise().squaredNorm().maxCoeff());
}

bool isSelf(const SurfaceCandidate& m) { return m.other == m.body; }

/// Returns whether new contacts of the body are searched for within a tick. Bodies that are stepped together
/// have no implicit steppers, and cannot repeat a tick whose error is too large. A body that needs one of
/// these must keep it when another body is only near.
bool isSearchedWithinTick(const SoftBodyData& body) {
  const Stepping& s = body.settings.stepping;
  const bool hasErrorLimit = s.tolerance > 0.0 || s.relativeTolerance > 0.0;
  return body.settings.continuousCollision && !body.prefersImplicit && !hasErrorLimit;
}

/// Returns whether hits and springs may cause contacts within the tick that were not predicted, and whether
/// these are to be found.
bool mayTouch(const SurfaceCandidate& m, double tick, SurfaceSearch& s) {
  if (!isSearchedWithinTick(*m.body) || (m.other && !isSearchedWithinTick(*m.other))) return false;
  const double displacement = displacementOf(m);
  if (!(displacement > kMaxBetweenSearches)) return false;
  const MovingSurface& a = boxedSurface(*m.body, tick);
  if (m.other) boxedSurface(*m.other, tick);
  const double extraMargin = displacement * smallerFeatures(m);
  if (isSelf(m)) {
    findSelfContacts(a, margin(m), s.search, s.contacts, extraMargin);
    return !s.contacts.empty();
  }
  findNearLeaves(a, surfaceB(m), margin(m) + extraMargin, s.search.waiting, s.search.near);
  return !s.search.near.empty();
}

/// Completes the candidate whose contacts have been added to `found` from m.first on.
void endCandidate(SurfaceCandidate& m, double tick, SurfaceSearch& s, TickContacts& found) {
  m.end = static_cast<std::uint32_t>(found.contacts.size());
  if (m.end == m.first && !mayTouch(m, tick, s)) return;
  if (m.partner) found.add(*m.partner);
  found.candidates.push_back(m);
}

void addFree(SoftBodyData& body, btRigidBody& partner, RigidPart& part, double tick, SurfaceSearch& s,
             TickContacts& found) {
  const MovingSurface& soft = movingSurface(body, tick);
  const double margin = kMargin * soft.radius;
  ContactCache& cache = searchWith(body, partner, part.number);
  if (!refreshContacts(soft, part.moving, margin, cache)) {
    boxedSurface(body, tick);
    s.contacts.clear();
    if (areNear(soft, part.moving, margin))
      findSurfaceContacts(soft, part.moving, margin, s.search, s.contacts);
    storeContacts(soft, part.moving, s.contacts, cache);
  }
  SurfaceCandidate candidate{&body, nullptr, &partner, nullptr, &part};
  candidate.first = static_cast<std::uint32_t>(found.contacts.size());
  for (const SurfaceContact& c : cache.contacts) {
    if (isAttached(body, c.a, partner)) continue;
    Contact pair = contactOf(candidate, c);
    pair.b = rigidContactPoint(found, partner, commonPoint(soft, part.moving, c));
    found.add(pair, sourceOf(candidate, c));
  }
  if (isFree(partner)) endCandidate(candidate, tick, s, found);
}

void gatherFree(SoftBodyData& body, btRigidBody& partner, double tick, RigidSurfaces& rigids,
                SurfaceSearch& s, TickContacts& found) {
  if (!rigids.hasParts(*partner.getCollisionShape()))
    return gatherPairs(body, partner, static_cast<btScalar>(tick), found);
  const SweptBox box = searchBox(movingSurface(body, tick));
  for (RigidPart* part : rigids.partsNear(partner, box, tick)) addFree(body, partner, *part, tick, s, found);
}

// --- static and kinematic objects --------------------------------------------------------------------------

HeldCorners cornersOf(const MovingSurface& soft, const RigidPart& part, const SurfacePoint& surfacePoint) {
  HeldCorners corners;
  if (surfacePoint.kind == FeatureKind::OnTriangle) return corners;
  corners.count = surfacePoint.kind == FeatureKind::OnEdge ? 2 : 1;
  for (std::size_t i = 0; i < 2; ++i) corners.at[i] = part.moving.position->col(surfacePoint.points[i]);
  corners.radiusSum = soft.radius + part.moving.radius;
  return corners;
}

/// Returns whether a contact of an edge or triangle counts. It does not if contacts of the corners replace
/// it.
bool isHeldContact(const SoftBodyData& body, const btCollisionObject& partner, const RigidPart& part,
                   const SurfaceContact& c, SurfaceSearch& s) {
  const MovingSurface& soft = body.surface.moving;
  if (c.a.kind == FeatureKind::OnVertex || isAttached(body, c.a, partner)) return false;
  if (cornersCarryContact(body, c, kMargin * soft.radius)) return false;
  return isMoved(partner) || !isInternalEdge(body, soft, part, c, s);
}

/// Returns the angular velocity (rad/s) of a kinematic object; 0 for a static one.
Vector3d spinOf(const btCollisionObject& object, double tick) {
  if (!isKinematic(object)) return Vector3d::Zero();
  return rotationBetween(toEigen(object.getWorldTransform().getRotation()),
                         toEigen(object.getInterpolationWorldTransform().getRotation())) /
         tick;
}

/// Returns the velocity (m/s) of the touched point of a part whose `motion` is that of `seconds`.
Vector3d velocityAt(const btCollisionObject& partner, const RigidPart& part, const MovingSurface& soft,
                    const SurfaceContact& c, double seconds, double tick) {
  Vector3d displacement = Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    displacement += c.b.weights[i] * part.motion.col(c.b.points[static_cast<std::size_t>(i)]);
  return displacement / seconds + spinOf(partner, tick).cross((part.moving.radius + soft.radius) * c.normal);
}

/// Makes a contact with a static or kinematic part whose `motion` is that of `seconds`.
Contact heldContact(const SoftBodyData& body, const btCollisionObject& partner, const RigidPart& part,
                    const SurfaceContact& c, double seconds, double tick) {
  Contact pair = contactOf(body, partner, c);
  if (isMoved(partner))
    pair.b.velocity = velocityAt(partner, part, body.surface.moving, c, seconds, tick);
  else
    pair.corners = cornersOf(body.surface.moving, part, c.b);
  return pair;
}

void addHeld(SoftBodyData& body, const btCollisionObject& partner, RigidPart& part, const SweptBox& box,
             double tick, SurfaceSearch& s, TickContacts& found) {
  const MovingSurface& soft = movingSurface(body, tick);
  const double margin = kMargin * soft.radius;
  if (staysCloseToRound(soft, part) || !hasSharpFeatureNear(box, part)) return;
  boxedSurface(body, tick);
  if (!areNear(soft, part.moving, margin) || !hasSharpFeatureNear(soft.boxes->nodes[0], part)) return;
  findSurfaceContacts(soft, part.moving, margin, s.search, s.contacts);
  SurfaceCandidate candidate;
  candidate.body = &body, candidate.held = &partner, candidate.part = &part;
  candidate.first = static_cast<std::uint32_t>(found.contacts.size());
  for (const SurfaceContact& c : s.contacts)
    if (isHeldContact(body, partner, part, c, s))
      found.add(heldContact(body, partner, part, c, tick, tick), sourceOf(body, partner, keyOf(c, part)));
  endCandidate(candidate, tick, s, found);
}

void gatherHeld(SoftBodyData& body, const btCollisionObject& partner, double tick, RigidSurfaces& rigids,
                SurfaceSearch& s, TickContacts& found) {
  if (partner.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE) return;
  const SweptBox box = searchBox(movingSurface(body, tick));
  if (partner.getCollisionShape()->isConcave()) {
    RigidPart* patch = patchAround(body, partner, boxedSurface(body, tick));
    if (patch) addHeld(body, partner, *patch, box, tick, s, found);
    return;
  }
  for (RigidPart* part : rigids.partsNear(partner, box, tick))
    addHeld(body, partner, *part, box, tick, s, found);
}

// --- soft bodies -------------------------------------------------------------------------------------------

/// Returns a point on a body that is not stepped in this tick. Its indices are only reported to users.
ContactPoint foreignPoint(const SoftBodyData& body, const SurfacePoint& surfacePoint) {
  ContactPoint p = softContactPoint(body, surfacePoint);
  p.kind = ContactPoint::Kind::World;
  if (body.asleep) return p;
  for (int i = 0; i < 3; ++i)
    p.velocity +=
        surfacePoint.weights[i] * body.state.velocity.col(surfacePoint.points[static_cast<std::size_t>(i)]);
  return p;
}

void gatherSoft(SoftBodyData& body, SoftBodyData& other, double tick, SurfaceSearch& s, TickContacts& found) {
  if (!other.alive || !hasSurface(other)) return;
  const bool together = !other.asleep;
  if (together && other.index < body.index) return;
  const MovingSurface &a = movingSurface(body, tick), &b = movingSurface(other, tick);
  const double margin = kMargin * std::min(a.radius, b.radius);
  ContactCache& cache = searchWith(body, frictionObject(other), 0);
  if (!refreshContacts(a, b, margin, cache)) {
    boxedSurface(body, tick);
    boxedSurface(other, tick);
    s.contacts.clear();
    if (areNear(a, b, margin)) findSurfaceContacts(a, b, margin, s.search, s.contacts);
    storeContacts(a, b, s.contacts, cache);
  }
  SurfaceCandidate candidate{&body, &other};
  candidate.first = static_cast<std::uint32_t>(found.contacts.size());
  for (const SurfaceContact& c : cache.contacts) {
    Contact pair = contactOf(candidate, c);
    pair.b = together ? softContactPoint(other, c.b) : foreignPoint(other, c.b);
    found.add(pair, sourceOf(candidate, c));
  }
  if (together) endCandidate(candidate, tick, s, found);
}

void gatherSelf(SoftBodyData& body, double tick, SurfaceSearch& s, TickContacts& found) {
  const MovingSurface& surface = boxedSurface(body, tick);
  SurfaceCandidate candidate{&body, &body};
  candidate.first = static_cast<std::uint32_t>(found.contacts.size());
  findSelfContacts(surface, margin(candidate), s.search, s.contacts);
  for (const SurfaceContact& c : s.contacts) {
    Contact pair = contactOf(candidate, c);
    pair.b = softContactPoint(body, c.b);
    found.add(pair, sourceOf(candidate, c));
  }
  endCandidate(candidate, tick, s, found);
}

// --- within a step -----------------------------------------------------------------------------------------

/// Sets the surface to the present positions of the body and its motion of the coming `ahead` seconds.
const MovingSurface& surfaceWithin(SoftBodyData& body, const PointView& points, double ahead) {
  SurfaceData& s = body.surface;
  s.positionInStep.resize(3, s.motion.cols());
  for (std::uint32_t i = 0; i < pointCount(body); ++i) {
    s.positionInStep.col(i) = points.positionOf(i);
    s.motion.col(i) = ahead * points.velocityOf(i);
  }
  s.moving.position = &s.positionInStep;
  fitBoxes(s.moving, s.boxes);
  return s.moving;
}

}  // namespace

double displacementOf(const SurfaceCandidate& m) {
  const MovingSurface &a = m.body->surface.moving, &b = surfaceB(m);
  const Vector3d common = 0.5 * (a.motion->rowwise().mean() + b.motion->rowwise().mean());
  const double stopped = m.body->surface.impact + (m.other ? m.other->surface.impact : 0.0);
  return (longestDisplacement(*a.motion, common) + longestDisplacement(*b.motion, common) + stopped) /
         smallerFeatures(m);
}

Vector3d positionOf(const MovingSurface& surface, const SurfacePoint& surfacePoint) {
  Vector3d x = Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    x += surfacePoint.weights[i] * surface.position->col(surfacePoint.points[static_cast<std::size_t>(i)]);
  return x;
}

void findContactsInStep(const SurfaceCandidate& m, const SidePositions& sides, double ahead, double tick,
                        SurfaceSearch& s) {
  s.pairs.clear();
  s.sources.clear();
  s.contacts.clear();
  const MovingSurface& a = surfaceWithin(*m.body, *sides.a, ahead);
  if (m.other && !isSelf(m))
    surfaceWithin(*m.other, *sides.b, ahead);
  else if (m.partner)
    movePart(*m.part, m.partner->getWorldTransform(), *sides.rigid, ahead);
  else if (m.held && isMoved(*m.held))
    movePart(*m.part, sides.share, ahead / tick);
  const MovingSurface& b = surfaceB(m);
  if (isSelf(m))
    findSelfContacts(a, margin(m), s.search, s.contacts);
  else if (areNear(a, b, margin(m)))
    findSurfaceContacts(a, b, margin(m), s.search, s.contacts);
  for (const SurfaceContact& c : s.contacts) {
    if (m.held) {
      if (!isHeldContact(*m.body, *m.held, *m.part, c, s)) continue;
      s.pairs.push_back(heldContact(*m.body, *m.held, *m.part, c, ahead, tick));
      s.sources.push_back(sourceOf(*m.body, *m.held, keyOf(c, *m.part)));
      continue;
    }
    if (!m.other && isAttached(*m.body, c.a, *m.partner)) continue;
    Contact pair = contactOf(m, c);
    if (m.other) {
      pair.b = softContactPoint(*m.other, c.b);
    } else {
      pair.b.kind = ContactPoint::Kind::Rigid;
      pair.b.arm = positionOf(b, c.b) + (b.radius + a.radius) * c.normal - sides.rigid->position;
    }
    s.pairs.push_back(pair);
    s.sources.push_back(sourceOf(m, c));
  }
}

void shareSoftPartners(const AwakeGroups& groups) {
  for (const LinkedGroup* group : groups)
    for (SoftBodyData* body : group->bodies)
      for (SoftBodyData* other : body->softPartners) {
        if (other->asleep) continue;
        std::vector<SoftBodyData*>& theirs = other->softPartners;
        if (std::find(theirs.begin(), theirs.end(), body) == theirs.end()) theirs.push_back(body);
      }
}

void gatherSurfacePairs(SoftBodyData& body, btScalar tick, RigidSurfaces& rigids, SurfaceSearch& search,
                        TickContacts& found) {
  if (!hasSurface(body)) return;
  const double h = double(tick);
  for (btRigidBody* partner : body.freePartners) gatherFree(body, *partner, h, rigids, search, found);
  for (const btCollisionObject* partner : body.partners) gatherHeld(body, *partner, h, rigids, search, found);
  for (SoftBodyData* other : body.softPartners) gatherSoft(body, *other, h, search, found);
  if (body.settings.selfCollision) gatherSelf(body, h, search, found);
  forgetOldSearches(body);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This file finds where surfaces touch, or may touch in a tick: rigid bodies that move, static and kinematic
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

/// Of the radius: surfaces nearer than this are contacts even if they do not approach.
constexpr double kMargin = 1.0 / 3.0;

/// m, the most that a point moves in the tick towards what its rows are of.
double impactOf(const SoftBodyData& body, double tick) {
  double most = 0.0;
  for (const PlaneContact& row : body.contacts)
    most = std::max(most, -tick * row.normal.dot(body.state.velocity.col(row.point) - row.surfaceVelocity));
  return most;
}

const MovingSurface& movingSurface(SoftBodyData& body, double tick) {
  SurfaceData& s = body.surface;
  if (!s.motionValid) {
    s.motion = tick * body.state.velocity + tick * tick * body.state.acceleration;
    s.moving = {&body.model->topology, &body.state.position, &s.motion, double(body.masses.shape->getRadius()),
                &s.boxes};
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

/// Holds the box of the whole surface, without fitting all of them, and what is near that.
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

/// The last search with a part of a partner; a new one if there was none in the last tick.
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

template <class List>
void forgetUnused(List& list) {
  for (auto& entry : list) {
    if (!entry.used) entry.partner = {};
    entry.used = false;
  }
}

/// What is no longer near gives its memory to what comes near.
void forgetOldSearches(SoftBodyData& body) {
  forgetUnused(body.surface.searches);
  forgetUnused(body.surface.patches);
}

ContactPoint softPlace(const SoftBodyData& body, const SurfacePoint& place) {
  ContactPoint p;
  p.kind = ContactPoint::Kind::Soft;
  p.body = body.index;
  p.count = place.kind == FeatureKind::OnVertex ? 1 : place.kind == FeatureKind::OnEdge ? 2 : 3;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    p.point[i] = place.points[i];
    p.weight[i] = place.weights[i];
  }
  return p;
}

const btCollisionObject& frictionObject(const SoftBodyData& body) { return *body.surface.object; }

/// What the two have in common whatever they touch with.
Contact contactOf(const SoftBodyData& body, const btCollisionObject& partner, const SurfaceContact& c) {
  Contact pair;
  pair.a = softPlace(body, c.a);
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

/// Points that are attached to a body do not collide with it, nor do the edges and triangles they end.
bool isAttached(const SoftBodyData& body, const SurfacePoint& place, const btCollisionObject& partner) {
  return std::any_of(place.points.begin(), place.points.end(),
                     [&](std::uint32_t point) { return isAttached(body, point, partner); });
}

// --- rigid bodies that move --------------------------------------------------------------------------------

/// Both sides get their impulses at one place, where the soft one's points, edges and triangles are when they
/// touch: no couple is left over.
btVector3 commonPlace(const MovingSurface& soft, const MovingSurface& rigid, const SurfaceContact& c) {
  return toBullet(Vector3d(positionOf(rigid, c.b) + (rigid.radius + soft.radius) * c.normal));
}

/// The same contact of the same part has the same key in every tick.
std::uint64_t keyOf(const SurfaceContact& c, const RigidPart& part) {
  return c.key ^ (part.number * 0x9e3779b97f4a7c15u);
}

/// A contact of a meeting but for the places on its sides.
Contact contactOf(const SurfaceCandidate& m, const SurfaceContact& c) {
  Contact pair = contactOf(*m.body, m.other ? frictionObject(*m.other) : *m.partner, c);
  // the smaller one's; a body that has slept from the start has none
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

/// The surface on side b.
const MovingSurface& surfaceB(const SurfaceCandidate& m) {
  if (m.other) return m.other->surface.moving;
  return m.part->moving;
}

/// m: surfaces of a meeting that are nearer than this are contacts even if they do not approach.
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

/// What steps together with others has neither implicit steppers nor a tick that is done again where its
/// error is too large: what asks for one of these must not lose it to what is only near.
bool isSearchedIn(const SoftBodyData& body) {
  const Stepping& s = body.settings.stepping;
  const bool asksForError = s.tolerance > 0.0 || s.relativeTolerance > 0.0;
  return body.settings.continuousCollision && !body.prefersImplicit && !asksForError;
}

/// Whether hits and springs may bring together in the tick what nobody foresees to touch, and that is to be
/// found.
bool mayMeet(const SurfaceCandidate& m, double tick, SurfaceSearch& s) {
  if (!isSearchedIn(*m.body) || (m.other && !isSearchedIn(*m.other))) return false;
  const double displacement = displacementOf(m);
  if (!(displacement > kMaxBetweenSearches)) return false;
  const MovingSurface& a = boxedSurface(*m.body, tick);
  if (m.other) boxedSurface(*m.other, tick);
  const double farther = displacement * smallerFeatures(m);
  if (isSelf(m)) {
    findSelfContacts(a, margin(m), s.search, s.contacts, farther);
    return !s.contacts.empty();
  }
  findNearLeaves(a, surfaceB(m), margin(m) + farther, s.search.waiting, s.search.near);
  return !s.search.near.empty();
}

/// Ends what was added to `found` since its meetings had a first contact.
void endCandidate(SurfaceCandidate& m, double tick, SurfaceSearch& s, TickContacts& found) {
  m.end = static_cast<std::uint32_t>(found.contacts.size());
  if (m.end == m.first && !mayMeet(m, tick, s)) return;
  if (m.partner) found.add(*m.partner);
  found.candidates.push_back(m);
}

void addFree(SoftBodyData& body, btRigidBody& partner, RigidPart& part, double tick, SurfaceSearch& s,
             TickContacts& found) {
  const MovingSurface& soft = movingSurface(body, tick);
  const double margin = kMargin * soft.radius;
  ContactCache& kept = searchWith(body, partner, part.number);
  if (!refreshContacts(soft, part.moving, margin, kept)) {
    boxedSurface(body, tick);
    s.contacts.clear();
    if (areNear(soft, part.moving, margin))
      findSurfaceContacts(soft, part.moving, margin, s.search, s.contacts);
    storeContacts(soft, part.moving, s.contacts, kept);
  }
  SurfaceCandidate candidate{&body, nullptr, &partner, nullptr, &part};
  candidate.first = static_cast<std::uint32_t>(found.contacts.size());
  for (const SurfaceContact& c : kept.contacts) {
    if (isAttached(body, c.a, partner)) continue;
    Contact pair = contactOf(candidate, c);
    pair.b = rigidContactPoint(found, partner, commonPlace(soft, part.moving, c));
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

HeldCorners cornersOf(const MovingSurface& soft, const RigidPart& part, const SurfacePoint& place) {
  HeldCorners corners;
  if (place.kind == FeatureKind::OnTriangle) return corners;
  corners.count = place.kind == FeatureKind::OnEdge ? 2 : 1;
  for (std::size_t i = 0; i < 2; ++i) corners.at[i] = part.moving.position->col(place.points[i]);
  corners.radiusSum = soft.radius + part.moving.radius;
  return corners;
}

/// A contact of an edge or triangle that its corners do not bear for.
bool isHeldContact(const SoftBodyData& body, const btCollisionObject& partner, const RigidPart& part,
                   const SurfaceContact& c, SurfaceSearch& s) {
  const MovingSurface& soft = body.surface.moving;
  if (c.a.kind == FeatureKind::OnVertex || isAttached(body, c.a, partner)) return false;
  if (cornersCarryContact(body, c, kMargin * soft.radius)) return false;
  return isMoved(partner) || !isInternalEdge(body, soft, part, c, s);
}

/// rad/s, of what moves as told.
Vector3d spinOf(const btCollisionObject& object, double tick) {
  if (!isKinematic(object)) return Vector3d::Zero();
  return rotationBetween(toEigen(object.getWorldTransform().getRotation()),
                         toEigen(object.getInterpolationWorldTransform().getRotation())) /
         tick;
}

/// Of the place of a part that is touched; its motion is that of `seconds`.
Vector3d velocityAt(const btCollisionObject& partner, const RigidPart& part, const MovingSurface& soft,
                    const SurfaceContact& c, double seconds, double tick) {
  Vector3d moved = Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    moved += c.b.weights[i] * part.motion.col(c.b.points[static_cast<std::size_t>(i)]);
  return moved / seconds + spinOf(partner, tick).cross((part.moving.radius + soft.radius) * c.normal);
}

/// With what is at rest, or moves as told: its motion is that of `seconds`.
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

/// A place on a body that is not stepped in this tick; its points are told to users only.
ContactPoint foreignPoint(const SoftBodyData& body, const SurfacePoint& place) {
  ContactPoint p = softPlace(body, place);
  p.kind = ContactPoint::Kind::World;
  if (body.asleep) return p;
  for (int i = 0; i < 3; ++i)
    p.velocity += place.weights[i] * body.state.velocity.col(place.points[static_cast<std::size_t>(i)]);
  return p;
}

void gatherSoft(SoftBodyData& body, SoftBodyData& other, double tick, SurfaceSearch& s, TickContacts& found) {
  if (!other.alive || !hasSurface(other)) return;
  const bool together = !other.asleep;
  if (together && other.index < body.index) return;
  const MovingSurface &a = movingSurface(body, tick), &b = movingSurface(other, tick);
  const double margin = kMargin * std::min(a.radius, b.radius);
  ContactCache& kept = searchWith(body, frictionObject(other), 0);
  if (!refreshContacts(a, b, margin, kept)) {
    boxedSurface(body, tick);
    boxedSurface(other, tick);
    s.contacts.clear();
    if (areNear(a, b, margin)) findSurfaceContacts(a, b, margin, s.search, s.contacts);
    storeContacts(a, b, s.contacts, kept);
  }
  SurfaceCandidate candidate{&body, &other};
  candidate.first = static_cast<std::uint32_t>(found.contacts.size());
  for (const SurfaceContact& c : kept.contacts) {
    Contact pair = contactOf(candidate, c);
    pair.b = together ? softPlace(other, c.b) : foreignPoint(other, c.b);
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
    pair.b = softPlace(body, c.b);
    found.add(pair, sourceOf(candidate, c));
  }
  endCandidate(candidate, tick, s, found);
}

// --- within a step -----------------------------------------------------------------------------------------

/// Where the body is now, and its motion of the coming `ahead` seconds.
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

Vector3d positionOf(const MovingSurface& surface, const SurfacePoint& place) {
  Vector3d x = Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    x += place.weights[i] * surface.position->col(place.points[static_cast<std::size_t>(i)]);
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
      pair.b = softPlace(*m.other, c.b);
    } else {
      pair.b.kind = ContactPoint::Kind::Rigid;
      pair.b.arm = positionOf(b, c.b) + (b.radius + a.radius) * c.normal - sides.rigid->position;
    }
    s.pairs.push_back(pair);
    s.sources.push_back(sourceOf(m, c));
  }
}

void shareSoftPartners(const std::vector<LinkedGroup>& groups) {
  for (const LinkedGroup& group : groups) {
    if (group.asleep) continue;
    for (SoftBodyData* body : group.bodies)
      for (SoftBodyData* other : body->softPartners) {
        if (other->asleep) continue;
        std::vector<SoftBodyData*>& theirs = other->softPartners;
        if (std::find(theirs.begin(), theirs.end(), body) == theirs.end()) theirs.push_back(body);
      }
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

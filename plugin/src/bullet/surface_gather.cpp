// SPDX-License-Identifier: Zlib

// This file finds the contacts of surfaces in a tick: with dynamic rigid bodies, static and kinematic
// objects, other soft bodies and themselves.

#include "bullet/surface_gather.h"

#include "bullet/contact_report.h"
#include "bullet/kinematic_motion.h"
#include "bullet/linked_group.h"
#include "bullet/point_contacts.h"

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
    s.moving = {&body.model->topology, &body.state.position, &s.motion, radiusOf(body), &s.boxes};
    s.impact = impactOf(body, tick) + s.freedMotion;
    s.motions.setEmpty();
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

/// Returns the last search with a part of a partner, or an empty one if there was no search in the last tick.
CachedSearch& searchWith(SoftBodyData& body, const btCollisionObject& partner, std::uint64_t part) {
  std::vector<CachedSearch>& searches = body.surface.searches;
  const int id = idOf(partner);
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
    if (it->patch) it->patch->box = LocalBox();
  }
  it->used = true;
  return *it;
}

/// Releases the entries of partners that are no longer near; new partners reuse their memory.
void forgetOldSearches(SoftBodyData& body) {
  for (CachedSearch& search : body.surface.searches) {
    if (!search.used) search.partner = nullptr;
    search.used = false;
  }
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

// --- candidates --------------------------------------------------------------------------------------------

/// Returns the object on side b.
const btCollisionObject& partnerOf(const SurfaceCandidate& m) {
  if (m.other) return *m.other->surface.object;
  return m.partner ? *m.partner : *m.held;
}

}  // namespace

double restitutionOf(const SurfaceCandidate& m) {
  return double(gCalculateCombinedRestitutionCallback(m.body->surface.object, &partnerOf(m)));
}

namespace {

/// Makes a contact without the point on side b.
Contact contactOf(const SurfaceCandidate& m, const SurfaceContact& c) {
  Contact pair;
  pair.a = softContactPoint(*m.body, c.a);
  pair.normal = c.normal;
  pair.gap = c.gap;
  pair.separates = c.separates;
  setMaterial(pair, *m.body->surface.object, partnerOf(m), m.body->speeds);
  // the smaller one of the two; a body that has slept from the start has none
  if (m.other && m.other->speeds.recovery > 0.0)
    pair.recoverySpeed = std::min(pair.recoverySpeed, m.other->speeds.recovery);
  return pair;
}

/// Makes the keys of contacts with different parts of an object different, and back.
std::uint64_t keyInPart(const SurfaceCandidate& m, std::uint64_t key) {
  return m.part ? key ^ (m.part->number * 0x9e3779b97f4a7c15u) : key;
}

/// The key is the same for the same contact of the same part in every tick.
ContactSource sourceOf(const SurfaceCandidate& m, const SurfaceContact& c) {
  ContactSource source;
  source.body = m.body;
  source.other = m.other;
  source.partner = handleOf(objectInWorld(partnerOf(m)));
  source.key = keyInPart(m, c.key);
  return source;
}

double featureSize(const MovingSurface& surface) {
  const double size = surface.topology->featureSize;
  return size > 0.0 ? size : surface.radius;
}

const MovingSurface& surfaceB(const SurfaceCandidate& m) {
  if (m.other) return m.other->surface.moving;
  return m.part->moving;
}

/// Returns the gap (m) below which surfaces of a candidate are in contact even if they do not approach.
double margin(const SurfaceCandidate& m) {
  const double radius = m.body->surface.moving.radius;
  return kMargin * (m.other ? std::min(radius, m.other->surface.moving.radius) : radius);
}

double longestDisplacement(const Points& motion, const Vector3d& common) {
  return std::sqrt((motion.colwise() - common).colwise().squaredNorm().maxCoeff());
}

/// Whether side b is a ball that a rigid body moves.
bool isBall(const SurfaceCandidate& m) { return m.partner && surfaceB(m).position->cols() == 1; }

/// Share of the search distance for a ball in contact. Its contacts follow it to the borders of their
/// triangles. Then it sinks into the next ones until these are found, and gains the energy of being lifted.
constexpr double kBallShare = 0.1;

bool isSelf(const SurfaceCandidate& m) { return m.other == m.body; }

/// Returns whether new contacts of the body are searched for within a tick. Bodies that are stepped together
/// cannot repeat a tick whose error is too large. A body that needs this must keep it when another body is
/// only near.
bool isSearchedWithinTick(const SoftBodyData& body) {
  const Stepping& s = body.settings.stepping;
  const bool hasErrorLimit = s.tolerance > 0.0 || s.relativeTolerance > 0.0;
  return body.settings.continuousCollision && !hasErrorLimit;
}

bool areSearchedWithinTick(const SurfaceCandidate& m) {
  return isSearchedWithinTick(*m.body) && (!m.other || isSearchedWithinTick(*m.other));
}

/// Whether a body of the pair needs an implicit stepper, which bodies that are stepped together do not have.
/// It keeps that while another body is only near, unless the motion of either is stopped.
bool keepsStepper(const SurfaceCandidate& m) {
  return m.body->prefersImplicit || (m.other && m.other->prefersImplicit);
}

/// Adds the contacts that had an impulse in the last tick (those of other parts too, with keys that no
/// feature has), and sorts the list.
void listBearing(const SurfaceCandidate& m, std::vector<std::uint64_t>& keys) {
  const int partner = handleOf(objectInWorld(partnerOf(m))).id;
  const std::vector<StoredImpulse>& stored = m.body->storedImpulses;
  auto it = std::lower_bound(stored.begin(), stored.end(), partner,
                             [](const StoredImpulse& k, int id) { return k.partner < id; });
  for (; it != stored.end() && it->partner == partner; ++it)
    if (it->impulse.along > 0.0) keys.push_back(keyInPart(m, it->key));
  std::sort(keys.begin(), keys.end());
}

/// Finds contacts that separate the body from another soft body, or a rigid one of a single shape, into which
/// one of them has been placed.
bool findOverlap(const SurfaceCandidate& m, SurfaceSearch& s) {
  if (isSelf(m) || m.held) return false;
  if (m.partner && (m.partner->getCollisionShape()->isCompound() || isAttached(*m.body, *m.partner)))
    return false;
  const bool tested = m.body->surface.overlapTicks > 0 || (m.other && m.other->surface.overlapTicks > 0);
  return tested && findOverlapContacts(m.body->surface.moving, surfaceB(m), s.search, s.contacts);
}

/// Fills s.contacts with the contacts of the present surfaces. s.search.bearing lists those that have borne a
/// load in this tick.
void findContacts(const SurfaceCandidate& m, SurfaceSearch& s) {
  const MovingSurface &a = m.body->surface.moving, &b = surfaceB(m);
  s.contacts.clear();
  if (!isSelf(m) && !areNear(a, b, margin(m))) return;
  if (findOverlap(m, s)) return;
  listBearing(m, s.search.bearing);
  if (isSelf(m))
    findSelfContacts(a, margin(m), s.search, s.contacts);
  else
    findSurfaceContacts(a, b, margin(m), s.search, s.contacts,
                        m.held ? coveredFeatures(a, *m.part) : Covered());
}

/// Has both bodies tested on while there is an overlap.
void noteOverlap(const SurfaceCandidate& m, const std::vector<SurfaceContact>& contacts) {
  if (contacts.empty() || !contacts.front().separates) return;
  m.body->surface.overlapTicks = SurfaceData::kOverlapTicks;
  if (m.other) m.other->surface.overlapTicks = SurfaceData::kOverlapTicks;
}

/// Returns the contacts of the last search at the present positions, or those of a new search if one is
/// needed.
const std::vector<SurfaceContact>& cachedContacts(const SurfaceCandidate& m, double tick, SurfaceSearch& s) {
  const MovingSurface &a = m.body->surface.moving, &b = surfaceB(m);
  ContactCache& cache = searchWith(*m.body, partnerOf(m), m.part ? m.part->number : 0).cache;
  if (!refreshContacts(a, b, margin(m), cache)) {
    boxedSurface(*m.body, tick);
    if (m.other) boxedSurface(*m.other, tick);
    s.search.bearing.clear();
    findContacts(m, s);
    storeContacts(a, b, s.contacts, cache);
  }
  noteOverlap(m, cache.contacts);
  return cache.contacts;
}

/// Returns whether the contact counts. Points that are attached to the partner, and the edges and triangles
/// that end in them, do not collide with it.
bool counts(const SurfaceCandidate& m, const SurfaceContact& c, SurfaceSearch& s) {
  if (m.other) return true;
  const btCollisionObject& partner = partnerOf(m);
  const auto isAttachedHere = [&](std::uint32_t point) { return isAttached(*m.body, point, partner); };
  if (std::any_of(c.a.points.begin(), c.a.points.end(), isAttachedHere)) return false;
  return m.partner || isHeldContact(m, c, margin(m), s);
}

/// Returns the distance (m), along the normal from the point on side b, of the common point of the impulses
/// on a soft and a rigid body: where the soft side's points are when they touch, or where they are now if
/// they are deeper than their radius. With two different points friction would leave a couple.
double commonDistance(const SurfaceCandidate& m, double gap) {
  const double radius = m.body->surface.moving.radius;
  return surfaceB(m).radius + radius + std::min(gap + radius, 0.0);
}

/// Returns the sum of the radii (m) if side b of the contact is a ball about a rigid body's centre of mass,
/// and its common point with the soft body is that far from there, else 0.
double ballRadius(const SurfaceCandidate& m, const Contact& contact) {
  if (!isBall(m) || contact.b.kind != ContactPoint::Kind::Rigid) return 0.0;
  const MovingSurface& b = surfaceB(m);
  const double sum = b.radius + m.body->surface.moving.radius;
  // of the positions, which Bullet rounds
  constexpr double kRounding = 1e-3;
  return (contact.b.arm - sum * contact.normal).norm() < kRounding * b.radius ? sum : 0.0;
}

/// Adds the contacts that count, for the motion in the coming `ahead` seconds of a tick. pointB(c) is the
/// point on a side b that is not static or kinematic.
template <class PointB>
void addContacts(const SurfaceCandidate& m, const std::vector<SurfaceContact>& contacts, double ahead,
                 double tick, SurfaceSearch& s, std::vector<TickContact>& pairs, PointB pointB) {
  for (SurfaceContact c : contacts) {
    if (!counts(m, c, s)) continue;
    if (m.other && ahead == tick) moveToMiddle(m.body->surface.moving, surfaceB(m), c);
    Contact pair = contactOf(m, c);
    if (m.held)
      setHeldSide(m, c, ahead, tick, pair);
    else
      pair.b = pointB(c);
    pair.spheres = ballRadius(m, pair);
    pairs.push_back({pair, sourceOf(m, c)});
  }
}

/// Returns the point on side b at the start of a tick. That on a sleeping body, which is not stepped, is only
/// reported to users.
ContactPoint pointB(const SurfaceCandidate& m, const SurfaceContact& c, TickContacts& found) {
  if (m.partner)
    return rigidContactPoint(found, *m.partner,
                             toBullet(positionOf(surfaceB(m), c.b) + commonDistance(m, c.gap) * c.normal));
  ContactPoint p = softContactPoint(*m.other, c.b);
  if (m.other->asleep) p.kind = ContactPoint::Kind::World;
  return p;
}

/// Returns the largest relative displacement (m) in the tick by the predicted motion. Only if it makes the
/// contacts invalid, the turn that both surfaces have in common is looked for.
double predictedDisplacement(const SurfaceCandidate& m) {
  const MovingSurface &a = m.body->surface.moving, &b = surfaceB(m);
  const Vector3d common = 0.5 * (a.motion->rowwise().mean() + b.motion->rowwise().mean());
  const double still = longestDisplacement(*a.motion, common) + longestDisplacement(*b.motion, common);
  const double features = featureSizeOf(m);
  if (!(still > searchDistanceOf(m) * features)) return still;
  const SurfaceMotion motionA = fittedMotion(*a.position, *a.motion),
                      motionB = fittedMotion(*b.position, *b.motion);
  const MotionFrame frame = calmestFrame(motionA, motionB, features);
  return std::min(still, relativeMotion(motionA, motionB, frame).speed(features));
}

void addCandidate(SurfaceCandidate m, const std::vector<SurfaceContact>& contacts, double tick,
                  SurfaceSearch& s, TickContacts& found) {
  m.first = static_cast<std::uint32_t>(found.contacts.size());
  addContacts(m, contacts, tick, tick, s, found.contacts,
              [&](const SurfaceContact& c) { return pointB(m, c, found); });
  m.end = static_cast<std::uint32_t>(found.contacts.size());
  if ((m.partner && !isFree(*m.partner)) || (m.other && m.other->asleep)) return;
  m.displacement = predictedDisplacement(m);
  if (m.end == m.first && (keepsStepper(m) || !mayTouch(m, tick, s))) {
    if (!m.held && !isSelf(m) && areSearchedWithinTick(m)) found.waiting.push_back(m);
    return;
  }
  if (m.partner) found.add(*m.partner);
  found.candidates.push_back(m);
}

// --- the partners of a body --------------------------------------------------------------------------------

void gatherFree(SoftBodyData& body, btRigidBody& partner, const SweptBox& box, double tick,
                RigidSurfaces& rigids, SurfaceSearch& s, TickContacts& found) {
  if (!rigids.hasParts(*partner.getCollisionShape()))
    return gatherPairs(body, partner, static_cast<btScalar>(tick), found);
  for (RigidPart* part : rigids.partsNear(partner, box, tick)) {
    const SurfaceCandidate m{&body, nullptr, &partner, nullptr, part};
    addCandidate(m, cachedContacts(m, tick, s), tick, s, found);
  }
}

void addHeld(SoftBodyData& body, const btCollisionObject& partner, RigidPart& part, const SweptBox& box,
             double tick, SurfaceSearch& s, TickContacts& found) {
  const SurfaceCandidate m{&body, nullptr, nullptr, &partner, &part};
  const MovingSurface& soft = movingSurface(body, tick);
  if (staysCloseToRound(soft, part)) return;
  const Covered covered = coveredFeatures(soft, part);
  if (!hasSharpFeatureNear(box, part, covered)) return;
  boxedSurface(body, tick);
  if (!areNear(soft, part.moving, margin(m)) || !hasSharpFeatureNear(soft.boxes->nodes[0], part, covered))
    return;
  s.search.bearing.clear();
  findContacts(m, s);
  addCandidate(m, s.contacts, tick, s, found);
}

void gatherHeld(SoftBodyData& body, const btCollisionObject& partner, const SweptBox& box, double tick,
                RigidSurfaces& rigids, SurfaceSearch& s, TickContacts& found) {
  if (isPlane(partner)) return;
  if (partner.getCollisionShape()->isConcave()) {
    const MovingSurface& soft = boxedSurface(body, tick);
    if (soft.boxes->nodes.empty()) return;
    std::unique_ptr<ConcavePatch>& patch = searchWith(body, partner, 0).patch;
    if (!patch) patch = std::make_unique<ConcavePatch>();
    RigidPart* part = nullptr;
    {
      const std::unique_lock<std::mutex> lock = body.shapes->lockMesh(*partner.getCollisionShape());
      part = trianglesIn(soft.boxes->nodes[0], partner, *patch);
    }
    if (part) addHeld(body, partner, *part, box, tick, s, found);
    return;
  }
  {
    const std::lock_guard<std::mutex> lock(*body.worldLock);
    s.parts = rigids.partsNear(partner, box, tick);
  }
  for (RigidPart* part : s.parts) addHeld(body, partner, *part, box, tick, s, found);
}

void gatherSoft(SoftBodyData& body, SoftBodyData& other, double tick, SurfaceSearch& s, TickContacts& found) {
  if (!other.alive || !hasSurface(other)) return;
  if (!other.asleep && other.index < body.index) return;
  const SurfaceCandidate m{&body, &other};
  movingSurface(body, tick);
  movingSurface(other, tick);
  addCandidate(m, cachedContacts(m, tick, s), tick, s, found);
}

void gatherSelf(SoftBodyData& body, double tick, SurfaceSearch& s, TickContacts& found) {
  const SurfaceCandidate m{&body, &body};
  boxedSurface(body, tick);
  s.search.bearing.clear();
  findContacts(m, s);
  addCandidate(m, s.contacts, tick, s, found);
}

// --- within a step -----------------------------------------------------------------------------------------

/// Returns the largest relative displacement (m) in the tick, by the predicted motion and by hits on static
/// and kinematic objects.
double ownDisplacement(const SurfaceCandidate& m) {
  return m.displacement + m.body->surface.impact + (m.other ? m.other->surface.impact : 0.0);
}

}  // namespace

double featureSizeOf(const SurfaceCandidate& m) {
  return std::min(featureSize(m.body->surface.moving), featureSize(surfaceB(m)));
}

double radiusSumOf(const SurfaceCandidate& m) { return m.body->surface.moving.radius + surfaceB(m).radius; }

double searchDistanceOf(const SurfaceCandidate& m) {
  const double own = m.body->settings.stepping.searchDistance;
  if (isBall(m) && m.end > m.first) return kBallShare * own;
  return m.other ? std::min(own, m.other->settings.stepping.searchDistance) : own;
}

double releasesOf(const SurfaceCandidate& m, double tick) {
  if (m.other || m.first == m.end) return 0.0;
  // overlaps of the radii alone are found in the next tick
  const double perSecond = std::sqrt(0.5 * m.body->surface.release / radiusSumOf(m));
  if (!(tick * perSecond > 1.0)) return 0.0;
  // the point passes round an edge in this many substeps
  constexpr double kResolved = 3.0;
  return kResolved * perSecond;
}

double displacementOf(const SurfaceCandidate& m, double tick) {
  const double features = featureSizeOf(m), radii = radiusSumOf(m), distance = searchDistanceOf(m);
  return ownDisplacement(m) / features + m.stopped / std::min(features, radii / distance) +
         distance * tick * releasesOf(m, tick);
}

bool mayTouch(const SurfaceCandidate& m, double tick, SurfaceSearch& s) {
  if (!areSearchedWithinTick(m)) return false;
  if (!(displacementOf(m, tick) > searchDistanceOf(m))) return false;
  const MovingSurface& a = boxedSurface(*m.body, tick);
  if (m.other) boxedSurface(*m.other, tick);
  // overlaps of the radii alone are found in the next tick
  const double radii = m.stopped > 0.0 ? radiusSumOf(m) : 0.0;
  const double extraMargin = ownDisplacement(m) + m.stopped - radii;
  if (isSelf(m))
    return mayTouchItself(a, margin(m), m.displacement, extraMargin - m.displacement, s.search, s.contacts);
  return areLeavesNear(a, surfaceB(m), margin(m) + extraMargin, s.search.waiting);
}

void moveInStep(SoftBodyData& body, const PointView& points, const TimeInStep& time) {
  SurfaceData& s = body.surface;
  s.positionInStep.resize(3, s.motion.cols());
  for (std::uint32_t i = 0; i < pointCount(body); ++i) {
    s.positionInStep.col(i) = points.positionOf(i);
    s.motion.col(i) = time.ahead * points.velocityOf(i);
  }
  s.moving.position = &s.positionInStep;
  fitBoxes(s.moving, s.boxes);
}

void movePartInStep(const SurfaceCandidate& m, const RigidState* rigid, const TimeInStep& time) {
  if (m.partner)
    movePart(*m.part, m.partner->getWorldTransform(), *rigid, time.ahead);
  else if (m.held && isMoved(*m.held))
    movePart(*m.part, time.since / time.tick, time.ahead / time.tick);
}

void findContactsInStep(const SurfaceCandidate& m, const RigidState* rigid, const TimeInStep& time,
                        SurfaceSearch& s, ContactsInStep& found) {
  found.contacts.clear();
  s.search.bearing.clear();
  for (const std::uint64_t key : found.bearing) s.search.bearing.push_back(keyInPart(m, key));
  findContacts(m, s);
  const auto pointB = [&](const SurfaceContact& c) {
    if (m.other) return softContactPoint(*m.other, c.b);
    ContactPoint p;
    p.kind = ContactPoint::Kind::Rigid;
    p.arm = positionOf(surfaceB(m), c.b) + commonDistance(m, c.gap) * c.normal - rigid->position;
    return p;
  };
  addContacts(m, s.contacts, time.ahead, time.tick, s, found.contacts, pointB);
  if (isFiltered(*m.body) || (m.other && isFiltered(*m.other))) filterPairs(found.contacts);
}

namespace {

/// Drops the soft partners that are too far away, and sorts the others. The boxes in the broadphase have room
/// for some ticks: which bodies it finds, and in which order, depends on earlier ticks.
void keepNearPartners(SoftBodyData& body) {
  std::vector<SoftBodyData*>& others = body.softPartners;
  const Eigen::AlignedBox3d& box = body.surface.presentBounds.box;
  const auto isFar = [&](const SoftBodyData* other) { return !box.intersects(presentBoundsOf(*other)); };
  others.erase(std::remove_if(others.begin(), others.end(), isFar), others.end());
  std::sort(others.begin(), others.end(),
            [](const SoftBodyData* a, const SoftBodyData* b) { return a->index < b->index; });
}

}  // namespace

void shareSoftPartners(const AwakeGroups& groups) {
  for (const LinkedGroup* group : groups)
    for (SoftBodyData* body : group->bodies)
      for (SoftBodyData* other : body->softPartners) {
        if (other->asleep) continue;
        std::vector<SoftBodyData*>& theirs = other->softPartners;
        if (std::find(theirs.begin(), theirs.end(), body) == theirs.end()) theirs.push_back(body);
      }
  for (const LinkedGroup* group : groups)
    for (SoftBodyData* body : group->bodies)
      if (!body->softPartners.empty()) keepNearPartners(*body);
}

namespace {

bool hasOnlyHeldPartners(const SoftBodyData& body) {
  return hasSurface(body) && body.freePartners.empty() && body.softPartners.empty() &&
         !body.settings.selfCollision;
}

}  // namespace

void HeldPairs::gather(const std::vector<SoftBodyData*>& bodies, btScalar tick, RigidSurfaces& rigids,
                       ScratchPool<SurfaceSearch>& searches, const Parallel& parallel) {
  const std::size_t size = parallel.blockSize(bodies.size());
  blocks_.resize(std::max(blocks_.size(), parallel.blockCount(bodies.size())));
  entries_.assign(bodies.size(), Entry());
  parallel.inBlocks(bodies.size(), [&](std::size_t begin, std::size_t end) {
    TickContacts& found = blocks_[begin / size];
    found.clear();
    searches.with([&](SurfaceSearch& search) {
      for (std::size_t i = begin; i < end; ++i) {
        if (!hasOnlyHeldPartners(*bodies[i])) continue;
        entries_[i] = {true, begin / size, found.candidates.size(), 0};
        gatherSurfacePairs(*bodies[i], tick, rigids, search, found);
        entries_[i].end = found.candidates.size();
      }
    });
  });
}

bool HeldPairs::take(std::size_t i, TickContacts& found) const {
  const Entry& entry = entries_[i];
  const TickContacts& block = blocks_[entry.block];
  for (std::size_t c = entry.first; c < entry.end; ++c) {
    SurfaceCandidate m = block.candidates[c];
    const auto first = static_cast<std::uint32_t>(found.contacts.size());
    found.contacts.insert(found.contacts.end(), block.contacts.begin() + m.first,
                          block.contacts.begin() + m.end);
    m.end = static_cast<std::uint32_t>(found.contacts.size());
    m.first = first;
    found.candidates.push_back(m);
  }
  return entry.isSearched;
}

void gatherSurfacePairs(SoftBodyData& body, btScalar tick, RigidSurfaces& rigids, SurfaceSearch& search,
                        TickContacts& found) {
  if (!hasSurface(body)) return;
  const double h = double(tick);
  if (body.surface.overlapTicks > 0) --body.surface.overlapTicks;
  SweptBox box;
  if (!body.freePartners.empty() ||
      !std::all_of(body.heldPartners.begin(), body.heldPartners.end(),
                   [](const HeldPartner& held) { return isPlane(held.object()); }))
    box = searchBox(movingSurface(body, h));
  for (btRigidBody* partner : body.freePartners) gatherFree(body, *partner, box, h, rigids, search, found);
  for (const HeldPartner& held : body.heldPartners)
    if (held.out.isZero(0.0)) gatherHeld(body, held.object(), box, h, rigids, search, found);
  for (SoftBodyData* other : body.softPartners) gatherSoft(body, *other, h, search, found);
  if (body.settings.selfCollision) gatherSelf(body, h, search, found);
  forgetOldSearches(body);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This file finds the pairs of surfaces that touch only within a step, and their contacts. Some move together
// and touch because something stops one of them: of a falling stack the lowest body hits the floor, and
// within the same tick the next one hits the lowest. The contacts of an island are searched in rounds between
// its substeps, in which each pair of surfaces takes part that has moved far enough since its last search.

#include "bullet/linked_group.h"
#include "bullet/point_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

// --- motions -----------------------------------------------------------------------------------------------

/// The motions of bodies, as displacements (m) in the tick. Each body has the box of its own mean motion and
/// of those of all that may stop it: what sticks together moves by something between them.
class Motions {
 public:
  Motions(double tick, SurfaceSearch& search)
      : tick_(tick), rigids_(search.motions), numbers_(search.motionOf) {
    rigids_.clear();
  }

  /// Gives each body of the pair its own motion, and that of static and kinematic objects that it touches.
  void start(const SurfaceCandidate& m) {
    for (SoftBodyData* body : {m.body, m.other})
      if (body) startSoft(*body);
    if (m.partner && !find(*m.partner)) startRigid(*m.partner);
  }

  /// Adds the motions of what the rigid bodies touch in Bullet.
  void addManifolds(btDispatcher& dispatcher) {
    if (rigids_.empty()) return;
    forEachManifold(dispatcher, [&](const btPersistentManifold& manifold) {
      if (manifold.getNumContacts() == 0) return;
      addTouched(*manifold.getBody0(), *manifold.getBody1());
      addTouched(*manifold.getBody1(), *manifold.getBody0());
    });
  }

  AlignedBox3d& of(SoftBodyData& body) { return body.surface.motions; }
  AlignedBox3d& ofOther(const SurfaceCandidate& m) { return m.other ? of(*m.other) : find(*m.partner)->box; }
  AlignedBox3d ofBoth(const SurfaceCandidate& m) { return of(*m.body).merged(ofOther(m)); }

  /// Lets each body of the pair stop the other. Returns whether a box has grown.
  bool join(const SurfaceCandidate& m) {
    const AlignedBox3d all = ofBoth(m);
    AlignedBox3d &a = of(*m.body), &b = ofOther(m);
    if (a.contains(all) && b.contains(all)) return false;
    a = b = all;
    return true;
  }

 private:
  void startSoft(SoftBodyData& body) {
    AlignedBox3d& box = body.surface.motions;
    if (!box.isEmpty()) return;
    box.extend(Vector3d(body.surface.motion.rowwise().mean()));
    for (const PlaneContact& row : body.contacts) box.extend(Vector3d(tick_ * row.surfaceVelocity));
  }

  void startRigid(const btRigidBody& body) {
    const auto index = static_cast<std::size_t>(body.getWorldArrayIndex());
    if (index >= numbers_.size()) numbers_.resize(index + 1);
    numbers_[index] = static_cast<std::uint32_t>(rigids_.size());
    // what it stands on may be unknown in its first tick
    const Vector3d coasting = tick_ * toEigen(body.getLinearVelocity());
    rigids_.push_back({&body, AlignedBox3d(coasting).extend(Vector3d(coasting + fallOf(body, tick_)))});
  }

  RigidMotions* find(const btCollisionObject& object) {
    const auto index = static_cast<std::size_t>(object.getWorldArrayIndex());
    if (index >= numbers_.size() || numbers_[index] >= rigids_.size()) return nullptr;
    RigidMotions& motions = rigids_[numbers_[index]];
    return motions.body == &object ? &motions : nullptr;
  }

  void addTouched(const btCollisionObject& object, const btCollisionObject& touched) {
    if (RigidMotions* motions = find(object))
      motions->box.extend(
          Vector3d(tick_ * velocityOf(touched, touched.getWorldTransform().getOrigin(), tick_)));
  }

  double tick_;
  std::vector<RigidMotions>& rigids_;
  std::vector<std::uint32_t>& numbers_;
};

// --- may they meet? ----------------------------------------------------------------------------------------

Extent extentOf(const AlignedBox3d& box, const Vector3d& direction) {
  const double middle = direction.dot(box.center()), half = 0.5 * direction.cwiseAbs().dot(box.sizes());
  return {middle - half, middle + half};
}

Extent extentOf(const Points& points, const Vector3d& direction) {
  Extent all{SweptBox::kEmpty, -SweptBox::kEmpty};
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const double at = direction.dot(points.col(i));
    all = {std::min(all.low, at), std::max(all.high, at)};
  }
  return all;
}

/// Returns the extent while it is displaced within a box.
Extent displaced(const Extent& extent, const AlignedBox3d& displacement, const Vector3d& direction) {
  const Extent moved = extentOf(displacement, direction);
  return {extent.low + std::min(0.0, moved.low), extent.high + std::max(0.0, moved.high)};
}

bool separates(const SeparatingAxis& s, const AlignedBox3d& motionsOfA, const AlignedBox3d& motionsOfB) {
  const Extent a = displaced(s.a, motionsOfA, s.direction), b = displaced(s.b, motionsOfB, s.direction);
  return a.low > b.high || b.low > a.high;
}

/// Returns whether two surfaces, without their radii, may meet if each moves by a displacement (m) in its
/// box: whether their extents along 13 directions do. If not, sets `found`. Overlaps of the radii alone are
/// found in the next tick.
bool mayMeet(const MovingSurface& a, const AlignedBox3d& motionsOfA, const MovingSurface& b,
             const AlignedBox3d& motionsOfB, SeparatingAxis& found) {
  // one of each two opposite ones of the 26 directions to the neighbours of a cell
  for (int i = 14; i < 27; ++i) {
    const Eigen::Vector3i cell(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const Vector3d direction = cell.cast<double>().normalized();
    found = {true, direction, extentOf(*a.position, direction), extentOf(*b.position, direction)};
    if (separates(found, motionsOfA, motionsOfB)) return false;
  }
  found.isKnown = false;
  return true;
}

// --- the pairs ---------------------------------------------------------------------------------------------

bool isBetweenMovingBodies(const SurfaceCandidate& m) { return !m.held && m.other != m.body; }

/// `axis` is what separated the pair in an earlier round; it is renewed.
bool mayTouchNow(const SurfaceCandidate& m, Motions& motions, double tick, SurfaceSearch& search,
                 SeparatingAxis& axis) {
  const AlignedBox3d &a = motions.of(*m.body), &b = motions.ofOther(m);
  if (axis.isKnown && separates(axis, a, b)) return false;
  const MovingSurface& other = m.other ? m.other->surface.moving : m.part->moving;
  return mayMeet(m.body->surface.moving, a, other, b, axis) && mayTouch(m, tick, search);
}

/// Moves the pairs that may touch now to found.candidates. Returns whether there are any.
bool takeStopped(Motions& motions, TickContacts& found, SurfaceSearch& search) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found.waiting.size(); ++i) {
    SurfaceCandidate& m = found.waiting[i];
    m.stopped = motions.ofBoth(m).diagonal().norm();
    if (mayTouchNow(m, motions, found.tick, search, search.axes[i])) {
      if (m.partner) found.add(*m.partner);
      found.candidates.push_back(m);
    } else {
      search.axes[kept] = search.axes[i];
      found.waiting[kept++] = m;
    }
  }
  const bool any = kept < found.waiting.size();
  found.waiting.resize(kept);
  return any;
}

}  // namespace

void addStoppedPairs(btDispatcher& dispatcher, TickContacts& found, SurfaceSearch& search) {
  if (found.waiting.empty()) return;
  Motions motions(found.tick, search);
  search.axes.assign(found.waiting.size(), SeparatingAxis());
  for (const SurfaceCandidate& m : found.waiting) motions.start(m);
  for (const SurfaceCandidate& m : found.candidates)
    if (isBetweenMovingBodies(m)) motions.start(m);
  motions.addManifolds(dispatcher);
  for (bool grown = true; grown;) {
    grown = false;
    for (const SurfaceCandidate& m : found.candidates)
      if (isBetweenMovingBodies(m)) grown = motions.join(m) || grown;
    grown = takeStopped(motions, found, search) || grown;
  }
}

// --- searches within the step: the contacts of a pair ------------------------------------------------------

namespace {

// --- the contacts of a pair --------------------------------------------------------------------------------

/// Calls visit(key, index in step.pairs.contacts) for each contact of a candidate.
template <class Visit>
void forEachContact(const Island& island, std::uint32_t number, const TickContacts& found, Visit visit) {
  const SurfaceCandidate& m = *island.candidates[number].surfaces;
  const auto begin = island.contacts.begin();
  for (auto it = std::lower_bound(begin, island.contacts.end(), m.first);
       it != island.contacts.end() && *it < m.end; ++it)
    visit(found.contacts[*it].source.key, static_cast<std::uint32_t>(it - begin));
  const std::size_t first = island.contacts.size() + island.rows.size();
  for (std::uint32_t i = island.candidates[number].firstLate; i != IslandPair::kNone; i = island.late[i].next)
    visit(island.late[i].source.key, static_cast<std::uint32_t>(first + i));
}

/// Lists the contacts of a candidate that have borne a load in this tick.
void listBearing(const Island& island, std::uint32_t number, const TickContacts& found,
                 std::vector<std::uint64_t>& keys) {
  keys.clear();
  forEachContact(island, number, found, [&](std::uint64_t key, std::uint32_t i) {
    if (island.step.pairs.contacts[i].impulse.along > 0.0) keys.push_back(key);
  });
}

/// Collects the contacts of a candidate and marks them as ended until the search finds them again.
void collectOldContacts(Island& island, std::uint32_t number, const TickContacts& found) {
  island.oldContacts.clear();
  forEachContact(island, number, found,
                 [&](std::uint64_t key, std::uint32_t i) { island.oldContacts.emplace_back(key, i); });
  std::sort(island.oldContacts.begin(), island.oldContacts.end());
  for (const auto& [key, i] : island.oldContacts) island.step.pairs.contacts[i].ended = true;
}

/// Returns the old contact with this key, or nullptr.
Contact* oldContact(Island& island, std::uint64_t key) {
  const auto it = std::lower_bound(island.oldContacts.begin(), island.oldContacts.end(),
                                   std::pair(key, std::uint32_t{0}));
  const bool found = it != island.oldContacts.end() && it->first == key;
  return found ? &island.step.pairs.contacts[it->second] : nullptr;
}

/// Returns a number by which contacts are sorted: equal for contacts with the same points of side a.
std::uint64_t numberOfPoints(const Contact& contact) {
  const auto& [first, second, third] = contact.a.point;
  return (std::uint64_t{first} << 42) ^ (std::uint64_t{second} << 21) ^ third ^
         (std::uint64_t{contact.a.count} << 62);
}

/// Sorts the old contacts that have ended by their points, and within these by their keys.
void sortEndedContacts(Island& island) {
  island.endedContacts.clear();
  for (std::uint32_t i = 0; i < island.oldContacts.size(); ++i)
    if (const Contact& old = island.step.pairs.contacts[island.oldContacts[i].second]; old.ended)
      island.endedContacts.emplace_back(numberOfPoints(old), i);
  std::sort(island.endedContacts.begin(), island.endedContacts.end());
}

/// Returns an ended contact of the same points in the same direction, or nullptr: one that has moved from one
/// triangle of a face to the next.
Contact* endedContact(Island& island, const Contact& contact) {
  const std::uint64_t number = numberOfPoints(contact);
  for (auto it = std::lower_bound(island.endedContacts.begin(), island.endedContacts.end(),
                                  std::pair(number, std::uint32_t{0}));
       it != island.endedContacts.end() && it->first == number; ++it) {
    Contact& old = island.step.pairs.contacts[island.oldContacts[it->second].second];
    if (old.ended && old.a.count == contact.a.count && old.a.point == contact.a.point &&
        old.normal.dot(contact.normal) > kSameSurface)
      return &old;
  }
  return nullptr;
}

/// Replaces a contact by the same at a later time.
void renew(Contact& stored, const Contact& contact) {
  const ContactImpulse positionImpulse = stored.positionImpulse, velocityImpulse = stored.velocityImpulse;
  const TickImpulse impulse = stored.impulse;
  stored = contact;
  stored.positionImpulse = positionImpulse, stored.velocityImpulse = velocityImpulse;
  stored.impulse = impulse;
}

/// Stores the contacts that a search has found for a candidate.
void storeFound(Island& island, std::uint32_t number, const TickContacts& found, ContactsInStep& inStep) {
  IslandPair& m = island.candidates[number];
  collectOldContacts(island, number, found);
  std::vector<std::uint32_t>& newOnes = inStep.newOnes;
  newOnes.clear();
  for (std::uint32_t i = 0; i < inStep.contacts.size(); ++i) {
    TickContact& contact = inStep.contacts[i];
    contact.a.body = m.a;
    contact.b.body = m.b;
    if (Contact* old = oldContact(island, contact.source.key))
      renew(*old, contact);
    else
      newOnes.push_back(i);
  }
  if (!newOnes.empty()) sortEndedContacts(island);
  for (const std::uint32_t i : newOnes) {
    if (Contact* old = endedContact(island, inStep.contacts[i])) {
      renew(*old, inStep.contacts[i]);
      continue;
    }
    const auto late = static_cast<std::uint32_t>(island.late.size());
    (m.lastLate == IslandPair::kNone ? m.firstLate : island.late[m.lastLate].next) = late;
    m.lastLate = late;
    island.late.push_back({number, inStep.contacts[i].source, IslandPair::kNone});
    island.step.pairs.contacts.push_back(inStep.contacts[i]);
  }
}

// --- which pairs are due -----------------------------------------------------------------------------------

/// Fraction of the size of a surface's features: the largest relative displacement of surfaces in one
/// substep.
constexpr double kMaxInSubstep = 0.1;

/// What fine meshes may need even if their features move past each other quickly: searches for this
/// displacement (of features), and substeps.
constexpr double kManySearched = 0.8, kManySubsteps = 64.0;

/// Returns the number of searches of the pair in a tick with this displacement (of features).
double searchesFor(const IslandPair& m, double displacement) {
  return std::min(displacement / m.searchDistance,
                  std::max(kManySearched / m.searchDistance, displacement / kMaxInSubstep));
}

/// Longest time between two searches of a pair that moves, in rounds.
constexpr std::uint32_t kLongestPeriod = 16;

/// Of the surface of a body that rotates about its centre of mass.
SurfaceMotion motionOf(const RigidState& rigid, const btRigidBody& body) {
  const double radius = double(body.getCollisionShape()->getAngularMotionDisc());
  return {rigid.position,
          rigid.velocity,
          rigid.angularVelocity,
          radius,
          rigid.angularVelocity.norm() * radius,
          0.0};
}

SurfaceMotion motionOfB(const IslandPair& m, const Island& island) {
  if (m.surfaces->other) return island.motions[m.b];
  if (m.surfaces->held) return m.held;
  return motionOf(island.step.links.rigids[m.b], *m.surfaces->partner);
}

/// Returns the present motion of side a relative to side b.
RelativeMotion relativeMotion(const IslandPair& m, const Island& island) {
  return relativeMotion(island.motions[m.a], motionOfB(m, island), m.frame);
}

/// Stores the present relative motion, in the frame in which it is least.
void rememberMotion(IslandPair& m, const Island& island) {
  m.frame = calmestFrame(island.motions[m.a], motionOfB(m, island), featureSizeOf(*m.surfaces));
  m.known = relativeMotion(m, island);
  m.moved = 0.0;
}

/// Motion under load between two searches, as a share of the radius of points.
constexpr double kUnderLoad = 0.5;

/// Returns a motion in `time` s as a share of that after which a search is due. A search finds the contacts
/// of the motion at its time. Of the motion that hits have added since, the sum of the radii counts as a
/// whole share: the surfaces must be found before they are through one another. Under a load that throws
/// points round edges, so does a part of the points' radius of all motion.
double shareOf(const IslandPair& m, const RelativeMotion& motion, double time, double tick) {
  const double features = featureSizeOf(*m.surfaces), speed = motion.speed(features);
  const double added = (motion.mean - m.known.mean).norm() + std::max(0.0, motion.spread - m.known.spread);
  const double underLoad =
      m.releases > 0.0 ? speed / (kUnderLoad * m.surfaces->body->surface.moving.radius) : 0.0;
  return searchesFor(m, tick * speed / features) * time / tick + added * time / radiusSumOf(*m.surfaces) +
         underLoad * time;
}

/// Sets the periods of the pairs that would move too far until the next round, `ahead` s from now, and 0 for
/// all others. Returns the longest period.
std::uint32_t findDue(Island& island, double ahead, double tick) {
  std::uint32_t longest = 0;
  for (IslandPair& m : island.candidates) {
    m.period = 0;
    if (!m.needsNewSearch()) continue;
    m.moved += m.moving;
    m.moving = shareOf(m, relativeMotion(m, island), ahead, tick);
    if (m.moved + m.moving <= 1.0) continue;
    rememberMotion(m, island);
    m.moving = shareOf(m, m.known, ahead, tick);
    for (m.period = 1; m.period < kLongestPeriod && 2.0 * m.period * m.moving <= 1.0;) m.period *= 2;
    longest = std::max(longest, m.period);
  }
  return longest;
}

void findMotions(Island& island, const std::vector<PointView>& views, Team& team) {
  island.motions.resize(island.softBodies.size());
  team.forEach(static_cast<std::uint32_t>(island.softBodies.size()), [&](std::uint32_t i) {
    island.motions[i] = fittedMotion(views[i], island.step.bodies[i].points->position.cols());
  });
}

// --- a round of searches -----------------------------------------------------------------------------------

/// Candidates that one task searches.
constexpr std::uint32_t kCandidatesPerTask = 8;

/// Lists the candidates with this period, and their bodies.
void listSearched(Island& island, std::uint32_t period) {
  island.searched.clear();
  island.moved.clear();
  for (std::uint32_t number = 0; number < island.candidates.size(); ++number) {
    const IslandPair& m = island.candidates[number];
    if (m.period != period) continue;
    island.searched.push_back(number);
    island.moved.push_back(m.a);
    if (m.surfaces->other) island.moved.push_back(m.b);
  }
  sortUnique(island.moved);
  if (island.inStep.size() < island.searched.size()) island.inStep.resize(island.searched.size());
}

/// Returns side b if it is rigid and dynamic, else nullptr.
const RigidState* rigidOf(const IslandPair& m, const SolverIsland& group) {
  return m.surfaces->other || m.surfaces->held ? nullptr : &group.links.rigids[m.b];
}

/// Searches the candidates of a period for the contacts until their next search.
void searchPeriod(const SearchContext& c, SolverIsland& group, Team& team, std::uint32_t period,
                  const TimeInStep& time) {
  Island& island = *c.island;
  listSearched(island, period);
  const auto searched = static_cast<std::uint32_t>(island.searched.size());
  team.forEach(static_cast<std::uint32_t>(island.moved.size()), [&](std::uint32_t i) {
    moveInStep(*island.softBodies[island.moved[i]], group.links.views[island.moved[i]], time);
  });
  const auto pairAt = [&](std::uint32_t i) -> const IslandPair& {
    return island.candidates[island.searched[i]];
  };
  for (std::uint32_t i = 0; i < searched; ++i) {
    movePartInStep(*pairAt(i).surfaces, rigidOf(pairAt(i), group), time);
    listBearing(island, island.searched[i], *c.found, island.inStep[i].bearing);
  }
  team.forEach((searched + kCandidatesPerTask - 1) / kCandidatesPerTask, [&](std::uint32_t block) {
    c.searches->with([&](SurfaceSearch& search) {
      const std::uint32_t end = std::min((block + 1) * kCandidatesPerTask, searched);
      for (std::uint32_t i = block * kCandidatesPerTask; i < end; ++i)
        findContactsInStep(*pairAt(i).surfaces, rigidOf(pairAt(i), group), time, search, island.inStep[i]);
    });
  });
  for (std::uint32_t i = 0; i < searched; ++i)
    storeFound(island, island.searched[i], *c.found, island.inStep[i]);
}

void searchInStep(void* context, SolverIsland& group, Team& team, double since, double ahead) {
  const SearchContext& c = *static_cast<SearchContext*>(context);
  Island& island = *c.island;
  // islands share the parts of kinematic objects, which are moved to the time of the search
  std::unique_lock<std::mutex> lock(*c.lock, std::defer_lock);
  const auto isMovedPart = [](const IslandPair& m) { return m.surfaces->held && isMoved(*m.surfaces->held); };
  if (std::any_of(island.candidates.begin(), island.candidates.end(), isMovedPart)) lock.lock();
  const double tick = c.found->tick;
  findMotions(island, group.links.views, team);
  const std::uint32_t longest = findDue(island, ahead, tick);
  for (std::uint32_t period = 1; period <= longest; period *= 2)
    searchPeriod(c, group, team, period, {since, std::min(period * ahead, tick - since), tick});
}

// --- the plan ----------------------------------------------------------------------------------------------

/// The largest needs of the pairs that are searched within the step.
struct SearchNeeds {
  double searches = 0.0;  ///< 0: no pair is searched
  double displacement =
      0.0;                ///< of features, where there are contacts: the others do not affect the substeps
  double releases = 0.0;  ///< 1/s, see releasesOf()
};

SearchNeeds searchNeeds(const Island& island) {
  SearchNeeds most;
  for (const IslandPair& m : island.candidates) {
    if (!m.needsNewSearch()) continue;
    most.searches = std::max(most.searches, searchesFor(m, m.displacement));
    most.releases = std::max(most.releases, m.releases);
    if (m.surfaces->end > m.surfaces->first) most.displacement = std::max(most.displacement, m.displacement);
  }
  return most;
}

/// Returns at most the maximum of any group.
int substepsFor(const Island& island, const SearchNeeds& needs, double tick) {
  const double wanted = std::max(needs.displacement / kMaxInSubstep, tick * needs.releases);
  int substeps = static_cast<int>(std::ceil(std::min(wanted, kManySubsteps)));
  for (const LinkedGroup* group : island.groups)
    if (group->stepping.maxSubsteps > 0) substeps = std::min(substeps, group->stepping.maxSubsteps);
  return substeps;
}

/// All contacts have been searched for at the start of the step.
void startRounds(Island& island, double ahead, double tick) {
  for (IslandPair& m : island.candidates) {
    if (!m.needsNewSearch()) continue;
    rememberMotion(m, island);
    m.moving = shareOf(m, m.known, ahead, tick);
  }
}

}  // namespace

SurfaceMotion heldMotion(const RigidPart& part, double tick) {
  SurfaceMotion m = fittedMotion(*part.moving.position, part.motion);
  m.mean /= tick, m.turn /= tick, m.spread /= tick, m.deformation /= tick;
  return m;
}

int planSearches(SearchContext& context, int substeps) {
  Island& island = *context.island;
  island.step.again = PairSearch();
  const SearchNeeds needs = searchNeeds(island);
  if (!(needs.searches > 0.0)) return substeps;
  if (needs.displacement > 0.0)
    substeps = std::max(substeps, substepsFor(island, needs, context.found->tick));
  const int every = std::max(1, static_cast<int>(substeps / needs.searches));
  island.step.again = {every, &context, searchInStep};
  const double tick = context.found->tick;
  island.motions.clear();
  for (const SolverBody& body : island.step.bodies)
    island.motions.push_back(fittedMotion(viewOf(*body.points), body.points->position.cols()));
  startRounds(island, tick * every / substeps, tick);
  return substeps;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This file finds the bodies that contacts and joints couple in a tick, and makes an island of each such set.

#include "bullet/linked_group.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

constexpr std::uint32_t kNone = TickContacts::kNone;

// --- coupled nodes -----------------------------------------------------------------------------------------

/// Islands are in the order of their first members.
void join(DisjointSets& sets, std::uint32_t a, std::uint32_t b) {
  if (a != kNone && b != kNone) sets.join(a, b);
}

/// Maps contact points and constraint rows to nodes.
struct IslandNodes {
  std::uint32_t groups;
  const std::vector<std::uint32_t>& groupOf;  ///< of a soft body, by SoftBodyData::index

  std::uint32_t of(const ContactPoint& point) const {
    if (point.kind == ContactPoint::Kind::Soft) return groupOf[point.body];
    return point.kind == ContactPoint::Kind::Rigid ? groups + point.body : kNone;
  }
  std::uint32_t ofRigid(std::uint32_t number) const {
    return number == JointConstraint::kHeld ? kNone : groups + number;
  }
  std::uint32_t of(const SoftBodyData& body) const { return groupOf[body.index]; }
  std::uint32_t ofOther(const SurfaceCandidate& m, const TickContacts& found) const {
    if (m.other) return of(*m.other);
    return m.partner ? ofRigid(found.find(*m.partner)) : kNone;
  }
  std::uint32_t of(const Contact& c) const { return of(c.a) != kNone ? of(c.a) : of(c.b); }
  std::uint32_t of(const JointConstraint& j) const {
    return ofRigid(j.a) != kNone ? ofRigid(j.a) : ofRigid(j.b);
  }
};

void joinNodes(const AwakeGroups& groups, const TickContacts& found, const IslandNodes& nodes,
               Islands& islands) {
  DisjointSets& sets = islands.sets;
  sets.reset(groups.size() + found.rigids.size());
  for (std::uint32_t g = 0; g < groups.size(); ++g)
    for (const RigidPartner& rigid : groups[g]->rigids)
      if (!rigid.held && found.find(*rigid.body) != kNone)
        join(sets, g, nodes.ofRigid(found.find(*rigid.body)));
  for (const Contact& c : found.contacts) join(sets, nodes.of(c.a), nodes.of(c.b));
  for (const SurfaceCandidate& m : found.candidates) join(sets, nodes.of(*m.body), nodes.ofOther(m, found));
  for (const JointConstraint& j : found.joints) join(sets, nodes.ofRigid(j.a), nodes.ofRigid(j.b));
  for (std::uint32_t number = 0; number < found.rigids.size(); ++number)
    if (const SurfaceObject* surface = SurfaceObject::from(found.rigids[number].body))
      join(sets, nodes.of(*surface->owner()), nodes.ofRigid(number));
}

// --- filling the islands ----------------------------------------------------------------------------------

void clear(Island& island) {
  island.groups.clear();
  island.softBodies.clear();
  island.rigids.clear();
  island.contacts.clear();
  island.rows.clear();
  island.joints.clear();
  island.candidates.clear();
  island.late.clear();
  island.step.bodies.clear();
  island.step.pairs.contacts.clear();
  island.step.pairs.joints.clear();
  island.step.links.points.clear();
  island.step.links.rigids.clear();
  island.step.links.frames.clear();
  island.step.links.springs.clear();
  island.step.links.anchors.clear();
}

/// Returns the island of a node, or a new one if its set has none yet.
Island& islandOf(Islands& islands, std::uint32_t node) {
  std::uint32_t& number = islands.island[islands.sets.root(node)];
  if (number == kNone) {
    number = static_cast<std::uint32_t>(islands.count++);
    if (islands.all.size() < islands.count) islands.all.emplace_back();
    clear(islands.all[number]);
  }
  return islands.all[number];
}

LinkEnd withOffset(LinkEnd end, std::uint32_t firstBody, std::uint32_t firstRigid) {
  if (end.kind != LinkEnd::Kind::World) end.body += end.kind == LinkEnd::Kind::Rigid ? firstRigid : firstBody;
  return end;
}

void append(Island& island, LinkedGroup& group) {
  useSpringBatches(group);
  SolverIsland& step = island.step;
  const auto firstBody = static_cast<std::uint32_t>(step.bodies.size());
  const auto firstRigid = static_cast<std::uint32_t>(step.links.rigids.size());
  const LinkedBodies& links = group.step.links;
  island.groups.push_back(&group);
  island.softBodies.insert(island.softBodies.end(), group.bodies.begin(), group.bodies.end());
  step.bodies.insert(step.bodies.end(), group.step.bodies.begin(), group.step.bodies.end());
  step.links.points.insert(step.links.points.end(), links.points.begin(), links.points.end());
  step.links.rigids.insert(step.links.rigids.end(), links.rigids.begin(), links.rigids.end());
  for (LinkSpring spring : links.springs) {
    spring.a = withOffset(spring.a, firstBody, firstRigid);
    spring.b = withOffset(spring.b, firstBody, firstRigid);
    step.links.springs.push_back(spring);
  }
  for (LinkAnchor anchor : links.anchors) {
    anchor.point = withOffset(anchor.point, firstBody, firstRigid);
    anchor.pivot = withOffset(anchor.pivot, firstBody, firstRigid);
    step.links.anchors.push_back(anchor);
  }
}

void appendGroups(const AwakeGroups& groups, const TickContacts& found, const IslandNodes& nodes,
                  Islands& islands) {
  for (std::uint32_t g = 0; g < groups.size(); ++g) {
    LinkedGroup& group = *groups[g];
    group.inIsland = islands.island[islands.sets.root(g)] != kNone;
    if (!group.inIsland) continue;
    Island& island = islandOf(islands, g);
    islands.first[g] = static_cast<std::uint32_t>(island.step.bodies.size());
    const auto firstRigid = static_cast<std::uint32_t>(island.step.links.rigids.size());
    for (std::uint32_t i = 0; i < group.rigids.size(); ++i)
      if (const std::uint32_t number = found.find(*group.rigids[i].body);
          number != kNone && !group.rigids[i].held)
        islands.first[nodes.ofRigid(number)] = firstRigid + i;
    append(island, group);
  }
}

/// Returns the index of a body in its island.
std::uint32_t solverIndexOf(const SoftBodyData& body, const IslandNodes& nodes, const Islands& islands) {
  return islands.first[nodes.of(body)] + islands.indexInGroup[body.index];
}

/// Makes the last rigid body stand for a soft body. Forces and gravity act on the points.
void addFrame(LinkedBodies& links, std::uint32_t body) {
  RigidState& rigid = links.rigids.back();
  rigid.isFrame = true;
  rigid.gyroscopic = false;
  rigid.acceleration.setZero();
  rigid.angularAcceleration.setZero();
  links.frames.push_back({body, static_cast<std::uint32_t>(links.rigids.size() - 1)});
}

void appendRigids(TickContacts& found, const IslandNodes& nodes, btScalar tick, Islands& islands) {
  for (std::uint32_t number = 0; number < found.rigids.size(); ++number) {
    const std::uint32_t node = nodes.ofRigid(number);
    if (islands.first[node] != kNone || islands.island[islands.sets.root(node)] == kNone) continue;
    Island& island = islandOf(islands, node);
    islands.first[node] = static_cast<std::uint32_t>(island.step.links.rigids.size());
    island.rigids.push_back(number);
    island.step.links.rigids.emplace_back();
    gatherRigid(found.rigids[number], island.step.links.rigids.back(), tick);
    if (const SurfaceObject* surface = SurfaceObject::from(found.rigids[number].body))
      addFrame(island.step.links, solverIndexOf(*surface->owner(), nodes, islands));
  }
}

/// Replaces the index of a body in the system by that in its island.
void renumber(ContactPoint& point, const IslandNodes& nodes, const Islands& islands) {
  if (point.kind == ContactPoint::Kind::World) return;
  const bool isSoft = point.kind == ContactPoint::Kind::Soft;
  point.body = islands.first[nodes.of(point)] + (isSoft ? islands.indexInGroup[point.body] : 0);
}

void appendContacts(const TickContacts& found, const IslandNodes& nodes, Islands& islands) {
  for (std::uint32_t i = 0; i < found.contacts.size(); ++i) {
    Island& island = islandOf(islands, nodes.of(found.contacts[i]));
    island.contacts.push_back(i);
    island.step.pairs.contacts.push_back(found.contacts[i]);
    Contact& c = island.step.pairs.contacts.back();
    renumber(c.a, nodes, islands);
    renumber(c.b, nodes, islands);
  }
  for (std::uint32_t i = 0; i < found.joints.size(); ++i) {
    Island& island = islandOf(islands, nodes.of(found.joints[i]));
    island.joints.push_back(i);
    island.step.pairs.joints.push_back(found.joints[i]);
    JointConstraint& j = island.step.pairs.joints.back();
    for (std::uint32_t* side : {&j.a, &j.b})
      if (*side != JointConstraint::kHeld) *side = islands.first[nodes.ofRigid(*side)];
    if (j.contact == JointConstraint::kHeld) continue;
    const auto it = std::lower_bound(island.contacts.begin(), island.contacts.end(), j.contact);
    j.contact = static_cast<std::uint32_t>(it - island.contacts.begin());
  }
}

/// Returns whether an anchored point of the group has contacts: its anchor must be solved with them.
bool hasAnchorsAndContacts(const LinkedGroup& group) {
  const auto hasContacts = [](const SoftBodyData* body) { return !body->contacts.empty(); };
  return !group.step.links.anchors.empty() &&
         std::any_of(group.bodies.begin(), group.bodies.end(), hasContacts);
}

void appendCandidates(const TickContacts& found, const IslandNodes& nodes, Islands& islands) {
  for (const SurfaceCandidate& m : found.candidates) {
    IslandPair candidate;
    candidate.surfaces = &m;
    candidate.a = solverIndexOf(*m.body, nodes, islands);
    candidate.displacement = displacementOf(m, found.tick);
    candidate.searchDistance = searchDistanceOf(m);
    candidate.releases = releasesOf(m, found.tick);
    if (m.other)
      candidate.b = solverIndexOf(*m.other, nodes, islands);
    else if (!m.held)
      candidate.b = islands.first[nodes.ofRigid(found.find(*m.partner))];
    else if (candidate.needsNewSearch())
      candidate.held = heldMotion(*m.part, found.tick);
    islandOf(islands, nodes.groupOf[m.body->index]).candidates.push_back(candidate);
  }
}

void numberBodies(const AwakeGroups& groups, Islands& islands) {
  for (std::uint32_t g = 0; g < groups.size(); ++g)
    for (std::uint32_t i = 0; i < groups[g]->bodies.size(); ++i) {
      const std::size_t body = groups[g]->bodies[i]->index;
      if (body >= islands.groupOf.size()) {
        islands.groupOf.resize(body + 1);
        islands.indexInGroup.resize(body + 1);
      }
      islands.groupOf[body] = g;
      islands.indexInGroup[body] = i;
    }
}

// --- contacts of points with static and kinematic surfaces -------------------------------------------------

/// Marks the points that dynamic bodies touch, or may touch within the tick. Their plane contacts would give
/// way if they were solved separately.
void markCoupledPoints(Island& island) {
  for (SoftBodyData* body : island.softBodies) body->coupled.assign(pointCount(*body), 0);
  for (const IslandPair& m : island.candidates)
    for (SoftBodyData* body : {m.surfaces->body, m.surfaces->other})
      if (m.needsNewSearch() && !m.surfaces->held && body) body->coupled.assign(body->coupled.size(), 1);
  for (const Contact& c : island.step.pairs.contacts)
    for (const ContactPoint* point : {&c.a, &c.b})
      if (point->kind == ContactPoint::Kind::Soft)
        for (std::uint32_t i = 0; i < point->count; ++i)
          island.softBodies[point->body]->coupled[point->point[i]] = 1;
  for (const LinkAnchor& anchor : island.step.links.anchors)
    island.softBodies[anchor.point.body]->coupled[anchor.point.point] = 1;
  for (const BodyFrame& frame : island.step.links.frames) {
    std::vector<unsigned char>& coupled = island.softBodies[frame.body]->coupled;
    coupled.assign(coupled.size(), 1);
  }
}

Contact contactOf(const PlaneContact& row, const SoftBodyData& body, std::uint32_t bodyIndex) {
  Contact c;
  c.a = softPoint(bodyIndex, row.point);
  c.b.velocity = row.surfaceVelocity, c.b.acceleration = row.surfaceAcceleration;
  static_cast<ContactBase&>(c) = row;
  c.gap = row.normal.dot(body.state.position.col(row.point) - row.touch);
  c.held = row.around ? &row : nullptr;
  return c;
}

/// Moves the plane contacts of coupled points from their bodies to the island's contacts. A point that is
/// pressed between a static surface and a dynamic body must be solved with both.
void appendPlaneContacts(Island& island) {
  markCoupledPoints(island);
  for (std::uint32_t bodyIndex = 0; bodyIndex < island.softBodies.size(); ++bodyIndex) {
    SoftBodyData& body = *island.softBodies[bodyIndex];
    for (std::size_t i = 0; i < body.contacts.size(); ++i) {
      PlaneContact& row = body.contacts[i];
      row.coupled = body.coupled[row.point] != 0;
      if (!row.coupled) continue;
      island.rows.push_back(&row);
      island.step.pairs.contacts.push_back(contactOf(row, body, bodyIndex));
      warmStart(body, i, island.step.pairs.contacts.back());
    }
  }
}

/// m/s, of a side of a contact; `soft` is its soft body.
Eigen::Vector3d velocityOf(const ContactPoint& side, const SoftBodyData* soft, const TickContacts& found) {
  Eigen::Vector3d velocity = side.velocity;
  if (side.kind == ContactPoint::Kind::Rigid)
    velocity += toEigen(found.rigids[side.body].body->getVelocityInLocalPoint(toBullet(side.arm)));
  for (std::uint32_t k = 0; soft && k < side.count; ++k)
    velocity += side.weight[k] * soft->state.velocity.col(side.point[k]);
  return velocity;
}

/// Sets SoftBodyData::approach.
void findApproaches(const AwakeGroups& groups, const TickContacts& found) {
  for (LinkedGroup* group : groups)
    for (SoftBodyData* body : group->bodies) body->approach = -HUGE_VAL;
  const auto note = [](SoftBodyData* body, double speed) {
    if (body) body->approach = std::max(body->approach, speed);
  };
  for (const TickContact& c : found.contacts) {
    const ContactSource& source = c.source;
    if (!source.body) continue;
    const double speed =
        c.normal.dot(velocityOf(c.b, source.other, found) - velocityOf(c.a, source.body, found));
    note(source.body, speed), note(source.other, speed);
  }
}

}  // namespace

void addLinkedRigids(const AwakeGroups& groups, TickContacts& found) {
  for (const LinkedGroup* group : groups)
    for (const RigidPartner& rigid : group->rigids)
      if (isFree(*rigid.body)) found.add(*rigid.body);
}

void makeIslands(const AwakeGroups& groups, TickContacts& found, btScalar tick, Islands& islands) {
  islands.count = 0;
  bool anchored = false;
  for (LinkedGroup* group : groups) {
    group->inIsland = false;
    anchored = anchored || hasAnchorsAndContacts(*group);
  }
  findApproaches(groups, found);
  if (found.contacts.empty() && found.joints.empty() && found.candidates.empty() && !anchored) return;
  numberBodies(groups, islands);
  const IslandNodes nodes{static_cast<std::uint32_t>(groups.size()), islands.groupOf};
  joinNodes(groups, found, nodes, islands);
  islands.island.assign(groups.size() + found.rigids.size(), kNone);
  islands.first.assign(groups.size() + found.rigids.size(), kNone);
  for (const Contact& c : found.contacts) islandOf(islands, nodes.of(c));
  for (const JointConstraint& j : found.joints) islandOf(islands, nodes.of(j));
  for (const SurfaceCandidate& m : found.candidates) islandOf(islands, nodes.of(*m.body));
  for (std::uint32_t g = 0; g < groups.size(); ++g)
    if (hasAnchorsAndContacts(*groups[g])) islandOf(islands, g);
  appendGroups(groups, found, nodes, islands);
  appendRigids(found, nodes, tick, islands);
  appendContacts(found, nodes, islands);
  appendCandidates(found, nodes, islands);
  for (Island& island : islands) appendPlaneContacts(island);
}

void numberIsland(const std::vector<SoftBodyData*>& bodies) {
  std::uint32_t smallest = UINT32_MAX;
  for (const SoftBodyData* body : bodies) smallest = std::min(smallest, body->index);
  for (SoftBodyData* body : bodies) body->island = static_cast<int>(smallest);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

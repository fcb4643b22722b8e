// SPDX-License-Identifier: Zlib

// This file finds what contacts and joints couple in a tick, and puts each such set together for one step.

#include "bullet/tick_group.h"

#include <algorithm>
#include <numeric>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

constexpr std::uint32_t kNoPartner = TickContacts::kNone;

// --- which node is coupled to which ------------------------------------------------------------------------

std::uint32_t root(Clusters& clusters, std::uint32_t i) {
  std::vector<std::uint32_t>& parent = clusters.parent;
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// The lower number becomes the root, so that clusters come in the order of their first member.
void join(Clusters& clusters, std::uint32_t a, std::uint32_t b) {
  if (a == kNoPartner || b == kNoPartner) return;
  a = root(clusters, a), b = root(clusters, b);
  clusters.parent[std::max(a, b)] = std::min(a, b);
}

/// The nodes that places and rows are on.
struct ClusterNodes {
  std::uint32_t groups;
  const std::vector<std::uint32_t>& groupOf;  ///< of a soft body, by SoftBodyData::index

  std::uint32_t of(const ContactPlace& place) const {
    if (place.kind == ContactPlace::Kind::Soft) return groupOf[place.body];
    return place.kind == ContactPlace::Kind::Rigid ? groups + place.body : kNoPartner;
  }
  std::uint32_t ofRigid(std::uint32_t number) const {
    return number == JointRow::kHeld ? kNoPartner : groups + number;
  }
  std::uint32_t of(const SoftBodyData& body) const { return groupOf[body.index]; }
  std::uint32_t ofOther(const SurfaceMeeting& m, const TickContacts& found) const {
    if (m.other) return of(*m.other);
    return m.partner ? ofRigid(found.find(*m.partner)) : kNoPartner;
  }
  std::uint32_t of(const PairContact& c) const { return of(c.a) != kNoPartner ? of(c.a) : of(c.b); }
  std::uint32_t of(const JointRow& j) const { return ofRigid(j.a) != kNoPartner ? ofRigid(j.a) : ofRigid(j.b); }
};

void joinNodes(const std::vector<TickGroup>& groups, const TickContacts& found, const ClusterNodes& nodes,
               Clusters& clusters) {
  clusters.parent.resize(groups.size() + found.rigids.size());
  std::iota(clusters.parent.begin(), clusters.parent.end(), std::uint32_t{0});
  for (std::uint32_t g = 0; g < groups.size(); ++g)
    for (const RigidPartner& rigid : groups[g].rigids)
      if (!groups[g].asleep && !rigid.held && found.find(*rigid.body) != kNoPartner)
        join(clusters, g, nodes.ofRigid(found.find(*rigid.body)));
  for (const PairContact& c : found.contacts) join(clusters, nodes.of(c.a), nodes.of(c.b));
  for (const SurfaceMeeting& m : found.meetings) join(clusters, nodes.of(*m.body), nodes.ofOther(m, found));
  for (const JointRow& j : found.joints) join(clusters, nodes.ofRigid(j.a), nodes.ofRigid(j.b));
}

// --- filling the clusters ----------------------------------------------------------------------------------

void clear(Cluster& cluster) {
  cluster.groups.clear();
  cluster.softBodies.clear();
  cluster.rigids.clear();
  cluster.contacts.clear();
  cluster.rows.clear();
  cluster.joints.clear();
  cluster.meetings.clear();
  cluster.late.clear();
  cluster.step.bodies.clear();
  cluster.step.pairs.contacts.clear();
  cluster.step.pairs.joints.clear();
  cluster.step.links.points.clear();
  cluster.step.links.rigids.clear();
  cluster.step.links.springs.clear();
  cluster.step.links.anchors.clear();
}

/// The cluster of a node, a new one if its set has none yet.
Cluster& clusterOf(Clusters& clusters, std::uint32_t node) {
  std::uint32_t& number = clusters.cluster[root(clusters, node)];
  if (number == kNoPartner) {
    number = static_cast<std::uint32_t>(clusters.count++);
    if (clusters.all.size() < clusters.count) clusters.all.emplace_back();
    clear(clusters.all[number]);
  }
  return clusters.all[number];
}

LinkEnd moved(LinkEnd end, std::uint32_t firstBody, std::uint32_t firstRigid) {
  if (end.kind != LinkEnd::Kind::World) end.body += end.kind == LinkEnd::Kind::Rigid ? firstRigid : firstBody;
  return end;
}

void append(Cluster& cluster, TickGroup& group) {
  StepGroup& step = cluster.step;
  const auto firstBody = static_cast<std::uint32_t>(step.bodies.size());
  const auto firstRigid = static_cast<std::uint32_t>(step.links.rigids.size());
  const LinkedBodies& links = group.step.links;
  cluster.groups.push_back(&group);
  cluster.softBodies.insert(cluster.softBodies.end(), group.bodies.begin(), group.bodies.end());
  step.bodies.insert(step.bodies.end(), group.step.bodies.begin(), group.step.bodies.end());
  step.links.points.insert(step.links.points.end(), links.points.begin(), links.points.end());
  step.links.rigids.insert(step.links.rigids.end(), links.rigids.begin(), links.rigids.end());
  for (LinkSpring spring : links.springs) {
    spring.a = moved(spring.a, firstBody, firstRigid);
    spring.b = moved(spring.b, firstBody, firstRigid);
    step.links.springs.push_back(spring);
  }
  for (LinkAnchor anchor : links.anchors) {
    anchor.point = moved(anchor.point, firstBody, firstRigid);
    anchor.pivot = moved(anchor.pivot, firstBody, firstRigid);
    step.links.anchors.push_back(anchor);
  }
}

void appendGroups(std::vector<TickGroup>& groups, const TickContacts& found, const ClusterNodes& nodes,
                  Clusters& clusters) {
  for (std::uint32_t g = 0; g < groups.size(); ++g) {
    TickGroup& group = groups[g];
    group.clustered = clusters.cluster[root(clusters, g)] != kNoPartner;
    if (!group.clustered) continue;
    Cluster& cluster = clusterOf(clusters, g);
    clusters.first[g] = static_cast<std::uint32_t>(cluster.step.bodies.size());
    const auto firstRigid = static_cast<std::uint32_t>(cluster.step.links.rigids.size());
    for (std::uint32_t i = 0; i < group.rigids.size(); ++i)
      if (const std::uint32_t number = found.find(*group.rigids[i].body);
          number != kNoPartner && !group.rigids[i].held)
        clusters.first[nodes.ofRigid(number)] = firstRigid + i;
    append(cluster, group);
  }
}

void appendRigids(TickContacts& found, const ClusterNodes& nodes, btScalar tick, Clusters& clusters) {
  for (std::uint32_t number = 0; number < found.rigids.size(); ++number) {
    const std::uint32_t node = nodes.ofRigid(number);
    if (clusters.first[node] != kNoPartner || clusters.cluster[root(clusters, node)] == kNoPartner) continue;
    Cluster& cluster = clusterOf(clusters, node);
    clusters.first[node] = static_cast<std::uint32_t>(cluster.step.links.rigids.size());
    cluster.rigids.push_back(number);
    cluster.step.links.rigids.emplace_back();
    gatherRigid(found.rigids[number], cluster.step.links.rigids.back(), tick);
  }
}

/// Contacts name bodies by their number in the system; rows of a cluster by their place in it.
void renumber(ContactPlace& place, const ClusterNodes& nodes, const Clusters& clusters) {
  if (place.kind == ContactPlace::Kind::World) return;
  const bool soft = place.kind == ContactPlace::Kind::Soft;
  place.body = clusters.first[nodes.of(place)] + (soft ? clusters.placeInGroup[place.body] : 0);
}

void appendContacts(const TickContacts& found, const ClusterNodes& nodes, Clusters& clusters) {
  for (std::uint32_t i = 0; i < found.contacts.size(); ++i) {
    Cluster& cluster = clusterOf(clusters, nodes.of(found.contacts[i]));
    cluster.contacts.push_back(i);
    cluster.step.pairs.contacts.push_back(found.contacts[i]);
    PairContact& c = cluster.step.pairs.contacts.back();
    renumber(c.a, nodes, clusters);
    renumber(c.b, nodes, clusters);
  }
  for (std::uint32_t i = 0; i < found.joints.size(); ++i) {
    Cluster& cluster = clusterOf(clusters, nodes.of(found.joints[i]));
    cluster.joints.push_back(i);
    cluster.step.pairs.joints.push_back(found.joints[i]);
    JointRow& j = cluster.step.pairs.joints.back();
    for (std::uint32_t* side : {&j.a, &j.b})
      if (*side != JointRow::kHeld) *side = clusters.first[nodes.ofRigid(*side)];
    if (j.contact == JointRow::kHeld) continue;
    const auto place = std::lower_bound(cluster.contacts.begin(), cluster.contacts.end(), j.contact);
    j.contact = static_cast<std::uint32_t>(place - cluster.contacts.begin());
  }
}

/// What holds an anchored point must be solved with what it touches.
bool hasAnchorsAndRows(const TickGroup& group) {
  const auto touches = [](const SoftBodyData* body) { return !body->contacts.empty(); };
  return !group.asleep && !group.step.links.anchors.empty() &&
         std::any_of(group.bodies.begin(), group.bodies.end(), touches);
}

void appendMeetings(const TickContacts& found, const ClusterNodes& nodes, Clusters& clusters) {
  const auto placeOf = [&](const SoftBodyData& body) {
    return clusters.first[nodes.groupOf[body.index]] + clusters.placeInGroup[body.index];
  };
  for (const SurfaceMeeting& m : found.meetings) {
    ClusterMeeting meeting{&m, placeOf(*m.body)};
    meeting.way = wayOf(m);
    if (m.other)
      meeting.b = placeOf(*m.other);
    else if (!m.held)
      meeting.b = clusters.first[nodes.ofRigid(found.find(*m.partner))];
    clusterOf(clusters, nodes.groupOf[m.body->index]).meetings.push_back(meeting);
  }
}

void numberBodies(const std::vector<TickGroup>& groups, Clusters& clusters) {
  for (std::uint32_t g = 0; g < groups.size(); ++g)
    for (std::uint32_t i = 0; i < groups[g].bodies.size(); ++i) {
      const std::size_t body = groups[g].bodies[i]->index;
      if (body >= clusters.groupOf.size()) {
        clusters.groupOf.resize(body + 1);
        clusters.placeInGroup.resize(body + 1);
      }
      clusters.groupOf[body] = g;
      clusters.placeInGroup[body] = i;
    }
}

// --- contacts of points with what is held ------------------------------------------------------------------

/// Points that something else than what is held touches, or may touch within the tick: solved apart from it their rows
/// would give way.
void markCoupledPoints(Cluster& cluster) {
  for (SoftBodyData* body : cluster.softBodies) body->coupled.assign(body->masses.bodies.size(), 0);
  for (const ClusterMeeting& m : cluster.meetings)
    for (SoftBodyData* body : {m.surfaces->body, m.surfaces->other})
      if (m.moves() && !m.surfaces->held && body) body->coupled.assign(body->coupled.size(), 1);
  for (const PairContact& c : cluster.step.pairs.contacts)
    for (const ContactPlace* place : {&c.a, &c.b})
      if (place->kind == ContactPlace::Kind::Soft)
        for (std::uint32_t i = 0; i < place->count; ++i)
          cluster.softBodies[place->body]->coupled[place->point[i]] = 1;
  for (const LinkAnchor& anchor : cluster.step.links.anchors)
    cluster.softBodies[anchor.point.body]->coupled[anchor.point.point] = 1;
}

PairContact pairOf(const ContactRow& row, const SoftBodyData& body, std::uint32_t place) {
  PairContact c;
  c.a.kind = ContactPlace::Kind::Soft;
  c.a.body = place;
  c.a.point[0] = row.point;
  c.b.velocity = row.surfaceVelocity;
  c.normal = row.normal;
  c.gap = row.normal.dot(body.state.position.col(row.point) - row.touch);
  c.held = row.around ? &row : nullptr;
  c.friction = row.friction;
  c.restitution = row.restitution;
  c.bounceThreshold = row.bounceThreshold;
  c.recoverySpeed = row.recoverySpeed;
  return c;
}

/// Moves the contacts with static and kinematic surfaces of those points that something free touches or holds,
/// from their bodies' rows to the cluster's pairs: what is squeezed between the two must be solved with both.
void appendRows(Cluster& cluster) {
  markCoupledPoints(cluster);
  for (std::uint32_t place = 0; place < cluster.softBodies.size(); ++place) {
    SoftBodyData& body = *cluster.softBodies[place];
    for (ContactRow& row : body.contacts) {
      row.coupled = body.coupled[row.point] != 0;
      if (!row.coupled) continue;
      cluster.rows.push_back(&row);
      cluster.step.pairs.contacts.push_back(pairOf(row, body, place));
    }
  }
}

}  // namespace

void addLinkedRigids(const std::vector<TickGroup>& groups, TickContacts& found) {
  for (const TickGroup& group : groups)
    for (const RigidPartner& rigid : group.rigids)
      if (!group.asleep && isFree(*rigid.body)) found.add(*rigid.body);
}

void makeClusters(std::vector<TickGroup>& groups, TickContacts& found, btScalar tick, Clusters& clusters) {
  clusters.count = 0;
  bool anchored = false;
  for (TickGroup& group : groups) {
    group.clustered = false;
    anchored = anchored || hasAnchorsAndRows(group);
  }
  if (found.contacts.empty() && found.joints.empty() && found.meetings.empty() && !anchored) return;
  numberBodies(groups, clusters);
  const ClusterNodes nodes{static_cast<std::uint32_t>(groups.size()), clusters.groupOf};
  joinNodes(groups, found, nodes, clusters);
  clusters.cluster.assign(clusters.parent.size(), kNoPartner);
  clusters.first.assign(clusters.parent.size(), kNoPartner);
  for (const PairContact& c : found.contacts) clusterOf(clusters, nodes.of(c));
  for (const JointRow& j : found.joints) clusterOf(clusters, nodes.of(j));
  for (const SurfaceMeeting& m : found.meetings) clusterOf(clusters, nodes.of(*m.body));
  for (std::uint32_t g = 0; g < groups.size(); ++g)
    if (hasAnchorsAndRows(groups[g])) clusterOf(clusters, g);
  appendGroups(groups, found, nodes, clusters);
  appendRigids(found, nodes, tick, clusters);
  appendContacts(found, nodes, clusters);
  appendMeetings(found, nodes, clusters);
  for (Cluster& cluster : clusters) appendRows(cluster);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

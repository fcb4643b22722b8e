// SPDX-License-Identifier: Zlib
#include "bullet/tick_group.h"

#include "bullet/body_in_world.h"
#include "bullet/bullet_objects.h"
#include "bullet/contact_gather.h"
#include "bullet/kinematic_motion.h"
#include "bullet/surface_body.h"

#include <algorithm>
#include <map>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

bool isWhole(const TickGroup& group) {
  for (SoftBodyData* body : group.bodies) {
    body->alive = body->alive && wholeInWorld(*body);
    if (!body->alive) return false;
  }
  return true;
}

void gatherBodies(TickGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies) {
    gatherBody(*body, tick);
    if (isSurfaceBody(*body)) showFlight(*body, tick);
  }
}

void gatherGroup(TickGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies) gatherContacts(*body, tick);
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    gatherRigid(group.rigids[i], group.step.links.rigids[i], tick);
}

void handOverGroup(TickGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies) handOverBody(*body, tick);
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    handOverRigid(group.rigids[i], group.step.links.rigids[i], tick);
}

void takeBackGroup(TickGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies) {
    if (!body->alive) continue;
    finishBody(*body, tick);
  }
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    takeBackRigid(group.rigids[i], group.step.links.rigids[i], tick);
}

namespace {

/// Everything a link can join, numbered: soft bodies first, then rigid bodies in order of first mention.
class GroupNodes {
 public:
  explicit GroupNodes(const std::vector<SoftBodyData*>& bodies) {
    for (std::size_t i = 0; i < bodies.size(); ++i) softIndex_[bodies[i]] = add();
  }

  std::size_t soft(const SoftBodyData* body) const { return softIndex_.at(body); }

  std::size_t rigid(btRigidBody* body) {
    const auto [it, isNew] = rigidIndex_.try_emplace(body, parent_.size());
    if (isNew) add();
    return it->second;
  }

  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  /// The lower number becomes the root, so that groups come in the order of their first member.
  void join(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::size_t add() {
    parent_.push_back(parent_.size());
    return parent_.size() - 1;
  }

  std::vector<std::size_t> parent_;
  std::map<const SoftBodyData*, std::size_t> softIndex_;
  std::map<const btRigidBody*, std::size_t> rigidIndex_;
};

constexpr std::size_t kNoNode = static_cast<std::size_t>(-1);

/// The node of a spring's end. Static bodies and the world join nothing to each other.
std::size_t nodeOf(const SpringEnd& end, GroupNodes& nodes) {
  if (!end.body) return kNoNode;
  if (const PointMass* point = PointMass::from(end.body)) return nodes.soft(point->owner());
  return isStatic(*end.body) ? kNoNode : nodes.rigid(end.body);
}

std::uint32_t indexOfBody(TickGroup& group, SoftBodyData* body) {
  const auto it = std::find(group.bodies.begin(), group.bodies.end(), body);
  return static_cast<std::uint32_t>(it - group.bodies.begin());
}

std::uint32_t indexOfRigid(TickGroup& group, btRigidBody* body) {
  const auto same = [&](const RigidPartner& partner) { return partner.body == body; };
  const auto it = std::find_if(group.rigids.begin(), group.rigids.end(), same);
  const auto index = static_cast<std::uint32_t>(it - group.rigids.begin());
  if (it == group.rigids.end()) {
    group.rigids.push_back(makePartner(*body));
    group.step.links.rigids.emplace_back();
  }
  return index;
}

LinkEnd pointEnd(TickGroup& group, SoftBodyData* body, std::uint32_t point) {
  LinkEnd end;
  end.kind = LinkEnd::Kind::Point;
  end.body = indexOfBody(group, body);
  end.point = point;
  return end;
}

LinkEnd rigidEnd(TickGroup& group, btRigidBody* body, const btVector3& pivot) {
  LinkEnd end;
  end.kind = LinkEnd::Kind::Rigid;
  end.body = indexOfRigid(group, body);
  end.pivot = toEigen(pivot);
  return end;
}

LinkEnd linkEnd(TickGroup& group, const SpringEnd& end) {
  if (!end.body) {
    LinkEnd world;
    world.pivot = toEigen(end.pivot);
    return world;
  }
  if (const PointMass* point = PointMass::from(end.body))
    return pointEnd(group, point->owner(), point->index());
  return rigidEnd(group, end.body, end.pivot);
}

void addBody(TickGroup& group, SoftBodyData* body) {
  group.bodies.push_back(body);
  group.step.bodies.push_back({&body->state, &body->springs, &body->contacts});
  if (!body->volumes.empty()) group.step.bodies.back().volumes = &body->volumes;
  if (!body->tetrahedra.empty()) group.step.bodies.back().tetrahedra = &body->tetrahedra;
  group.step.bodies.back().watch = body->watch.get();
  if (canStepQuads()) group.step.bodies.back().quads = &body->quads;
  group.step.links.points.push_back(&body->state);
}

void addSpring(TickGroup& group, SpringConstraint* spring) {
  const SpringSettings& s = spring->settings();
  LinkSpring link;
  link.a = linkEnd(group, spring->endA());
  link.b = linkEnd(group, spring->endB());
  link.restLength = s.restLength;
  link.extensionStiffness = s.action == SpringAction::CompressionOnly ? 0.0 : s.stiffness;
  link.compressionStiffness = s.action == SpringAction::ExtensionOnly ? 0.0 : s.stiffness;
  link.damping = s.damping;
  group.step.links.springs.push_back(link);
  group.springs.push_back(spring);
}

bool usable(const SpringEnd& end) {
  if (!end.body) return true;
  const PointMass* point = PointMass::from(end.body);
  return point ? point->owner() && point->owner()->alive : end.body->isInWorld();
}

bool usable(const Anchor& anchor) { return anchor.body->isInWorld(); }

bool usable(const SpringConstraint& spring) { return usable(spring.endA()) && usable(spring.endB()); }

/// 0 if the link is not usable, else 1 and a bit for each end that joins nothing.
unsigned char stateOf(const Anchor& anchor) {
  return usable(anchor) ? static_cast<unsigned char>(1 + 2 * isStatic(*anchor.body)) : 0;
}

unsigned char stateOf(const SpringConstraint& spring) {
  const auto joinsNothing = [](const SpringEnd& end) { return end.body && isStatic(*end.body); };
  if (!usable(spring)) return 0;
  return static_cast<unsigned char>(1 + 2 * joinsNothing(spring.endA()) + 4 * joinsNothing(spring.endB()));
}

void takeOverSleep(TickGroup& group) {
  group.asleep = !group.bodies.empty();
  group.calmTime = group.bodies.empty() ? 0.0 : group.bodies.front()->calmTime;
  for (const SoftBodyData* body : group.bodies) {
    group.asleep = group.asleep && body->asleep;
    group.calmTime = std::min(group.calmTime, body->calmTime);
  }
}

}  // namespace

bool updateUsableLinks(const std::vector<SoftBodyData*>& bodies, const std::vector<SpringConstraint*>& springs,
                       std::vector<unsigned char>& links) {
  std::size_t count = 0;
  bool changed = false;
  const auto update = [&](unsigned char state) {
    if (count == links.size()) links.push_back(static_cast<unsigned char>(~state));
    changed = changed || links[count] != state;
    links[count++] = state;
  };
  for (const SpringConstraint* spring : springs) update(stateOf(*spring));
  for (const SoftBodyData* body : bodies)
    for (const Anchor& anchor : body->anchors) update(stateOf(anchor));
  changed = changed || links.size() != count;
  links.resize(count);
  return changed;
}

std::vector<TickGroup> makeGroups(const std::vector<SoftBodyData*>& bodies,
                                  const std::vector<SpringConstraint*>& springs) {
  GroupNodes nodes(bodies);
  std::vector<std::size_t> springNode(springs.size(), kNoNode);
  for (std::size_t i = 0; i < springs.size(); ++i) {
    if (!usable(*springs[i])) continue;
    const std::size_t a = nodeOf(springs[i]->endA(), nodes), b = nodeOf(springs[i]->endB(), nodes);
    if (a != kNoNode && b != kNoNode) nodes.join(a, b);
    springNode[i] = a != kNoNode ? a : b;
  }
  for (SoftBodyData* body : bodies)
    for (const Anchor& anchor : body->anchors)
      if (usable(anchor) && !isStatic(*anchor.body))
        nodes.join(nodes.soft(body), nodes.rigid(anchor.body));

  std::map<std::size_t, TickGroup> groups;
  for (SoftBodyData* body : bodies) addBody(groups[nodes.root(nodes.soft(body))], body);
  for (std::size_t i = 0; i < springs.size(); ++i)
    if (springNode[i] != kNoNode) addSpring(groups[nodes.root(springNode[i])], springs[i]);
  for (SoftBodyData* body : bodies) {
    TickGroup& group = groups[nodes.root(nodes.soft(body))];
    for (const Anchor& anchor : body->anchors)
      if (usable(anchor))
        group.step.links.anchors.push_back(
            {pointEnd(group, body, anchor.point), rigidEnd(group, anchor.body, anchor.pivot)});
  }

  std::vector<TickGroup> ordered;
  for (auto& [root, group] : groups) {
    takeOverSleep(group);
    ordered.push_back(std::move(group));
  }
  return ordered;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

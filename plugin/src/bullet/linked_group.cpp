// SPDX-License-Identifier: Zlib

// This file makes groups and runs the stages of their ticks.

#include "bullet/linked_group.h"

#include "bullet/body_in_world.h"
#include "bullet/bullet_objects.h"
#include "bullet/point_contacts.h"
#include "bullet/surface_body.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// The bodies that links can join, numbered: soft bodies by SoftBodyData::index, then rigid bodies in the
/// order of first use. Groups are in the order of their first members.
struct LinkedNodes {
  DisjointSets sets;
  std::map<const btRigidBody*, std::uint32_t> ofRigid;

  std::uint32_t rigid(btRigidBody* body) {
    const auto [it, isNew] = ofRigid.try_emplace(body, 0);
    if (isNew) it->second = sets.add();
    return it->second;
  }
};

constexpr std::uint32_t kNoNode = static_cast<std::uint32_t>(-1);

/// Returns the node of a spring's end, or kNoNode for the world and for static bodies: they join nothing.
std::uint32_t nodeOf(const SpringEnd& end, LinkedNodes& nodes) {
  if (!end.body) return kNoNode;
  if (const PointMass* point = PointMass::from(end.body)) return point->owner()->index;
  return isStatic(*end.body) ? kNoNode : nodes.rigid(end.body);
}

std::uint32_t indexOfBody(LinkedGroup& group, SoftBodyData* body) {
  const auto it = std::find(group.bodies.begin(), group.bodies.end(), body);
  return static_cast<std::uint32_t>(it - group.bodies.begin());
}

std::uint32_t indexOfRigid(LinkedGroup& group, btRigidBody* body) {
  const auto same = [&](const RigidPartner& partner) { return partner.body == body; };
  const auto it = std::find_if(group.rigids.begin(), group.rigids.end(), same);
  const auto index = static_cast<std::uint32_t>(it - group.rigids.begin());
  if (it == group.rigids.end()) {
    group.rigids.push_back(makePartner(*body));
    group.step.links.rigids.emplace_back();
  }
  return index;
}

LinkEnd pointEnd(LinkedGroup& group, SoftBodyData* body, std::uint32_t point) {
  LinkEnd end;
  end.kind = LinkEnd::Kind::Point;
  end.body = indexOfBody(group, body);
  end.point = point;
  return end;
}

LinkEnd rigidEnd(LinkedGroup& group, btRigidBody* body, const btVector3& pivot) {
  LinkEnd end;
  end.kind = LinkEnd::Kind::Rigid;
  end.body = indexOfRigid(group, body);
  end.pivot = toEigen(pivot);
  return end;
}

LinkEnd linkEnd(LinkedGroup& group, const SpringEnd& end) {
  if (!end.body) {
    LinkEnd world;
    world.pivot = toEigen(end.pivot);
    return world;
  }
  if (const PointMass* point = PointMass::from(end.body))
    return pointEnd(group, point->owner(), point->index());
  return rigidEnd(group, end.body, end.pivot);
}

void addBody(LinkedGroup& group, SoftBodyData* body) {
  group.bodies.push_back(body);
  group.step.bodies.push_back({&body->state, &body->springs, &body->contacts});
  if (!body->volumes.empty()) group.step.bodies.back().volumes = &body->volumes;
  if (!body->tetrahedra.empty()) group.step.bodies.back().tetrahedra = &body->tetrahedra;
  group.step.bodies.back().watch = body->watch.get();
  group.step.bodies.back().rest = &body->model->rest;
  if (isSurfaceBody(*body))
    group.step.bodies.back().sums = &body->sums;
  else
    group.hasWorldPoints = true;
  group.step.links.points.push_back(&body->state);
}

void addSpring(LinkedGroup& group, SpringConstraint* spring) {
  const SpringSettings& s = spring->settings();
  LinkSpring link;
  link.a = linkEnd(group, spring->endA());
  link.b = linkEnd(group, spring->endB());
  link.restLength = *s.restLength;
  setStiffness(link, *spring, 1.0);
  link.damping = s.damping;
  group.step.links.springs.push_back(link);
  group.springs.push_back(spring);
}

bool usable(const btRigidBody& held, const btCollisionWorld& world) {
  return held.isInWorld() && !isElsewhere(held, world);
}

bool usable(const SpringEnd& end, const btCollisionWorld& world) {
  if (!end.body) return true;
  const PointMass* point = PointMass::from(end.body);
  return point ? point->owner() && point->owner()->alive : usable(*end.body, world);
}

bool usable(const SpringConstraint& spring, const btCollisionWorld& world) {
  return !spring.broken() && usable(spring.endA(), world) && usable(spring.endB(), world);
}

/// Returns 0 if the link is not usable, otherwise 1 plus a bit for each end that is static.
unsigned char stateOf(const Anchor& anchor, const btCollisionWorld& world) {
  return usable(*anchor.body, world) ? static_cast<unsigned char>(1 + 2 * isStatic(*anchor.body)) : 0;
}

unsigned char stateOf(const SpringConstraint& spring, const btCollisionWorld& world) {
  const auto joinsNothing = [](const SpringEnd& end) { return end.body && isStatic(*end.body); };
  if (!usable(spring, world)) return 0;
  return static_cast<unsigned char>(1 + 2 * joinsNothing(spring.endA()) + 4 * joinsNothing(spring.endB()));
}

void takeOverSleep(LinkedGroup& group) {
  group.asleep = !group.bodies.empty();
  group.calmTime = group.bodies.empty() ? 0.0 : group.bodies.front()->calmTime;
  for (const SoftBodyData* body : group.bodies) {
    group.asleep = group.asleep && body->asleep;
    group.calmTime = std::min(group.calmTime, body->calmTime);
  }
}

}  // namespace

void setStiffness(LinkSpring& link, const SpringConstraint& spring, double share) {
  const SpringSettings& s = spring.settings();
  link.extensionStiffness = s.action == SpringAction::CompressionOnly ? 0.0 : share * s.stiffness;
  link.compressionStiffness = s.action == SpringAction::ExtensionOnly ? 0.0 : share * s.stiffness;
}

bool updateUsableLinks(const btCollisionWorld& world, const std::vector<SoftBodyData*>& bodies,
                       const std::vector<SpringConstraint*>& springs, std::vector<unsigned char>& links) {
  std::size_t count = 0;
  bool changed = false;
  const auto update = [&](unsigned char state) {
    if (count == links.size()) links.push_back(static_cast<unsigned char>(~state));
    changed = changed || links[count] != state;
    links[count++] = state;
  };
  for (const SpringConstraint* spring : springs) update(stateOf(*spring, world));
  for (const SoftBodyData* body : bodies)
    for (const Anchor& anchor : body->anchors) update(stateOf(anchor, world));
  changed = changed || links.size() != count;
  links.resize(count);
  return changed;
}

std::vector<LinkedGroup> makeLinkedGroups(const btCollisionWorld& world,
                                          const std::vector<SoftBodyData*>& bodies,
                                          const std::vector<SpringConstraint*>& springs) {
  LinkedNodes nodes{DisjointSets(bodies.size()), {}};
  std::vector<std::uint32_t> springNode(springs.size(), kNoNode);
  for (std::size_t i = 0; i < springs.size(); ++i) {
    if (!usable(*springs[i], world)) continue;
    const std::uint32_t a = nodeOf(springs[i]->endA(), nodes), b = nodeOf(springs[i]->endB(), nodes);
    if (a != kNoNode && b != kNoNode) nodes.sets.join(a, b);
    springNode[i] = a != kNoNode ? a : b;
  }
  for (SoftBodyData* body : bodies)
    for (const Anchor& anchor : body->anchors)
      if (usable(*anchor.body, world) && !isStatic(*anchor.body))
        nodes.sets.join(body->index, nodes.rigid(anchor.body));

  std::map<std::uint32_t, LinkedGroup> groups;
  for (SoftBodyData* body : bodies) addBody(groups[nodes.sets.root(body->index)], body);
  for (std::size_t i = 0; i < springs.size(); ++i)
    if (springNode[i] != kNoNode) addSpring(groups[nodes.sets.root(springNode[i])], springs[i]);
  for (SoftBodyData* body : bodies) {
    LinkedGroup& group = groups[nodes.sets.root(body->index)];
    for (Anchor& anchor : body->anchors)
      if (usable(*anchor.body, world))
        group.step.links.anchors.push_back(
            {pointEnd(group, body, anchor.point), rigidEnd(group, anchor.body, anchor.pivot)});
      else
        anchor.force = btVector3(0, 0, 0);
  }

  std::vector<LinkedGroup> ordered;
  std::map<const BodyModel*, std::size_t> models;
  for (auto& [root, group] : groups) {
    takeOverSleep(group);
    if (!group.bodies.empty())
      group.model = models.try_emplace(group.bodies[0]->model.get(), models.size()).first->second;
    ordered.push_back(std::move(group));
  }
  return ordered;
}

void useSpringBatches(LinkedGroup& group) {
  if (!canStepSpringBatches()) return;
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    std::unique_ptr<SpringBatchArrays>& batches = group.bodies[i]->springBatches;
    if (!batches) batches = std::make_unique<SpringBatchArrays>();
    group.step.bodies[i].springBatches = batches.get();
  }
}

// --- the stages of a tick ----------------------------------------------------------------------------------

bool isWhole(const LinkedGroup& group) {
  for (SoftBodyData* body : group.bodies) {
    body->alive = body->alive && isAlive(*body);
    if (!body->alive) return false;
  }
  return true;
}

void gatherBodies(LinkedGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies) gatherBody(*body, tick);
}

void surroundBodies(LinkedGroup& group, btScalar tick) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i)
    group.step.bodies[i].drag = surroundBody(*group.bodies[i], double(tick));
}

bool updateBroadphaseBoxes(LinkedGroup& group, btScalar tick) {
  bool changed = false;
  for (SoftBodyData* body : group.bodies)
    if (isSurfaceBody(*body)) changed = updateBroadphaseBox(*body, tick) || changed;
  return changed;
}

void placeEnds(LinkSpring& link, const SpringConstraint& spring, double tick) {
  const auto gather = [&](LinkEnd& end, const SpringEnd& now) {
    if (end.kind != LinkEnd::Kind::World) return;
    end.pivot = toEigen(now.pivot);
    end.velocity = (toEigen(spring.target().value_or(now.pivot)) - end.pivot) / tick;
  };
  gather(link.a, spring.endA());
  gather(link.b, spring.endB());
}

/// Squared errors (m^2) of the links of points with a held body, at two of its poses.
struct LinkErrors {
  double atPlace = 0.0, atLastPose = 0.0;

  void add(const Eigen::Vector3d& point, const Eigen::Vector3d& place, const Eigen::Vector3d& last,
           double length) {
    atPlace += std::pow((point - place).norm() - length, 2);
    atLastPose += std::pow((point - last).norm() - length, 2);
  }
};

/// Returns whether the links of points with a held body fit where it was placed much better than where it
/// was: the user has placed both together. Otherwise the body pulls its points over within the tick.
bool isPlacedWithItsPoints(const LinkedGroup& group, std::uint32_t rigid) {
  const RigidPartner& partner = group.rigids[rigid];
  if (!partner.held) return false;
  const btTransform& place = partner.body->getWorldTransform();
  LinkErrors errors;
  const auto add = [&](const LinkEnd& point, const LinkEnd& pivot, double length) {
    if (point.kind != LinkEnd::Kind::Point || pivot.kind != LinkEnd::Kind::Rigid || pivot.body != rigid)
      return;
    errors.add(group.bodies[point.body]->state.position.col(point.point),
               toEigen(place(toBullet(pivot.pivot))),
               partner.start.position + partner.start.rotation * pivot.pivot, length);
  };
  for (const LinkAnchor& anchor : group.step.links.anchors) add(anchor.point, anchor.pivot, 0.0);
  for (const LinkSpring& spring : group.step.links.springs) {
    add(spring.a, spring.b, spring.restLength);
    add(spring.b, spring.a, spring.restLength);
  }
  return 4.0 * errors.atPlace < errors.atLastPose;
}

void gatherSpring(LinkSpring& link, const SpringConstraint& spring, double tick) {
  placeEnds(link, spring, tick);
  // a Grab changes them
  setStiffness(link, spring, 1.0);
  link.damping = spring.settings().damping;
}

void gatherGroup(LinkedGroup& group, btScalar tick) {
  for (std::size_t i = 0; i < group.springs.size(); ++i)
    gatherSpring(group.step.links.springs[i], *group.springs[i], double(tick));
  for (SoftBodyData* body : group.bodies) gatherContacts(*body, tick);
  for (std::uint32_t i = 0; i < group.rigids.size(); ++i) {
    gatherRigid(group.rigids[i], group.step.links.rigids[i], tick);
    if (isPlacedWithItsPoints(group, i)) startFromPlace(group.rigids[i], group.step.links.rigids[i], tick);
  }
}

void writeGroupToBullet(LinkedGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies) writeBodyToBullet(*body, tick);
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    writeRigidToBullet(group.rigids[i], group.step.links.rigids[i], tick);
}

void readGroupFromBullet(LinkedGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies) {
    if (!body->alive) continue;
    finishBody(*body, tick);
  }
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    readRigidFromBullet(group.rigids[i], group.step.links.rigids[i], tick);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

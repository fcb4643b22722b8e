// SPDX-License-Identifier: Zlib

// This file makes groups, runs the stages of their ticks, puts them to sleep and wakes them.

#include "bullet/linked_group.h"

#include "bullet/body_in_world.h"
#include "bullet/bullet_objects.h"
#include "bullet/point_contacts.h"
#include "bullet/surface_body.h"

#include <algorithm>
#include <map>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// The bodies that links can join, numbered: soft bodies, then rigid bodies in the order of first use.
class LinkedNodes {
 public:
  explicit LinkedNodes(const std::vector<SoftBodyData*>& bodies) {
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

  /// Joins two sets. The lower number becomes the root: groups are in the order of their first members.
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

/// Returns the node of a spring's end, or kNoNode for the world and for static bodies: they join nothing.
std::size_t nodeOf(const SpringEnd& end, LinkedNodes& nodes) {
  if (!end.body) return kNoNode;
  if (const PointMass* point = PointMass::from(end.body)) return nodes.soft(point->owner());
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

bool usable(const SpringEnd& end) {
  if (!end.body) return true;
  const PointMass* point = PointMass::from(end.body);
  return point ? point->owner() && point->owner()->alive : end.body->isInWorld();
}

bool usable(const Anchor& anchor) { return anchor.body->isInWorld(); }

bool usable(const SpringConstraint& spring) {
  return !spring.broken() && usable(spring.endA()) && usable(spring.endB());
}

/// Returns 0 if the link is not usable, otherwise 1 plus a bit for each end that is static.
unsigned char stateOf(const Anchor& anchor) {
  return usable(anchor) ? static_cast<unsigned char>(1 + 2 * isStatic(*anchor.body)) : 0;
}

unsigned char stateOf(const SpringConstraint& spring) {
  const auto joinsNothing = [](const SpringEnd& end) { return end.body && isStatic(*end.body); };
  if (!usable(spring)) return 0;
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

bool updateUsableLinks(const std::vector<SoftBodyData*>& bodies,
                       const std::vector<SpringConstraint*>& springs, std::vector<unsigned char>& links) {
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

std::vector<LinkedGroup> makeLinkedGroups(const std::vector<SoftBodyData*>& bodies,
                                          const std::vector<SpringConstraint*>& springs) {
  LinkedNodes nodes(bodies);
  std::vector<std::size_t> springNode(springs.size(), kNoNode);
  for (std::size_t i = 0; i < springs.size(); ++i) {
    if (!usable(*springs[i])) continue;
    const std::size_t a = nodeOf(springs[i]->endA(), nodes), b = nodeOf(springs[i]->endB(), nodes);
    if (a != kNoNode && b != kNoNode) nodes.join(a, b);
    springNode[i] = a != kNoNode ? a : b;
  }
  for (SoftBodyData* body : bodies)
    for (const Anchor& anchor : body->anchors)
      if (usable(anchor) && !isStatic(*anchor.body)) nodes.join(nodes.soft(body), nodes.rigid(anchor.body));

  std::map<std::size_t, LinkedGroup> groups;
  for (SoftBodyData* body : bodies) addBody(groups[nodes.root(nodes.soft(body))], body);
  for (std::size_t i = 0; i < springs.size(); ++i)
    if (springNode[i] != kNoNode) addSpring(groups[nodes.root(springNode[i])], springs[i]);
  for (SoftBodyData* body : bodies) {
    LinkedGroup& group = groups[nodes.root(nodes.soft(body))];
    for (const Anchor& anchor : body->anchors)
      if (usable(anchor))
        group.step.links.anchors.push_back(
            {pointEnd(group, body, anchor.point), rigidEnd(group, anchor.body, anchor.pivot)});
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
    body->alive = body->alive && wholeInWorld(*body);
    if (!body->alive) return false;
  }
  return true;
}

void gatherBodies(LinkedGroup& group, btScalar tick) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    gatherBody(*group.bodies[i], tick);
    group.step.bodies[i].drag = surroundBody(*group.bodies[i], double(tick));
  }
}

bool updateBroadphaseBoxes(LinkedGroup& group, btScalar tick) {
  bool changed = false;
  for (SoftBodyData* body : group.bodies)
    if (isSurfaceBody(*body)) changed = updateBroadphaseBox(*body, tick) || changed;
  return changed;
}

/// Moves the end in the world to where the user has moved it, at once or, with a target, over the tick.
void gatherEnds(LinkSpring& link, const SpringConstraint& spring, double tick) {
  const auto gather = [&](LinkEnd& end, const SpringEnd& now) {
    if (end.kind != LinkEnd::Kind::World) return;
    end.pivot = toEigen(now.pivot);
    end.velocity = (toEigen(spring.target().value_or(now.pivot)) - end.pivot) / tick;
  };
  gather(link.a, spring.endA());
  gather(link.b, spring.endB());
}

void gatherGroup(LinkedGroup& group, btScalar tick) {
  for (std::size_t i = 0; i < group.springs.size(); ++i)
    gatherEnds(group.step.links.springs[i], *group.springs[i], double(tick));
  for (SoftBodyData* body : group.bodies) gatherContacts(*body, tick);
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    gatherRigid(group.rigids[i], group.step.links.rigids[i], tick);
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

// --- sleep -------------------------------------------------------------------------------------------------

namespace {

/// Calls visit(body) for all Bullet bodies of the group that can sleep.
template <class Visit>
void forEachMember(LinkedGroup& group, Visit visit) {
  for (SoftBodyData* body : group.bodies) {
    if (body->surface.object) visit(*body->surface.object);
    if (!body->masses.exposed) continue;
    for (PointMass* point : body->masses.bodies)
      if (point) visit(*point);
  }
  for (RigidPartner& partner : group.rigids)
    if (!partner.body->isStaticOrKinematicObject()) visit(*partner.body);
}

template <class Test>
bool anyMember(LinkedGroup& group, Test test) {
  bool found = false;
  forEachMember(group, [&](btRigidBody& body) { found = found || test(body); });
  return found;
}

bool isFast(const btRigidBody& body) {
  const btScalar linear = body.getLinearSleepingThreshold(), angular = body.getAngularSleepingThreshold();
  return body.getLinearVelocity().length2() > linear * linear ||
         body.getAngularVelocity().length2() > angular * angular;
}

bool movesTooFast(LinkedGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies)
    if (movesTooFast(*body, tick)) return true;
  for (const RigidPartner& partner : group.rigids)
    if (!isStatic(*partner.body) && isFast(*partner.body)) return true;
  return anyMember(group,
                   [](btRigidBody& body) { return body.getActivationState() == DISABLE_DEACTIVATION; });
}

bool isChanged(const LinkedGroup& group) {
  return std::any_of(group.bodies.begin(), group.bodies.end(), [](const SoftBodyData* body) {
    return isSurfaceBody(*body) && isSurfaceChanged(*body);
  });
}

void wakeGroup(LinkedGroup& group) {
  for (SoftBodyData* body : group.bodies) wakeBody(*body, true);
  for (RigidPartner& partner : group.rigids) {
    btRigidBody& rigid = *partner.body;
    if (rigid.isActive() || rigid.isStaticOrKinematicObject()) continue;
    rigid.activate(true);
    rigid.applyGravity();
  }
  group.asleep = false;
  group.calmTime = 0.0;
}

/// Puts the group to sleep. Sets all velocities to zero, because they have been small for seconds.
void sleepGroup(LinkedGroup& group) {
  for (SoftBodyData* body : group.bodies) {
    body->state.velocity.setZero();
    body->sumsValid = false;
    body->storedImpulses.clear();
    body->report.fresh = false;
    dropObjectForces(*body);
    body->asleep = true;
    body->substeps = 0;
    body->surface.partners.clear();
    body->surface.left.velocity = body->surface.left.spin = btVector3(0, 0, 0);
    std::fill(body->masses.leftVelocity.begin(), body->masses.leftVelocity.end(), btVector3(0, 0, 0));
  }
  forEachMember(group, [](btRigidBody& body) {
    body.setLinearVelocity(btVector3(0, 0, 0));
    body.setAngularVelocity(btVector3(0, 0, 0));
    body.setInterpolationLinearVelocity(btVector3(0, 0, 0));
    body.setActivationState(ISLAND_SLEEPING);
  });
  group.asleep = true;
}

bool sleepIsOff() { return gDisableDeactivation || gDeactivationTime == btScalar(0); }

/// Returns the calm time (s) that a tick adds. One very long tick does not put a body to sleep: it may have
/// been released at its start.
double calmTimeOf(btScalar tick) { return std::min(double(tick), 0.5 * double(gDeactivationTime)); }

/// Woken from outside (a contact, the user), or kept awake; otherwise its calm time goes on.
void updateCalmTime(LinkedGroup& group, btScalar tick) {
  // wake() resets the calm time of a body that is awake
  for (const SoftBodyData* body : group.bodies) group.calmTime = std::min(group.calmTime, body->calmTime);
  if (group.asleep && !anyMember(group, [](btRigidBody& body) { return body.isActive(); }) &&
      !isChanged(group)) {
    for (SoftBodyData* body : group.bodies) dropObjectForces(*body);
    return;
  }
  if (group.asleep)
    for (SoftBodyData* body : group.bodies)
      if (isSurfaceBody(*body) && isSurfaceChanged(*body)) wakeNeighbours(*body, true);
  if (group.asleep || anyMember(group, [](btRigidBody& body) {
        return !body.isActive() && body.getActivationState() == ISLAND_SLEEPING;
      }))
    wakeGroup(group);
  group.calmTime = sleepIsOff() || movesTooFast(group, tick) ? 0.0 : group.calmTime + calmTimeOf(tick);
  forEachMember(group, [](btRigidBody& body) { body.setDeactivationTime(0); });
  for (SoftBodyData* body : group.bodies)
    if (body->surface.object)
      body->surface.object->setDeactivationTime(static_cast<btScalar>(group.calmTime));
}

void rememberCalmTime(const LinkedGroup& group) {
  for (SoftBodyData* body : group.bodies) body->calmTime = group.calmTime;
}

bool wantsSleep(const LinkedGroup& group) {
  return !group.asleep && group.calmTime > double(gDeactivationTime);
}

void markIsland(const btRigidBody& body, std::vector<unsigned char>& bulletIslands) {
  const int tag = body.getIslandTag();
  if (tag >= 0 && static_cast<std::size_t>(tag) < bulletIslands.size())
    bulletIslands[static_cast<std::size_t>(tag)] = 1;
}

bool inMarkedIsland(const btRigidBody& body, const std::vector<unsigned char>& bulletIslands) {
  const int tag = body.getIslandTag();
  return tag >= 0 && static_cast<std::size_t>(tag) < bulletIslands.size() &&
         bulletIslands[static_cast<std::size_t>(tag)];
}

/// Returns whether the body is the surface of a soft body in the same system as all these groups.
bool isOwnSurface(const std::vector<LinkedGroup>& groups, const btRigidBody* body) {
  const SurfaceObject* surface = SurfaceObject::from(body);
  if (!surface || !surface->owner()) return false;
  for (const LinkedGroup& group : groups)
    if (!group.bodies.empty()) return group.bodies[0]->system == surface->owner()->system;
  return false;
}

/// Marks Bullet's islands of the last tick that contain an awake body which is in no group.
void markOthersAwake(const std::vector<LinkedGroup>& groups, btDiscreteDynamicsWorld& world,
                     std::vector<unsigned char>& bulletIslands) {
  const auto isPartner = [&](const btRigidBody* body) {
    for (const LinkedGroup& group : groups)
      for (const RigidPartner& partner : group.rigids)
        if (partner.body == body) return true;
    return false;
  };
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  bulletIslands.assign(static_cast<std::size_t>(objects.size()), 0);
  for (int i = 0; i < objects.size(); ++i) {
    btRigidBody* body = btRigidBody::upcast(objects[i]);
    if (!body || PointMass::from(body) || isOwnSurface(groups, body) || body->isStaticOrKinematicObject() ||
        isPartner(body))
      continue;
    if (body->isActive() && !body->wantsSleeping()) markIsland(*body, bulletIslands);
  }
}

/// Keeps groups awake that share an island with an awake body, and groups that share an island with these.
void settleCandidates(std::vector<LinkedGroup>& groups, std::vector<unsigned char>& bulletIslands) {
  const auto markGroup = [&](LinkedGroup& group) {
    forEachMember(group, [&](btRigidBody& body) { markIsland(body, bulletIslands); });
  };
  for (LinkedGroup& group : groups)
    if (!group.asleep && !wantsSleep(group)) markGroup(group);
  for (bool changed = true; changed;) {
    changed = false;
    for (LinkedGroup& group : groups) {
      if (!wantsSleep(group)) continue;
      if (!anyMember(group, [&](btRigidBody& body) { return inMarkedIsland(body, bulletIslands); })) continue;
      group.calmTime = double(gDeactivationTime);
      markGroup(group);
      changed = true;
    }
  }
}

}  // namespace

void updateSleep(std::vector<LinkedGroup>& groups, btDiscreteDynamicsWorld& world, btScalar tick,
                 std::vector<unsigned char>& bulletIslands, AwakeGroups& awake) {
  awake.clear();
  bool candidates = false;
  for (LinkedGroup& group : groups) {
    updateCalmTime(group, tick);
    rememberCalmTime(group);
    candidates = candidates || wantsSleep(group);
  }
  if (candidates) {
    markOthersAwake(groups, world, bulletIslands);
    settleCandidates(groups, bulletIslands);
  }
  for (LinkedGroup& group : groups) {
    if (wantsSleep(group)) sleepGroup(group);
    if (!group.asleep) awake.push_back(&group);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This file makes groups and runs the stages of their ticks, the step of those in no island included.

#include "bullet/linked_group.h"

#include "bullet/body_in_world.h"
#include "bullet/point_contacts.h"

#include <map>
#include <tuple>

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
  const auto it = std::find(group.bodies.begin(), group.bodies.end(), body);
  return {LinkEnd::Kind::Point, static_cast<std::uint32_t>(it - group.bodies.begin()), point};
}

LinkEnd rigidEnd(LinkedGroup& group, btRigidBody* body, const btVector3& pivot) {
  return {LinkEnd::Kind::Rigid, indexOfRigid(group, body), 0, toEigen(pivot)};
}

LinkEnd linkEnd(LinkedGroup& group, const SpringEnd& end) {
  if (!end.body) return {LinkEnd::Kind::World, 0, 0, toEigen(end.pivot)};
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
  for (SoftBodyData* body : group.bodies)
    (isSurfaceBody(*body) ? gatherSurface : gatherWorldPoints)(*body, tick);
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

/// Returns whether the links of points with a held body fit where it was placed much better than where it
/// was: the user has placed both together. Otherwise the body pulls its points over within the tick.
bool isPlacedWithItsPoints(const LinkedGroup& group, std::uint32_t rigid) {
  const RigidPartner& partner = group.rigids[rigid];
  if (!partner.held) return false;
  const btTransform& place = partner.body->getWorldTransform();
  double atPlace = 0.0, atLastPose = 0.0;  // m^2, squared errors of the links
  const auto add = [&](const LinkEnd& point, const LinkEnd& pivot, double length) {
    if (point.kind != LinkEnd::Kind::Point || pivot.kind != LinkEnd::Kind::Rigid || pivot.body != rigid)
      return;
    const Eigen::Vector3d x = group.bodies[point.body]->state.position.col(point.point);
    const Eigen::Vector3d last = partner.start.position + partner.start.rotation * pivot.pivot;
    atPlace += std::pow((x - toEigen(place(toBullet(pivot.pivot)))).norm() - length, 2);
    atLastPose += std::pow((x - last).norm() - length, 2);
  };
  for (const LinkAnchor& anchor : group.step.links.anchors) add(anchor.point, anchor.pivot, 0.0);
  for (const LinkSpring& spring : group.step.links.springs) {
    add(spring.a, spring.b, spring.restLength);
    add(spring.b, spring.a, spring.restLength);
  }
  return 4.0 * atPlace < atLastPose;
}

void gatherGroup(LinkedGroup& group, btScalar tick) {
  for (std::size_t i = 0; i < group.springs.size(); ++i) {
    LinkSpring& link = group.step.links.springs[i];
    placeEnds(link, *group.springs[i], double(tick));
    // a Grab changes them
    setStiffness(link, *group.springs[i], 1.0);
    link.damping = group.springs[i]->settings().damping;
  }
  for (SoftBodyData* body : group.bodies) gatherContacts(*body, tick);
  for (std::uint32_t i = 0; i < group.rigids.size(); ++i) {
    gatherRigid(group.rigids[i], group.step.links.rigids[i], tick);
    if (isPlacedWithItsPoints(group, i)) startFromPlace(group.rigids[i], group.step.links.rigids[i], tick);
  }
}

void readGroupFromBullet(LinkedGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies)
    if (body->alive) (isSurfaceBody(*body) ? finishSurface : finishWorldPoints)(*body, tick);
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    readRigidFromBullet(group.rigids[i], group.step.links.rigids[i], tick);
}

// --- groups in no island -----------------------------------------------------------------------------------

namespace {

/// Maximum number of springs of bodies in SIMD lanes. A block of larger ones would not fit into the cache
/// nearest to the processor (about 0.5 kB per spring with eight lanes). They are stepped one by one.
constexpr std::size_t kMaxSpringsInLanes = 1000;

/// A block has at most so many groups, and ends with the group by which it has so many springs: 64 bodies of
/// 8 points take 0.5 MB.
constexpr std::size_t kBlockGroups = 64, kBlockSprings = 4000;

bool canUseLanes(const LinkedGroup& group) {
  return !hasTolerance(group) && group.stepper == Stepper::Verlet && isPlain(group.step) &&
         group.bodies[0]->springs.size() <= kMaxSpringsInLanes && group.bodies[0]->springs.size() > 0;
}

/// Whether several threads can step the group together.
bool isDivided(const LinkedGroup& group) {
  const auto isLarge = [](const SoftBodyData* body) { return body->springs->division.isDivided(); };
  return group.stepper == Stepper::Verlet && std::any_of(group.bodies.begin(), group.bodies.end(), isLarge);
}

void countWork(const SoftBodyData& body, TickProfile& work) {
  const auto substeps = static_cast<std::size_t>(body.substeps);
  work.pointsStepped += pointCount(body);
  work.substeps += substeps;
  work.springSubsteps += body.springs.size() * substeps;
  work.contacts += body.contacts.size();
}

/// Adds the work of blocks. Their times are shares of `wallMs`: several threads may have stepped them at the
/// same time.
void addBlocks(const TickProfile& blocks, double wallMs, TickProfile& profile) {
  TickProfile work = blocks;
  const double sum = blocks.chooseMs + blocks.stepMs + blocks.writeMs;
  for (double TickProfile::*time : {&TickProfile::chooseMs, &TickProfile::stepMs, &TickProfile::writeMs})
    if (sum > 0.0) work.*time *= wallMs / sum;
  profile += work;
}

}  // namespace

void writeGroup(LinkedGroup& group, btScalar tick, TickProfile& work) {
  reportStepping(group, double(tick));
  for (SoftBodyData* body : group.bodies) {
    removeWaterMass(*body, double(tick));
    restoreIfUnsound(*body);
    countWork(*body, work);
    (isSurfaceBody(*body) ? writeBoxToBullet : writeVelocitiesToBullet)(*body, tick);
  }
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    writeRigidToBullet(group.rigids[i], group.step.links.rigids[i], tick);
  if (!group.inIsland) numberIsland(group.bodies);
}

void LoneGroups::collect(const AwakeGroups& groups) {
  lone_.clear();
  for (LinkedGroup* group : groups)
    if (!group->inIsland) lone_.push_back(group);
}

/// The work is that of the last tick: it only decides which threads step the group.
void LoneGroups::takeLarge() {
  double total = 0.0;
  for (const LinkedGroup* group : lone_) total += workOf(*group);
  const auto isSmall = [&](const LinkedGroup* group) {
    return !isDivided(*group) || workOf(*group) < kLargeShare * total;
  };
  const auto end = std::partition(lone_.begin(), lone_.end(), isSmall);
  large_.assign(end, lone_.end());
  lone_.erase(end, lone_.end());
}

void LoneGroups::stepLarge(double tick, const Parallel& parallel, TickProfile& profile) {
  LapTimer timer;
  for (LinkedGroup* group : large_) {
    chooseStepping(*group, tick);
    profile.chooseMs += timer.lap();
    parallel.together([&](Team& team) {
      group->step.team = &team;
      stepAlone(*group, tick, factors_);
      group->step.team = nullptr;
    });
    profile.stepMs += timer.lap();
    writeGroup(*group, static_cast<btScalar>(tick), profile);
    profile.writeMs += timer.lap();
  }
}

void LoneGroups::makeBlocks() {
  const auto before = [](const LinkedGroup* a, const LinkedGroup* b) {
    return std::tie(a->model, a) < std::tie(b->model, b);
  };
  if (!std::is_sorted(lone_.begin(), lone_.end(), before)) std::sort(lone_.begin(), lone_.end(), before);
  blocks_.clear();
  std::size_t springs = 0;
  for (std::size_t i = 0; i < lone_.size(); ++i) {
    if (blocks_.empty() || springs >= kBlockSprings || i - blocks_.back() == kBlockGroups) {
      blocks_.push_back(i);
      springs = 0;
    }
    springs += springCount(lone_[i]->bodies);
  }
  blocks_.push_back(lone_.size());
}

void LoneGroups::makeRuns(Block& block) const {
  AwakeGroups& groups = block.groups;
  const auto others = std::partition(groups.begin(), groups.end(),
                                     [](const LinkedGroup* group) { return canUseLanes(*group); });
  block.forLanes = static_cast<std::size_t>(others - groups.begin());
  const auto before = [](const LinkedGroup* a, const LinkedGroup* b) {
    return std::tie(a->model, a->substeps, a) < std::tie(b->model, b->substeps, b);
  };
  std::sort(groups.begin(), others, before);
  const auto fits = [](const LinkedGroup& a, const LinkedGroup& b) {
    return a.substeps == b.substeps && canShareLanes(a.step.bodies[0], b.step.bodies[0]);
  };
  const auto lanes = static_cast<std::size_t>(laneCount(set_));
  block.runs.clear();
  for (std::size_t i = 0, begin = 0; i < groups.size(); ++i) {
    const bool goesOn =
        i > begin && i < begin + lanes && i < block.forLanes && fits(*groups[begin], *groups[i]);
    if (goesOn) continue;
    begin = i;
    block.runs.push_back(i);
  }
  block.runs.push_back(groups.size());
}

/// A body that is alone in its lanes gains nothing from them.
void LoneGroups::stepRun(Block& block, std::size_t run, double tick) {
  const std::size_t begin = block.runs[run], end = block.runs[run + 1];
  AwakeGroups& groups = block.groups;
  if (end == begin + 1) return stepAlone(*groups[begin], tick, factors_);
  block.bodies.clear();
  for (std::size_t i = begin; i < end; ++i) block.bodies.push_back(&groups[i]->step.bodies[0]);
  stepLanes(block.bodies.data(), block.bodies.size(), block.lanes, tick, groups[begin]->substeps, set_);
  for (std::size_t i = begin; i < end; ++i) {
    groups[i]->bodies[0]->sumsValid = groups[i]->step.bodies[0].sums != nullptr;
    repeatIfMissed(*groups[i], tick, factors_);
  }
}

void LoneGroups::stepBlock(Block& block, double tick) {
  LapTimer timer;
  for (LinkedGroup* group : block.groups) chooseStepping(*group, tick);
  block.work.chooseMs = timer.lap();
  makeRuns(block);
  for (std::size_t run = 0; run + 1 < block.runs.size(); ++run) stepRun(block, run, tick);
  block.work.stepMs = timer.lap();
  for (LinkedGroup* group : block.groups) writeGroup(*group, static_cast<btScalar>(tick), block.work);
  block.work.writeMs = timer.lap();
}

void LoneGroups::step(const AwakeGroups& groups, double tick, const Parallel& parallel,
                      TickProfile& profile) {
  collect(groups);
  large_.clear();
  if (parallel.isOn()) takeLarge();
  stepLarge(tick, parallel, profile);
  makeBlocks();
  sum_ = TickProfile();
  LapTimer timer;
  parallel.forEach(blocks_.size() - 1, [&](std::size_t b) {
    scratch_.with([&](Block& block) {
      const auto first = lone_.begin();
      block.groups.assign(first + static_cast<std::ptrdiff_t>(blocks_[b]),
                          first + static_cast<std::ptrdiff_t>(blocks_[b + 1]));
      block.work = TickProfile();
      stepBlock(block, tick);
      const std::lock_guard<std::mutex> guard(lock_);
      sum_ += block.work;
    });
  });
  addBlocks(sum_, timer.lap(), profile);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

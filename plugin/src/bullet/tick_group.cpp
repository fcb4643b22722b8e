// SPDX-License-Identifier: Zlib
#include "bullet/tick_group.h"

#include "bullet/contact_gather.h"
#include "bullet/continuous_collision.h"
#include "bullet/convert.h"
#include "core/stepping_choice.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

bool isWhole(const TickGroup& group) {
  const auto pointGone = [](const PointMass* point) { return !point || !point->isInWorld(); };
  for (SoftBodyData* body : group.bodies) {
    const auto& points = body->masses.bodies;
    if (std::any_of(points.begin(), points.end(), pointGone)) body->alive = false;
    if (!body->alive) return false;
  }
  return true;
}

void gatherGroup(TickGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies) {
    gatherPoints(*body, tick);
    gatherContacts(*body, tick);
  }
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    gatherRigid(group.rigids[i], group.step.links.rigids[i], tick);
}

namespace {

/// The strictest of the bodies' choices; single springs keep the default.
Stepping strictest(const TickGroup& group) {
  if (group.bodies.size() == 1) return group.bodies[0]->settings.stepping;
  Stepping all;
  for (const SoftBodyData* body : group.bodies) {
    const Stepping& s = body->settings.stepping;
    all.atLeast = std::max(all.atLeast, s.atLeast);
    all.periodTolerance = std::min(all.periodTolerance, s.periodTolerance);
    all.budget = std::max(all.budget, s.budget);
    for (auto part : {&Stepping::tolerance, &Stepping::relativeTolerance})
      if (s.*part > 0.0) all.*part = all.*part > 0.0 ? std::min(all.*part, s.*part) : s.*part;
  }
  return all;
}

void updateBounds(SoftBodyData& body) {
  const Points& w = body.state.inverseMass;
  body.frequencySquared = limber::frequencyBoundSquared(body.springs, w, body.stiffnessSums);
  body.dampingRate = dampingRateBound(body.springs, w);
  body.frequencyStale = false;
}

/// Own springs and links add up to a stiffness matrix K = K_own + K_links, whose largest eigenvalue is at
/// most the sum of theirs.
double frequencyBoundSquared(TickGroup& group) {
  double own = 0.0;
  for (SoftBodyData* body : group.bodies) {
    if (body->frequencyStale) updateBounds(*body);
    own = std::max(own, body->frequencySquared);
  }
  return own + linkFrequencyBoundSquared(group.step.links);
}

/// rad per tick, which the usual number of substeps resolves anyhow.
constexpr double kNegligibleTurn = 0.5;

SteppingProblem problemOf(TickGroup& group, double tick) {
  SteppingProblem p;
  p.frequencySquared = frequencyBoundSquared(group);
  p.tick = tick;
  for (SoftBodyData* body : group.bodies) {
    p.dampingRate = std::max(p.dampingRate, body->dampingRate);
    p.turnRate = std::max(p.turnRate, fastestTurn(body->springs, body->state, kNegligibleTurn / tick));
    p.errorPerSquare = std::max(p.errorPerSquare, body->errorPerSquare);
    p.size = p.size > 0.0 ? std::min(p.size, body->size) : body->size;
    p.touching = p.touching || !body->contacts.empty();
    p.narrow = body->narrow;
  }
  p.implicitPossible = isPlain(group.step) && canStepImplicitly(group.step.bodies[0]);
  return p;
}

}  // namespace

void chooseStepping(TickGroup& group, double tick) {
  const SteppingChoice choice = limber::chooseStepping(problemOf(group, tick), strictest(group));
  group.stepper = choice.stepper;
  group.substeps = choice.substeps;
}

void stepGroup(TickGroup& group, double tick, SharedFactors& factors) {
  if (group.stepper == Stepper::Verlet) return stepVerlet(group.step, tick, group.substeps);
  const auto kind =
      group.stepper == Stepper::BandedNewton ? MidpointSolver::Kind::Newton : MidpointSolver::Kind::Shared;
  stepImplicit(group.step.bodies[0], group.bodies[0]->implicit, kind, tick, group.substeps, factors);
}

namespace {

/// s, for which a peak of the error is remembered.
constexpr double kErrorMemory = 0.25;

}  // namespace

void reportStepping(TickGroup& group, double tick) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    SoftBodyData& body = *group.bodies[i];
    const double square = std::pow(tick / group.substeps, 2);
    const double faded = body.errorPerSquare * std::max(0.0, 1.0 - tick / kErrorMemory);
    body.errorPerSquare = std::max(group.step.bodies[i].errorRate / square, faded);
    body.errorPerSecond = body.errorPerSquare * square;
    body.substeps = group.substeps;
    body.stepper = group.stepper;
  }
}

void handOverGroup(TickGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies) handOverVelocities(*body, tick);
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    handOverRigid(group.rigids[i], group.step.links.rigids[i], tick);
}

void takeBackGroup(TickGroup& group, btScalar tick) {
  for (SoftBodyData* body : group.bodies) {
    if (!body->alive) continue;
    takeBackContacts(*body, tick);
    stopAtFirstContact(*body);
    writePoints(*body);
  }
  for (std::size_t i = 0; i < group.rigids.size(); ++i)
    takeBackRigid(group.rigids[i], group.step.links.rigids[i]);
}

namespace {

/// Everything a link can join, numbered: soft bodies first, then rigid bodies in order of first mention.
class Nodes {
 public:
  explicit Nodes(const std::vector<SoftBodyData*>& bodies) {
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

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// The node of a spring's end. Static bodies and the world join nothing to each other.
std::size_t nodeOf(const SpringEnd& end, Nodes& nodes) {
  if (!end.body) return kNone;
  if (const PointMass* point = PointMass::from(end.body)) return nodes.soft(point->owner());
  return end.body->isStaticObject() ? kNone : nodes.rigid(end.body);
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

void takeOverSleep(TickGroup& group) {
  group.asleep = !group.bodies.empty();
  group.calmTime = group.bodies.empty() ? 0.0 : group.bodies.front()->calmTime;
  for (const SoftBodyData* body : group.bodies) {
    group.asleep = group.asleep && body->asleep;
    group.calmTime = std::min(group.calmTime, body->calmTime);
  }
}

}  // namespace

std::size_t countUsableLinks(const std::vector<SoftBodyData*>& bodies, const SpringList& springs) {
  std::size_t count = 0;
  for (const auto& spring : springs) count += usable(*spring);
  for (const SoftBodyData* body : bodies)
    for (const Anchor& anchor : body->anchors) count += usable(anchor);
  return count;
}

std::vector<TickGroup> makeGroups(const std::vector<SoftBodyData*>& bodies, const SpringList& springs) {
  Nodes nodes(bodies);
  std::vector<std::size_t> springNode(springs.size(), kNone);
  for (std::size_t i = 0; i < springs.size(); ++i) {
    if (!usable(*springs[i])) continue;
    const std::size_t a = nodeOf(springs[i]->endA(), nodes), b = nodeOf(springs[i]->endB(), nodes);
    if (a != kNone && b != kNone) nodes.join(a, b);
    springNode[i] = a != kNone ? a : b;
  }
  for (SoftBodyData* body : bodies)
    for (const Anchor& anchor : body->anchors)
      if (usable(anchor) && !anchor.body->isStaticObject())
        nodes.join(nodes.soft(body), nodes.rigid(anchor.body));

  std::map<std::size_t, TickGroup> groups;
  for (SoftBodyData* body : bodies) addBody(groups[nodes.root(nodes.soft(body))], body);
  for (std::size_t i = 0; i < springs.size(); ++i)
    if (springNode[i] != kNone) addSpring(groups[nodes.root(springNode[i])], springs[i].get());
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

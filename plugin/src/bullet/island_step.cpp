// SPDX-License-Identifier: Zlib

// This file gathers rigid bodies for the step and writes the result so that Bullet's solver moves them as the
// step did. It steps an island, limits the energy that joints add, and writes the result to Bullet.

#include "bullet/linked_group.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

const btTransform& endPoseOf(const btRigidBody& body) {
  return isKinematic(body) ? body.getInterpolationWorldTransform() : body.getWorldTransform();
}

/// A held body moves at constant velocity.
RigidState movedFrom(const btTransform& start, const btTransform& end, btScalar tick) {
  RigidState state;
  state.position = toEigen(start.getOrigin());
  state.rotation = toEigen(start.getRotation());
  state.velocity = (toEigen(end.getOrigin()) - state.position) / double(tick);
  state.angularVelocity = rotationBetween(state.rotation, toEigen(end.getRotation())) / double(tick);
  return state;
}

/// It moves from its last pose to its present one. A new partner may have moved before; its world transform
/// is that at the tick's start, while kinematic bodies are Rewound.
void gatherHeldRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  const btTransform& end = endPoseOf(*partner.body);
  if (std::exchange(partner.isNew, false)) partner.lastPose = partner.body->getWorldTransform();
  state = movedFrom(partner.lastPose, end, tick);
  partner.lastPose = end;
}

/// Returns the change (rad/s) of the angular velocity that Bullet's solver makes for unequal moments of
/// inertia.
Eigen::Vector3d gyroscopicChange(const btRigidBody& body, btScalar tick) {
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD)
    return toEigen(body.computeGyroscopicImpulseImplicit_World(tick));
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY)
    return toEigen(body.computeGyroscopicImpulseImplicit_Body(tick));
  return Eigen::Vector3d::Zero();
}

/// Returns whether the step can keep the body's angular momentum by itself. Bullet's implicit impulses lose
/// energy, the more the longer the tick.
bool isGyroscopic(const btRigidBody& body) {
  const Eigen::Vector3d inverse = toEigen(body.getInvInertiaDiagLocal());
  return (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY ||
          body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD) &&
         toEigen(body.getAngularFactor()) == Eigen::Vector3d::Ones() && inverse.minCoeff() > 0.0 &&
         inverse.minCoeff() < inverse.maxCoeff();
}

Eigen::Vector3d torqueAcceleration(const btRigidBody& body) {
  return toEigen(body.getInvInertiaTensorWorld() * body.getTotalTorque());
}

/// Sets the angular velocity (rad/s) at the start of the solver such that it becomes `target` before
/// impulses. Returns what it becomes, which differs for turns of a radian or more in a tick.
Eigen::Vector3d setInitialAngularVelocity(btRigidBody& body, const Eigen::Vector3d& target, btScalar tick) {
  Eigen::Vector3d initial = target;
  for (int i = 0; i < 3; ++i) {
    body.setAngularVelocity(toBullet(initial));
    initial = target - gyroscopicChange(body, tick);
  }
  body.setAngularVelocity(toBullet(initial));
  return initial + gyroscopicChange(body, tick);
}

void gatherFreeRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  const btRigidBody& body = *partner.body;
  state.position = toEigen(body.getWorldTransform().getOrigin());
  state.rotation = toEigen(body.getWorldTransform().getRotation());
  state.velocity = toEigen(body.getLinearVelocity());
  state.angularVelocity = toEigen(body.getAngularVelocity());
  state.acceleration = toEigen(body.getTotalForce()) * double(body.getInvMass());
  state.gyroscopic = isGyroscopic(body);
  state.angularAcceleration = torqueAcceleration(body);
  if (!state.gyroscopic) state.angularAcceleration += gyroscopicChange(body, tick) / double(tick);
  state.inverseMass = toEigen(body.getLinearFactor()) * double(body.getInvMass());
  state.inverseInertiaLocal = toEigen(body.getInvInertiaDiagLocal());
  state.angularFactor = toEigen(body.getAngularFactor());
}

/// Returns the factor by which Bullet multiplies velocities in the tick, before its solver. It is 0 only if
/// damping removes all motion.
double dampingFactor(btScalar damping, btScalar tick) {
  return std::pow(1.0 - double(damping), double(tick));
}

/// Bullet turns a body by no more than this in a tick, radians (btTransformUtil.h).
constexpr double kMostTurned = 0.25 * kPi;

/// Gives the body the motion of its step, and what else acted on it: fast turns are not those that Bullet
/// makes, and offsets are for Bullet's joints only. Its anchors would be torn off their points.
void completeMotion(RigidPartner& partner, btScalar tick) {
  constexpr double kSameTurn = 1e-4;  // radians
  const Eigen::Vector3d made = double(tick) * toEigen(partner.body->getAngularVelocity());
  const Eigen::Vector3d missing = partner.turn - double(tick) * toEigen(partner.expectedAngularVelocity);
  const Eigen::Vector3d turn = made + missing;
  const bool isTurned = turn.norm() < kMostTurned && missing.norm() < kSameTurn;
  if (isTurned && partner.velocityOffset.isZero(0.0)) return;
  btTransform pose = partner.body->getWorldTransform();
  pose.setOrigin(pose.getOrigin() - tick * toBullet(partner.velocityOffset));
  const Eigen::Quaterniond q = rotationBy(turn) * partner.start.rotation;
  pose.setRotation(toBullet(q));
  partner.body->setCenterOfMassTransform(pose);
}

}  // namespace

RigidPartner makePartner(btRigidBody& body) {
  RigidPartner partner;
  partner.body = &body;
  partner.handle = handleOf(body);
  return partner;
}

void gatherRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  partner.held =
      isStaticOrKinematic(*partner.body) || partner.body->getActivationState() == DISABLE_SIMULATION;
  if (partner.held)
    gatherHeldRigid(partner, state, tick);
  else
    gatherFreeRigid(partner, state, tick);
  partner.start = state;
  partner.velocityOffset.setZero();
  partner.spinOffset.setZero();
}

void startFromPlace(RigidPartner& partner, RigidState& state, btScalar tick) {
  state = partner.start = movedFrom(partner.body->getWorldTransform(), endPoseOf(*partner.body), tick);
}

RigidState meanMotion(const RigidState& start, const RigidState& end, double tick) {
  RigidState mean = start;
  mean.velocity = (end.position - start.position) / tick;
  mean.angularVelocity = rotationBetween(start.rotation, end.rotation) / tick;
  return mean;
}

void writeRigidToBullet(RigidPartner& partner, const RigidState& end, btScalar tick) {
  if (partner.held) return;
  btRigidBody& body = *partner.body;
  const double h = double(tick);
  const RigidState motion = meanMotion(partner.start, end, h);
  const Eigen::Vector3d mean = motion.velocity + partner.velocityOffset;
  const Eigen::Vector3d meanAngular = motion.angularVelocity + partner.spinOffset;
  const double linear = dampingFactor(body.getLinearDamping(), tick);
  const double angular = dampingFactor(body.getAngularDamping(), tick);
  const Eigen::Vector3d initial = mean - h * partner.start.acceleration;
  const Eigen::Vector3d torque = h * torqueAcceleration(body);
  const Eigen::Vector3d reached = setInitialAngularVelocity(body, meanAngular - torque, tick) + torque;
  if (linear > 0.0) body.setLinearVelocity(toBullet(initial / linear));
  if (angular > 0.0) body.setAngularVelocity(body.getAngularVelocity() / static_cast<btScalar>(angular));
  partner.expectedVelocity = toBullet(mean);
  partner.expectedAngularVelocity = toBullet(reached);
  partner.turn = h * motion.angularVelocity;
}

void readRigidFromBullet(RigidPartner& partner, const RigidState& end, btScalar tick) {
  if (partner.held) return;
  btRigidBody& body = *partner.body;
  if (body.isActive()) completeMotion(partner, tick);
  partner.lastPose = body.getWorldTransform();
  if (!body.isActive()) return;
  const Eigen::Vector3d velocity = dampingFactor(body.getLinearDamping(), tick) * end.velocity;
  const Eigen::Vector3d spin = dampingFactor(body.getAngularDamping(), tick) * end.angularVelocity;
  body.setLinearVelocity(body.getLinearVelocity() - partner.expectedVelocity + toBullet(velocity));
  body.setAngularVelocity(body.getAngularVelocity() - partner.expectedAngularVelocity + toBullet(spin));
  body.setInterpolationLinearVelocity(body.getLinearVelocity());
  body.setInterpolationAngularVelocity(body.getAngularVelocity());
}

// --- the step of an island ---------------------------------------------------------------------------------

namespace {

/// Scales the first guesses of impulses: they are sums over the last tick, and each of its substeps solves a
/// contact twice.
void scaleWarmStart(IslandConstraints& pairs, int substeps) {
  for (Contact& c : pairs.contacts) {
    const double share = 0.5 / substeps;
    c.positionImpulse *= share;
    c.velocityImpulse = c.positionImpulse;
  }
  for (JointConstraint& j : pairs.joints) {
    j.lower /= 2.0 * substeps, j.upper /= 2.0 * substeps;
    j.yielding *= 2.0 * substeps;
  }
}

/// Fraction of an overlap that is corrected per tick. Bullet's solver corrects as much, and leaves this speed
/// to the bodies (btContactSolverInfo::m_erp2). A higher speed would be a kick that Bullet alone does not
/// give.
constexpr double kOverlapPerTick = 0.2;

/// Fraction of the recovery speed at which an overlap may always be corrected. Every solve leaves small
/// overlaps; this causes hops of about 2e-5 m.
constexpr double kMinRecovery = 0.04;

/// Limits the recovery speed of contacts between rigid bodies to that of Bullet's solver.
void limitRecoverySpeed(IslandConstraints& pairs, double tick) {
  const auto isSoft = [](const ContactPoint& side) { return side.kind == ContactPoint::Kind::Soft; };
  for (Contact& c : pairs.contacts)
    if (!isSoft(c.a) && !isSoft(c.b))
      c.recoverySpeed =
          std::clamp(-kOverlapPerTick * c.gap / tick, kMinRecovery * c.recoverySpeed, c.recoverySpeed);
}

/// Returns a speed (m/s): a small fraction of the largest speed, or of the largest change by gravity and
/// forces in a tick.
double speedTolerance(const SolverIsland& step, double tick) {
  double squared = 0.0;
  const auto add = [&](const auto& acceleration, const auto& velocity) {
    squared = std::max({squared, tick * tick * acceleration.squaredNorm(), 4e-4 * velocity.squaredNorm()});
  };
  for (const SolverBody& body : step.bodies)
    for (Eigen::Index i = 0; i < body.points->position.cols(); ++i)
      add(body.points->acceleration.col(i), body.points->velocity.col(i));
  for (const RigidState& rigid : step.links.rigids) add(rigid.acceleration, rigid.velocity);
  return 6e-4 * std::sqrt(squared);
}

/// Returns the index of the first of the island's rigid bodies that are in no group.
std::size_t firstOwnRigid(const Island& island) {
  return island.step.links.rigids.size() - island.rigids.size();
}

void copyToGroups(Island& island) {
  const SolverIsland& step = island.step;
  std::size_t body = 0, rigid = 0, spring = 0, anchor = 0;
  for (LinkedGroup* group : island.groups) {
    for (SolverBody& stepped : group->step.bodies) stepped.errorRate = step.bodies[body++].errorRate;
    for (RigidState& state : group->step.links.rigids) state = step.links.rigids[rigid++];
    for (LinkSpring& link : group->step.links.springs) link.force = step.links.springs[spring++].force;
    for (LinkAnchor& link : group->step.links.anchors) {
      link.impulse = step.links.anchors[anchor].impulse;
      link.positionImpulse = step.links.anchors[anchor].positionImpulse;
      link.velocityImpulse = step.links.anchors[anchor++].velocityImpulse;
    }
  }
}

// --- energy ------------------------------------------------------------------------------------------------

/// Returns the sum over the axes of x_i y_i / w_i, where w is `inverse`. Axes without inverse mass are
/// skipped: they do not move freely.
double weighted(const Eigen::Vector3d& x, const Eigen::Vector3d& y, const Eigen::Vector3d& inverse) {
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) sum += inverse[k] > 0.0 ? x[k] * y[k] / inverse[k] : 0.0;
  return sum;
}

double kineticEnergy(const RigidState& rigid) {
  if (rigid.isFrame) return 0.0;
  const Eigen::Vector3d spin = rigid.rotation.conjugate() * rigid.angularVelocity;
  return 0.5 * weighted(rigid.velocity, rigid.velocity, rigid.inverseMass) +
         0.5 * weighted(spin, spin, rigid.inverseInertiaLocal);
}

double kineticEnergy(const SolverIsland& step) {
  double sum = 0.0;
  for (const SolverBody& body : step.bodies) sum += limber::kineticEnergy(*body.points);
  for (const RigidState& rigid : step.links.rigids) sum += kineticEnergy(rigid);
  return sum;
}

double energyOf(SolverIsland& step) {
  double sum = kineticEnergy(step) + elasticEnergy(step.links);
  for (SolverBody& body : step.bodies) sum += elasticEnergy(body, body.points->position);
  return sum;
}

/// Returns the work (J) of the constant accelerations and of drag in the tick.
double workOfSurroundings(const Island& island) {
  double work = 0.0;
  for (const SolverBody& body : island.step.bodies) work += body.drag ? body.drag->work : 0.0;
  for (const SoftBodyData* body : island.softBodies) {
    const PointState& s = body->state;
    for (Eigen::Index i = 0; i < s.position.cols(); ++i)
      work += weighted(s.acceleration.col(i), s.position.col(i) - body->masses.startPosition.col(i),
                       s.inverseMass.col(i));
  }
  for (std::size_t i = 0; i < island.start.size(); ++i) {
    const RigidState &start = island.start[i], &end = island.step.links.rigids[i];
    const Eigen::Quaterniond toLocal = start.rotation.conjugate();
    work += weighted(start.acceleration, end.position - start.position, start.inverseMass);
    work += weighted(toLocal * start.angularAcceleration,
                     toLocal * rotationBetween(start.rotation, end.rotation), start.inverseInertiaLocal);
  }
  return work;
}

bool isJoint(const JointConstraint& j) { return j.contact == JointConstraint::kHeld; }

/// Returns the work (J) of kinematic bodies by joints.
double workOfKinematic(const Island& island, const TickContacts& found) {
  double work = 0.0;
  for (std::size_t i = 0; i < island.joints.size(); ++i)
    work += island.step.pairs.joints[i].impulse * found.jointSources[island.joints[i]].kinematic;
  return work;
}

/// Returns the work (J) by which joints have corrected their errors.
double workOfRecovery(const Island& island) {
  double work = 0.0;
  for (const JointConstraint& j : island.step.pairs.joints) work += j.work;
  return work;
}

/// The motion of moving bodies as one rigid body. The mass is 0 if one is joined to a static or kinematic
/// body.
struct CommonMotion {
  double mass = 0.0;                                  ///< kg
  Eigen::Vector3d center = Eigen::Vector3d::Zero();   ///< m, of mass
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();     ///< m/s
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();     ///< rad/s; 0 unless addSpin() sets it
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< kg m^2/s, the angular momentum of the spin

  Eigen::Vector3d at(const Eigen::Vector3d& position) const { return mean + spin.cross(position - center); }
  double energy() const { return 0.5 * mass * mean.squaredNorm() + 0.5 * spin.dot(angular); }
};

/// Calls softs(body) and rigids(body) for the moving bodies that count: all, or those of `only` (see
/// Island::joined).
template <class Step, class Softs, class Rigids>
void forEachMoving(Step& step, const std::vector<unsigned char>* only, Softs softs, Rigids rigids) {
  for (std::size_t i = 0; i < step.bodies.size(); ++i)
    if (!only || (*only)[i]) softs(*step.bodies[i].points);
  for (std::size_t i = 0; i < step.links.rigids.size(); ++i) {
    auto& rigid = step.links.rigids[i];
    const bool counts = !only || (*only)[step.bodies.size() + i];
    if (counts && !rigid.isFrame && rigid.inverseMass.minCoeff() > 0.0) rigids(rigid);
  }
}

/// Calls visit(mass, position, velocity) for their points and rigid bodies.
template <class Visit>
void forEachMass(const SolverIsland& step, const std::vector<unsigned char>* only, Visit visit) {
  const auto visitPoints = [&](const PointState& points) {
    for (Eigen::Index i = 0; i < points.position.cols(); ++i)
      if (const double inverse = points.inverseMass.col(i).minCoeff(); inverse > 0.0)
        visit(1.0 / inverse, points.position.col(i), points.velocity.col(i));
  };
  forEachMoving(step, only, visitPoints, [&](const RigidState& rigid) {
    visit(1.0 / rigid.inverseMass.x(), rigid.position, rigid.velocity);
  });
}

CommonMotion commonMotion(const SolverIsland& step, const std::vector<unsigned char>* only) {
  CommonMotion all;
  for (const JointConstraint& j : step.pairs.joints)
    if (isJoint(j) && (j.a == JointConstraint::kHeld || j.b == JointConstraint::kHeld)) return all;
  forEachMass(step, only, [&](double mass, const Eigen::Vector3d& x, const Eigen::Vector3d& v) {
    all.mass += mass, all.center += mass * x, all.mean += mass * v;
  });
  if (all.mass > 0.0) all.center /= all.mass, all.mean /= all.mass;
  return all;
}

/// Sets the angular velocity that belongs to the angular momentum about the centre of mass, unless a rigid
/// body cannot turn freely.
void addSpin(const SolverIsland& step, const std::vector<unsigned char>& only, CommonMotion& motion) {
  bool isFree = motion.mass > 0.0;
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  forEachMass(step, &only, [&](double mass, const Eigen::Vector3d& x, const Eigen::Vector3d& v) {
    const Eigen::Vector3d d = x - motion.center;
    angular += mass * d.cross(v);
    inertia += mass * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
  });
  forEachMoving(
      step, &only, [](const PointState&) {},
      [&](const RigidState& rigid) {
        isFree = isFree && rigid.inverseInertiaLocal.minCoeff() > 0.0 && rigid.angularFactor.minCoeff() > 0.0;
        if (!isFree) return;
        angular += rigid.angularMomentum();
        inertia += rigid.inverseInertia.inverse();
      });
  if (!isFree) return;
  motion.spin = inertia.completeOrthogonalDecomposition().solve(angular);
  motion.angular = angular;
}

/// J, relative to the common motion.
double relativeEnergy(const SolverIsland& step, const CommonMotion& motion,
                      const std::vector<unsigned char>* only) {
  double sum = -motion.energy();
  forEachMoving(
      step, only, [&](const PointState& points) { sum += limber::kineticEnergy(points); },
      [&](const RigidState& rigid) { sum += kineticEnergy(rigid); });
  return sum;
}

/// Returns the mean square (m^2/s^2) of all velocities relative to the mean motion, weighted by mass.
double squaredMotion(const SolverIsland& step) {
  const CommonMotion motion = commonMotion(step, nullptr);
  return motion.mass > 0.0 ? 2.0 * relativeEnergy(step, motion, nullptr) / motion.mass : 0.0;
}

/// Scales velocities relative to the common motion.
void slowDown(SolverIsland& step, const std::vector<unsigned char>& only, const CommonMotion& motion,
              double factor) {
  const auto slowPoints = [&](PointState& points) {
    for (Eigen::Index i = 0; i < points.velocity.cols(); ++i) {
      const Eigen::Vector3d common = motion.at(points.position.col(i));
      if (points.inverseMass.col(i).minCoeff() > 0.0)
        points.velocity.col(i) = common + factor * (points.velocity.col(i) - common);
    }
  };
  forEachMoving(step, &only, slowPoints, [&](RigidState& rigid) {
    const Eigen::Vector3d common = motion.at(rigid.position);
    rigid.velocity = common + factor * (rigid.velocity - common);
    rigid.angularVelocity = motion.spin + factor * (rigid.angularVelocity - motion.spin);
  });
}

/// Sets island.joined.
void markJoined(Island& island) {
  const SolverIsland& step = island.step;
  island.joined.assign(step.bodies.size() + step.links.rigids.size(), 0);
  unsigned char *softs = island.joined.data(), *rigids = softs + step.bodies.size();
  for (const JointConstraint& j : step.pairs.joints)
    for (const std::uint32_t side : {j.a, j.b})
      if (isJoint(j) && side != JointConstraint::kHeld) rigids[side] = 1;
  for (const BodyFrame& frame : step.links.frames) softs[frame.body] = rigids[frame.rigid];
  for (const LinkedGroup* group : island.groups) {
    unsigned char *softsEnd = softs + group->bodies.size(), *rigidsEnd = rigids + group->rigids.size();
    if (std::count(softs, softsEnd, 1) + std::count(rigids, rigidsEnd, 1) > 0)
      std::fill(softs, softsEnd, 1), std::fill(rigids, rigidsEnd, 1);
    softs = softsEnd, rigids = rigidsEnd;
  }
}

/// Removes the increase of the energy in the tick from the motion of the joints' bodies, as far as joints
/// have caused it by correcting their errors.
void limitEnergy(Island& island, const TickContacts& found, double energyBefore) {
  const double outer = workOfSurroundings(island) + workOfKinematic(island, found);
  const double increase = energyOf(island.step) - energyBefore - outer;
  const double excess = std::min(increase, workOfRecovery(island));
  if (!(excess > 0.0)) return;
  markJoined(island);
  CommonMotion motion = commonMotion(island.step, &island.joined);
  addSpin(island.step, island.joined, motion);
  const double relative = relativeEnergy(island.step, motion, &island.joined);
  if (relative > excess) slowDown(island.step, island.joined, motion, std::sqrt(1.0 - excess / relative));
}

// --- contacts and impulses of the step ---------------------------------------------------------------------

/// Adds contacts found within the tick to `found`, so that they are reported and stored.
void reportLateContacts(Island& island, TickContacts& found) {
  const std::size_t first = island.contacts.size() + island.rows.size();
  for (std::size_t i = 0; i < island.late.size(); ++i) {
    const SurfaceCandidate& candidate = *island.candidates[island.late[i].candidate].surfaces;
    TickContact& contact = found.contacts.emplace_back(
        TickContact{island.step.pairs.contacts[first + i], island.late[i].source});
    contact.a.body = candidate.body->index;
    if (candidate.other) contact.b.body = candidate.other->index;
    if (candidate.partner) contact.b.body = found.find(*candidate.partner);
  }
}

void copyContact(const Contact& contact, Contact& found) {
  const std::uint32_t a = found.a.body, b = found.b.body;
  found = contact;
  found.a.body = a, found.b.body = b;
}

/// Returns whether a single soft body moves, and touches only itself or surfaces at rest.
bool isAlone(const Island& island) {
  const SolverIsland& step = island.step;
  const LinkedBodies& links = step.links;
  if (step.bodies.size() != 1 || !links.rigids.empty() || !links.springs.empty() || !links.anchors.empty())
    return false;
  const auto isStill = [](const Contact& c) { return c.b.velocity.isZero(0.0); };
  const auto stays = [](const IslandPair& m) { return m.held.isZero(); };
  return std::all_of(step.pairs.contacts.begin(), step.pairs.contacts.end(), isStill) &&
         std::all_of(island.candidates.begin(), island.candidates.end(), stays) &&
         areSurfacesAtRest(*step.bodies[0].contacts);
}

/// Returns whether contacts bounce, present ones or those that may be found in the step.
bool bounces(const Island& island) {
  const std::vector<Contact>& contacts = island.step.pairs.contacts;
  return std::any_of(contacts.begin(), contacts.end(),
                     [](const Contact& c) { return c.restitution > 0.0; }) ||
         std::any_of(island.candidates.begin(), island.candidates.end(),
                     [](const IslandPair& m) { return restitutionOf(*m.surfaces) > 0.0; });
}

void stepIsland(Island& island, const TickContacts& found, double tick, ScratchPool<SurfaceSearch>& searches,
                std::mutex& lock) {
  const bool joined = !island.joints.empty();
  const bool alone = isAlone(island), bouncing = alone && bounces(island);
  for (LinkedGroup* group : island.groups) limitIslandEnergy(*group, alone, bouncing, joined);
  int substeps = 1;
  for (const LinkedGroup* group : island.groups) substeps = std::max(substeps, group->substeps);
  SearchContext context{&island, &found, &searches, &lock};
  substeps = planSearches(context, substeps);
  for (LinkedGroup* group : island.groups) group->substeps = substeps;
  scaleWarmStart(island.step.pairs, substeps);
  island.step.pairs.tolerance = speedTolerance(island.step, tick);
  island.step.pairs.squaredMotion = squaredMotion(island.step);
  limitRecoverySpeed(island.step.pairs, tick);
  island.start.clear();
  if (joined) island.start = island.step.links.rigids;
  const double before = joined ? energyOf(island.step) : 0.0;
  stepVerlet(island.step, tick, substeps);
  if (joined) limitEnergy(island, found, before);
}

/// Number of springs whose substeps are worth the time in which threads wait for each other.
constexpr std::size_t kTeamSprings = 2000;

double workOf(const Island& island) {
  double work = 0.0;
  for (const LinkedGroup* group : island.groups) work += workOf(*group);
  return work;
}

/// Finds the islands that a team steps.
void findLarge(Islands& islands, const Parallel& parallel) {
  islands.large.clear();
  islands.small.clear();
  double total = 0.0;
  for (const Island& island : islands) total += workOf(island);
  const std::size_t enough = std::min(kTeamSprings, parallel.fromSprings());
  for (std::uint32_t i = 0; i < islands.count; ++i) {
    const Island& island = islands.all[i];
    const bool isLarge =
        parallel.isOn() && springCount(island.softBodies) >= enough && workOf(island) >= kLargeShare * total;
    (isLarge ? islands.large : islands.small).push_back(i);
  }
}

}  // namespace

void stepIslands(Islands& islands, const TickContacts& found, double tick,
                 ScratchPool<SurfaceSearch>& searches, std::mutex& lock, const Parallel& parallel) {
  findLarge(islands, parallel);
  const auto step = [&](std::uint32_t i, Team* team) {
    islands.all[i].step.team = team;
    stepIsland(islands.all[i], found, tick, searches, lock);
    islands.all[i].step.team = nullptr;
  };
  for (const std::uint32_t i : islands.large) parallel.together([&](Team& team) { step(i, &team); });
  parallel.forEach(islands.small.size(), [&](std::size_t i) { step(islands.small[i], nullptr); });
}

namespace {

/// Offers Bullet's joints velocities at which they hold. Bullet evaluates them where the bodies are at the
/// start of the tick. At the mean velocities of bodies that have turned about a common pivot on circles, they
/// would not hold, and Bullet would pull the bodies apart in each tick.
void offerToJoints(Island& island, TickContacts& found, double tick) {
  LinkedBodies& motion = island.mean;
  motion.rigids = island.start;
  const std::vector<RigidState>& ends = island.step.links.rigids;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    (motion.rigids[i] = meanMotion(island.start[i], ends[i], tick)).turn();
    if (ends[i].isFrame) motion.rigids[i].inverseInertia = ends[i].inverseInertia;
  }
  holdJoints(island.step.pairs, motion);
  std::size_t next = 0;
  const auto offer = [&](RigidPartner& partner) {
    const RigidState mean = meanMotion(island.start[next], ends[next], tick);
    partner.velocityOffset = motion.rigids[next].velocity - mean.velocity;
    partner.spinOffset = motion.rigids[next].angularVelocity - mean.angularVelocity;
    ++next;
  };
  for (LinkedGroup* group : island.groups)
    for (RigidPartner& partner : group->rigids) offer(partner);
  for (const std::uint32_t i : island.rigids) offer(found.rigids[i]);
}

/// Writes that of a soft body to its surface object.
void writeMotion(RigidPartner& partner, const RigidState& end, btScalar tick) {
  if (!end.isFrame) return writeRigidToBullet(partner, end, tick);
  const RigidState mean = meanMotion(partner.start, end, double(tick));
  offerMotion(*SurfaceObject::from(partner.body)->owner(), mean.velocity + partner.velocityOffset,
              mean.angularVelocity + partner.spinOffset);
}

}  // namespace

void writeIslandToBullet(Island& island, TickContacts& found, btScalar tick) {
  if (!island.joints.empty()) offerToJoints(island, found, double(tick));
  const IslandConstraints& pairs = island.step.pairs;
  for (std::size_t i = 0; i < island.contacts.size(); ++i)
    copyContact(pairs.contacts[i], found.contacts[island.contacts[i]]);
  reportLateContacts(island, found);
  for (std::size_t i = 0; i < island.joints.size(); ++i)
    found.joints[island.joints[i]].impulse = pairs.joints[i].impulse;
  for (std::size_t i = 0; i < island.rows.size(); ++i)
    island.rows[i]->impulse = pairs.contacts[island.contacts.size() + i].impulse;
  copyToGroups(island);
  const std::size_t first = firstOwnRigid(island);
  for (std::size_t i = 0; i < island.rigids.size(); ++i)
    writeMotion(found.rigids[island.rigids[i]], island.step.links.rigids[first + i], tick);
}

void readIslandFromBullet(const Island& island, TickContacts& found, const btCollisionWorld& world,
                          btScalar tick) {
  const std::size_t first = firstOwnRigid(island);
  for (std::size_t i = 0; i < island.rigids.size(); ++i) {
    const RigidState& end = island.step.links.rigids[first + i];
    if (RigidPartner& rigid = found.rigids[island.rigids[i]]; !end.isFrame && isValid(world, rigid.handle))
      readRigidFromBullet(rigid, end, tick);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

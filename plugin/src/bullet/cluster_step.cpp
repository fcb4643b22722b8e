// SPDX-License-Identifier: Zlib

// This file steps a cluster, searches for contacts within its step, limits what joints add to its energy, and
// writes the result to Bullet.

#include "bullet/tick_group.h"
#include "solver/point_state.h"
#include "solver/springs.h"

#include <algorithm>
#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Guesses are sums over the last tick, in each of whose substeps a contact is solved twice.
void spreadGuesses(PairRows& pairs, int substeps) {
  for (PairContact& c : pairs.contacts) {
    const double share = 0.5 / substeps;
    c.stopping *= share;
    c.settling = c.stopping;
  }
  for (JointRow& j : pairs.joints) j.lower /= 2.0 * substeps, j.upper /= 2.0 * substeps;
}

/// Of an overlap per tick, as Bullet's solver takes it back, which leaves the bodies that speed
/// (btContactSolverInfo::m_erp2): any more would be a kick that a hit without us does not give.
constexpr double kOverlapPerTick = 0.2;

/// Share of the recovery speed at which an overlap may always be corrected. Every solve leaves small overlaps; this
/// makes hops of about 2e-5 m.
constexpr double kLeastRecovery = 0.04;

/// Rigid bodies among themselves part as by Bullet's solver.
void recoverAsBullet(PairRows& pairs, double tick) {
  for (PairContact& c : pairs.contacts)
    c.recoverySpeed = std::clamp(-kOverlapPerTick * c.gap / tick, kLeastRecovery * c.recoverySpeed, c.recoverySpeed);
}

/// m/s: a small share of what gravity and forces give in a tick, or of how fast anything is.
double speedTolerance(const StepGroup& step, double tick) {
  double squared = 0.0;
  const auto add = [&](const auto& acceleration, const auto& velocity) {
    squared = std::max({squared, tick * tick * acceleration.squaredNorm(), 4e-4 * velocity.squaredNorm()});
  };
  for (const SteppedBody& body : step.bodies)
    for (Eigen::Index i = 0; i < body.points->position.cols(); ++i)
      add(body.points->acceleration.col(i), body.points->velocity.col(i));
  for (const RigidState& rigid : step.links.rigids) add(rigid.acceleration, rigid.velocity);
  return 6e-4 * std::sqrt(squared);
}

/// The index of the first of the cluster's rigid bodies that are in no group.
std::size_t firstOwnRigid(const Cluster& cluster) {
  return cluster.step.links.rigids.size() - cluster.rigids.size();
}

void giveBack(Cluster& cluster) {
  const StepGroup& step = cluster.step;
  std::size_t body = 0, rigid = 0, spring = 0, anchor = 0;
  for (TickGroup* group : cluster.groups) {
    for (SteppedBody& stepped : group->step.bodies) stepped.errorRate = step.bodies[body++].errorRate;
    for (RigidState& state : group->step.links.rigids) state = step.links.rigids[rigid++];
    for (LinkSpring& link : group->step.links.springs) link.force = step.links.springs[spring++].force;
    for (LinkAnchor& link : group->step.links.anchors) {
      link.stopping = step.links.anchors[anchor].stopping;
      link.settling = step.links.anchors[anchor++].settling;
    }
  }
}

// --- energy ------------------------------------------------------------------------------------------------

/// The sum over the axes of x_i y_i / w_i; what has no inverse mass does not move by itself.
double weighted(const Eigen::Vector3d& x, const Eigen::Vector3d& y, const Eigen::Vector3d& inverse) {
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) sum += inverse[k] > 0.0 ? x[k] * y[k] / inverse[k] : 0.0;
  return sum;
}

double kineticEnergy(const RigidState& rigid) {
  const Eigen::Vector3d spin = rigid.rotation.conjugate() * rigid.angularVelocity;
  return 0.5 * weighted(rigid.velocity, rigid.velocity, rigid.inverseMass) +
         0.5 * weighted(spin, spin, rigid.inverseInertiaLocal);
}

double kineticEnergy(const StepGroup& step) {
  double sum = 0.0;
  for (const SteppedBody& body : step.bodies) sum += limber::kineticEnergy(*body.points);
  for (const RigidState& rigid : step.links.rigids) sum += kineticEnergy(rigid);
  return sum;
}

double energyOf(StepGroup& step) {
  double sum = kineticEnergy(step) + elasticEnergy(step.links);
  for (SteppedBody& body : step.bodies) sum += elasticEnergy(body, body.points->position);
  return sum;
}

/// J, what the constant accelerations have done in the tick.
double workOfAccelerations(const Cluster& cluster) {
  double work = 0.0;
  for (const SoftBodyData* body : cluster.softBodies) {
    const PointState& s = body->state;
    const Points way = s.position - body->masses.startPosition;
    for (Eigen::Index i = 0; i < way.cols(); ++i)
      work += weighted(s.acceleration.col(i), way.col(i), s.inverseMass.col(i));
  }
  for (std::size_t i = 0; i < cluster.start.size(); ++i) {
    const RigidState &start = cluster.start[i], &end = cluster.step.links.rigids[i];
    const Eigen::Quaterniond inside = start.rotation.conjugate();
    work += weighted(start.acceleration, end.position - start.position, start.inverseMass);
    work += weighted(inside * start.angularAcceleration, inside * rotationBetween(start.rotation, end.rotation),
                     start.inverseInertiaLocal);
  }
  return work;
}

/// J, what joints have done by taking back errors.
double workOfRecoveries(const Cluster& cluster, const TickContacts& found) {
  double work = 0.0;
  for (std::size_t i = 0; i < cluster.joints.size(); ++i)
    work += cluster.step.pairs.joints[i].impulse * found.jointSources[cluster.joints[i]].recovery;
  return work;
}

/// kg and m/s, of all that moves; of no mass where something is joined to what is held.
struct CommonMotion {
  double mass = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
};

CommonMotion commonMotion(const StepGroup& step) {
  CommonMotion all;
  for (const JointRow& j : step.pairs.joints)
    if (j.contact == JointRow::kHeld && (j.a == JointRow::kHeld || j.b == JointRow::kHeld)) return all;
  for (const SteppedBody& body : step.bodies) {
    all.mass += totalMass(*body.points);
    all.mean += linearMomentum(*body.points);
  }
  for (const RigidState& rigid : step.links.rigids)
    if (rigid.inverseMass.minCoeff() > 0.0) {
      all.mass += 1.0 / rigid.inverseMass.x();
      all.mean += rigid.velocity / rigid.inverseMass.x();
    }
  if (all.mass > 0.0) all.mean /= all.mass;
  return all;
}

/// Scales all motion relative to `mean`.
void slowDown(StepGroup& step, const Eigen::Vector3d& mean, double factor) {
  for (SteppedBody& body : step.bodies)
    for (Eigen::Index i = 0; i < body.points->velocity.cols(); ++i)
      if (body.points->inverseMass.col(i).minCoeff() > 0.0)
        body.points->velocity.col(i) = mean + factor * (body.points->velocity.col(i) - mean);
  for (RigidState& rigid : step.links.rigids)
    if (rigid.inverseMass.minCoeff() > 0.0) {
      rigid.velocity = mean + factor * (rigid.velocity - mean);
      rigid.angularVelocity *= factor;
    }
}

/// Takes out of the motion what the energy has risen by in the tick, as far as joints have raised it.
void limitEnergy(Cluster& cluster, const TickContacts& found, double before) {
  const double risen = energyOf(cluster.step) - before - workOfAccelerations(cluster);
  const double excess = std::min(risen, workOfRecoveries(cluster, found));
  if (!(excess > 0.0)) return;
  const CommonMotion motion = commonMotion(cluster.step);
  const double free = kineticEnergy(cluster.step) - 0.5 * motion.mass * motion.mean.squaredNorm();
  if (free > excess) slowDown(cluster.step, motion.mean, std::sqrt(1.0 - excess / free));
}

// --- contacts that are searched for within the tick --------------------------------------------------------

/// Of the size of a surface's features: how far surfaces move against each other in one substep.
constexpr double kMostInSubstep = 0.1;

/// Searches and substeps that fine meshes may cost even where their features are passed quickly.
constexpr double kManySearches = 16.0, kManySubsteps = 64.0;

struct SearchContext {
  Cluster* cluster;
  const TickContacts* found;
  SurfaceSearch* search;
};

/// Takes a contact for one that has ended until it is found again.
void collectKnown(Cluster& cluster, std::uint32_t number, const TickContacts& found) {
  const SurfaceMeeting& m = *cluster.meetings[number].surfaces;
  cluster.known.clear();
  const auto begin = cluster.contacts.begin();
  for (auto it = std::lower_bound(begin, cluster.contacts.end(), m.first);
       it != cluster.contacts.end() && *it < m.end; ++it)
    cluster.known.emplace_back(found.sources[*it].key, static_cast<std::uint32_t>(it - begin));
  const std::size_t first = cluster.contacts.size() + cluster.rows.size();
  for (std::size_t i = 0; i < cluster.late.size(); ++i)
    if (cluster.late[i].meeting == number)
      cluster.known.emplace_back(cluster.late[i].source.key, static_cast<std::uint32_t>(first + i));
  std::sort(cluster.known.begin(), cluster.known.end());
  for (const auto& [key, i] : cluster.known) cluster.step.pairs.contacts[i].ended = true;
}

void putContact(Cluster& cluster, std::uint32_t meeting, const PairContact& contact,
                const ContactSource& source) {
  const auto it =
      std::lower_bound(cluster.known.begin(), cluster.known.end(), std::pair(source.key, std::uint32_t{0}));
  if (it == cluster.known.end() || it->first != source.key) {
    cluster.late.push_back({meeting, source});
    cluster.step.pairs.contacts.push_back(contact);
    return;
  }
  PairContact& known = cluster.step.pairs.contacts[it->second];
  const Bearing stopping = known.stopping, settling = known.settling;
  const TickImpulse impulse = known.impulse;
  known = contact;
  known.stopping = stopping, known.settling = settling, known.impulse = impulse;
}

void searchWithin(void* context, StepGroup& group, double since, double ahead) {
  auto& [cluster, found, search] = *static_cast<SearchContext*>(context);
  for (std::uint32_t number = 0; number < cluster->meetings.size(); ++number) {
    const ClusterMeeting& m = cluster->meetings[number];
    if (!m.moves()) continue;
    SidesWithin sides{&group.views[m.a], nullptr, nullptr, since / found->tick};
    if (m.surfaces->other)
      sides.b = &group.views[m.b];
    else if (!m.surfaces->held)
      sides.rigid = &group.links.rigids[m.b];
    findWithin(*m.surfaces, sides, ahead, found->tick, *search);
    collectKnown(*cluster, number, *found);
    for (std::size_t i = 0; i < search->pairs.size(); ++i) {
      PairContact& contact = search->pairs[i];
      contact.a.body = m.a;
      contact.b.body = m.b;
      putContact(*cluster, number, contact, search->sources[i]);
    }
  }
}

/// The longest ways, in sizes of features.
struct LongestWays {
  double all = 0.0;
  double ofContacts = 0.0;  ///< where contacts are foreseen: what is only near must not change the substeps
};

LongestWays longestWays(const Cluster& cluster) {
  LongestWays most;
  for (const ClusterMeeting& m : cluster.meetings) {
    most.all = std::max(most.all, m.way);
    if (m.surfaces->end > m.surfaces->first) most.ofContacts = std::max(most.ofContacts, m.way);
  }
  return most;
}

/// No more than any group's budget.
int substepsFor(const Cluster& cluster, double way) {
  int most = static_cast<int>(std::ceil(std::min(way / kMostInSubstep, kManySubsteps)));
  for (const TickGroup* group : cluster.groups)
    if (group->stepping.budget > 0) most = std::min(most, group->stepping.budget);
  return most;
}

/// Contacts found within the tick, too, are reported and remembered.
void handOverLate(Cluster& cluster, TickContacts& found) {
  const std::size_t first = cluster.contacts.size() + cluster.rows.size();
  for (std::size_t i = 0; i < cluster.late.size(); ++i) {
    PairContact contact = cluster.step.pairs.contacts[first + i];
    const SurfaceMeeting& meeting = *cluster.meetings[cluster.late[i].meeting].surfaces;
    contact.a.body = meeting.body->index;
    if (meeting.other) contact.b.body = meeting.other->index;
    if (meeting.partner) contact.b.body = found.find(*meeting.partner);
    found.add(contact, cluster.late[i].source);
  }
}

/// After the step: gives the rows of points what they bore.
void reportRows(Cluster& cluster) {
  for (std::size_t i = 0; i < cluster.rows.size(); ++i)
    cluster.rows[i]->impulse = cluster.step.pairs.contacts[cluster.contacts.size() + i].impulse;
}

void handOver(const PairContact& contact, PairContact& found) {
  const std::uint32_t a = found.a.body, b = found.b.body;
  found = contact;
  found.a.body = a, found.b.body = b;
}

/// Whether nothing but one soft body moves: it touches itself, or what is still.
bool isAlone(const Cluster& cluster) {
  const StepGroup& step = cluster.step;
  const LinkedBodies& links = step.links;
  if (step.bodies.size() != 1 || !links.rigids.empty() || !links.springs.empty() || !links.anchors.empty())
    return false;
  const auto isStill = [](const PairContact& c) { return c.b.velocity.isZero(0.0); };
  return std::all_of(step.pairs.contacts.begin(), step.pairs.contacts.end(), isStill) &&
         standsOnStill(*step.bodies[0].contacts);
}

}  // namespace

void stepCluster(Cluster& cluster, const TickContacts& found, double tick, SurfaceSearch& search) {
  for (TickGroup* group : cluster.groups) guardCluster(*group, isAlone(cluster));
  int substeps = 1;
  for (const TickGroup* group : cluster.groups) substeps = std::max(substeps, group->substeps);
  SearchContext context{&cluster, &found, &search};
  cluster.step.again = PairSearch();
  if (const LongestWays way = longestWays(cluster); way.all > kMostBetweenSearches) {
    if (way.ofContacts > kMostBetweenSearches) substeps = std::max(substeps, substepsFor(cluster, way.ofContacts));
    const double searches =
        std::min(way.all / kMostBetweenSearches, std::max(kManySearches, way.all / kMostInSubstep));
    cluster.step.again = {std::max(1, static_cast<int>(substeps / searches)), &context, searchWithin};
  }
  for (TickGroup* group : cluster.groups) group->substeps = substeps;
  spreadGuesses(cluster.step.pairs, substeps);
  cluster.step.pairs.tolerance = speedTolerance(cluster.step, tick);
  if (cluster.softBodies.empty()) recoverAsBullet(cluster.step.pairs, tick);
  const bool joined = !cluster.joints.empty();
  cluster.start.clear();
  if (joined) cluster.start = cluster.step.links.rigids;
  const double before = joined ? energyOf(cluster.step) : 0.0;
  stepVerlet(cluster.step, tick, substeps);
  if (joined) limitEnergy(cluster, found, before);
}

void handOverCluster(Cluster& cluster, TickContacts& found, btScalar tick) {
  const PairRows& pairs = cluster.step.pairs;
  for (std::size_t i = 0; i < cluster.contacts.size(); ++i)
    handOver(pairs.contacts[i], found.contacts[cluster.contacts[i]]);
  handOverLate(cluster, found);
  for (std::size_t i = 0; i < cluster.joints.size(); ++i)
    found.joints[cluster.joints[i]].impulse = pairs.joints[i].impulse;
  reportRows(cluster);
  giveBack(cluster);
  const std::size_t first = firstOwnRigid(cluster);
  for (std::size_t i = 0; i < cluster.rigids.size(); ++i)
    handOverRigid(found.rigids[cluster.rigids[i]], cluster.step.links.rigids[first + i], tick);
}

void takeBackCluster(const Cluster& cluster, TickContacts& found, const btCollisionWorld& world,
                     btScalar tick) {
  const std::size_t first = firstOwnRigid(cluster);
  for (std::size_t i = 0; i < cluster.rigids.size(); ++i)
    if (RigidPartner& rigid = found.rigids[cluster.rigids[i]]; isThere(world, rigid.mark))
      takeBackRigid(rigid, cluster.step.links.rigids[first + i], tick);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

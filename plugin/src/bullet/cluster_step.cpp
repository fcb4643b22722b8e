// SPDX-License-Identifier: Zlib
#include "bullet/cluster.h"
#include "bullet/cluster_rows.h"

#include <algorithm>

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

/// The index of the first of the cluster's rigid bodies that are in no group.
std::size_t firstOwnRigid(const Cluster& cluster) {
  return cluster.step.links.rigids.size() - cluster.rigids.size();
}

void giveBack(Cluster& cluster) {
  const StepGroup& step = cluster.step;
  std::size_t body = 0, rigid = 0, spring = 0;
  for (TickGroup* group : cluster.groups) {
    for (SteppedBody& stepped : group->step.bodies) stepped.errorRate = step.bodies[body++].errorRate;
    for (RigidState& state : group->step.links.rigids) state = step.links.rigids[rigid++];
    for (LinkSpring& link : group->step.links.springs) link.force = step.links.springs[spring++].force;
  }
}

}  // namespace

void stepCluster(Cluster& cluster, double tick) {
  int substeps = 1;
  for (const TickGroup* group : cluster.groups) substeps = std::max(substeps, group->substeps);
  for (TickGroup* group : cluster.groups) group->substeps = substeps;
  spreadGuesses(cluster.step.pairs, substeps);
  stepVerlet(cluster.step, tick, substeps);
}

void handOverCluster(Cluster& cluster, TickContacts& found, btScalar tick) {
  const PairRows& pairs = cluster.step.pairs;
  for (std::size_t i = 0; i < cluster.contacts.size(); ++i) {
    found.contacts[cluster.contacts[i]].impulse = pairs.contacts[i].impulse;
    found.contacts[cluster.contacts[i]].gap = pairs.contacts[i].gap;
  }
  for (std::size_t i = 0; i < cluster.joints.size(); ++i)
    found.joints[cluster.joints[i]].impulse = pairs.joints[i].impulse;
  reportRows(cluster);
  giveBack(cluster);
  const std::size_t first = firstOwnRigid(cluster);
  for (std::size_t i = 0; i < cluster.rigids.size(); ++i)
    handOverRigid(found.rigids[cluster.rigids[i]], cluster.step.links.rigids[first + i], tick);
}

void takeBackCluster(const Cluster& cluster, TickContacts& found, btScalar tick) {
  const std::size_t first = firstOwnRigid(cluster);
  for (std::size_t i = 0; i < cluster.rigids.size(); ++i)
    takeBackRigid(found.rigids[cluster.rigids[i]], cluster.step.links.rigids[first + i], tick);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

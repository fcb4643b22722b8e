// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/surface_gather.h"
#include "bullet/tick_contacts.h"
#include "bullet/tick_group.h"

#include <utility>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A meeting of members of a cluster.
struct ClusterMeeting {
  const SurfaceMeeting* surfaces = nullptr;
  std::uint32_t a = 0, b = 0;  ///< in step.bodies; b, if it is rigid, in step.links.rigids
  double way = 0.0;            ///< see wayOf()

  /// Too far in the tick for its contacts to stay what they are.
  bool moves() const { return way > kMostBetweenSearches; }
};

/// A contact found within the tick.
struct LateContact {
  std::uint32_t meeting = 0;
  ContactSource source;
};

/// Groups and rigid bodies that touch in a tick, stepped together in it.
struct Cluster {
  StepGroup step;  ///< bodies and links of its groups, one group after the other
  std::vector<TickGroup*> groups;
  std::vector<SoftBodyData*> softBodies;  ///< step.bodies[i] is softBodies[i]
  std::vector<std::uint32_t> rigids;      ///< numbers in TickContacts of those that are in no group; they are
                                          ///< the last of step.links.rigids
  std::vector<std::uint32_t> contacts;    ///< numbers in TickContacts, of the first step.pairs.contacts
  std::vector<ContactRow*> rows;          ///< of the other step.pairs.contacts
  std::vector<std::uint32_t> joints;      ///< numbers in TickContacts, of step.pairs.joints
  std::vector<RigidState> start;          ///< of step.links.rigids before the step, if there are joints
  std::vector<ClusterMeeting> meetings;
  std::vector<LateContact> late;  ///< the last of step.pairs.contacts
  std::vector<std::pair<std::uint64_t, std::uint32_t>> known;  ///< scratch: contacts of a meeting, by key
};

/// The clusters of a tick. Kept from tick to tick for its memory.
struct Clusters {
  std::vector<Cluster> all;
  std::size_t count = 0;  ///< of `all`, those of the present tick

  Cluster* begin() { return all.data(); }
  Cluster* end() { return all.data() + count; }

  // Scratch, by SoftBodyData::index.
  std::vector<std::uint32_t> groupOf, placeInGroup;
  // Scratch by node: groups, then rigid bodies.
  std::vector<std::uint32_t> parent;
  std::vector<std::uint32_t> cluster;  ///< of a root, the cluster
  std::vector<std::uint32_t> first;  ///< of a group, its first body in the cluster; of a rigid body, its own
};

/// Adds the rigid bodies that links join to awake groups to `found`, so that what they touch is looked for,
/// too. Call it before gatherRigidContacts().
void addLinkedRigids(const std::vector<TickGroup>& groups, TickContacts& found);

/// Puts together what contacts and joints couple, and tells groups that they are in a cluster
/// (TickGroup::clustered). Groups that nothing else moves with are in none.
void makeClusters(std::vector<TickGroup>& groups, TickContacts& found, btScalar tick, Clusters& clusters);

/// Steps a cluster by velocity Verlet, as finely as its most demanding group asks for. Contacts of surfaces
/// that move far against each other in the tick are searched for again within it. Joints that take errors back
/// against what pulls at them may not raise its energy by that.
void stepCluster(Cluster& cluster, const TickContacts& found, double tick, SurfaceSearch& search);

/// After the step: gives the groups their bodies' states back, and `found` what its contacts bore; hands the
/// rigid bodies that are in no group over to Bullet.
void handOverCluster(Cluster& cluster, TickContacts& found, btScalar tick);

/// After Bullet's part of the tick, see takeBackRigid(); of rigid bodies that are still in the world.
void takeBackCluster(const Cluster& cluster, TickContacts& found, const btCollisionWorld& world,
                     btScalar tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// Springs and anchors join bodies into groups; contacts in a tick join groups and rigid bodies into clusters.
// This header declares how both are made, stepped, put to sleep and woken.

#pragma once

#include "bullet/soft_body_data.h"
#include "bullet/surface_gather.h"
#include "bullet/tick_contacts.h"
#include "solver/simd_steps.h"
#include "solver/verlet_step.h"

#include <limber/spring_constraint.h>

#include <memory>
#include <utility>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- groups ------------------------------------------------------------------------------------------------

/// Soft and rigid bodies that springs and anchors join: stepped, put to sleep and woken together. A soft body
/// that nothing is joined to is a group of its own.
struct LinkedGroup {
  SolverIsland step;
  std::vector<SoftBodyData*> bodies;       ///< step.bodies[i] is bodies[i]
  std::vector<RigidPartner> rigids;        ///< step.links.rigids[i] is rigids[i]
  std::vector<SpringConstraint*> springs;  ///< step.links.springs[i] is springs[i]
  double calmTime = 0.0;  ///< s for which nothing in it has moved faster than it may in sleep
  bool asleep = false;
  bool inIsland = false;  ///< in this tick it is stepped together with what it touches
  Stepping stepping;      ///< the strictest of its bodies' choices
  int substeps = 0;
  bool cut = false;  ///< the budget allows fewer than it needs
  Stepper stepper = Stepper::Verlet;
  bool guarded = false;      ///< its energy must not rise in this tick if a push is held back in it
  bool heldBack = false;     ///< that is so at the start of the tick
  bool lasting = false;      ///< nor beyond what it was in the first of such ticks
  double energyBound = 0.0;  ///< J, if it is guarded
  double energyAtEnd = 0.0;  ///< J, of the last tick, if it is guarded
};

using SpringList = std::vector<std::unique_ptr<SpringConstraint>>;

/// The groups of these bodies and springs, in the order of their first bodies, then of their first springs.
/// A group is asleep if all its bodies are.
std::vector<LinkedGroup> makeLinkedGroups(const std::vector<SoftBodyData*>& bodies,
                                          const std::vector<SpringConstraint*>& springs);

/// False once a point mass of the group has left the world: the groups must be made anew.
bool isWhole(const LinkedGroup& group);

/// Looks up which springs and anchors have both ends in the world, and which of these ends are static.
/// Returns whether this is not what `links` says, which is then brought up to date: the groups must be made
/// anew.
bool updateUsableLinks(const std::vector<SoftBodyData*>& bodies,
                       const std::vector<SpringConstraint*>& springs, std::vector<unsigned char>& links);

/// The stages of a tick, see body_in_world.h. What a body may touch depends on where all of them are.
void gatherBodies(LinkedGroup& group, btScalar tick);
void gatherGroup(LinkedGroup& group, btScalar tick);
void writeGroupToBullet(LinkedGroup& group, btScalar tick);
void readGroupFromBullet(LinkedGroup& group, btScalar tick);

// --- sleep -------------------------------------------------------------------------------------------------

/// Puts whole groups to sleep and wakes them, by Bullet's own rules (gDeactivationTime, gDisableDeactivation,
/// each body's sleeping threshold, DISABLE_DEACTIVATION).
///
/// Bullet sees no link between the points of a body: left alone it would freeze them one by one. So awake
/// points have their deactivation timer held at 0, and a group goes to sleep in one tick, when all its
/// members have been calm for gDeactivationTime and nothing awake is in contact with any of them.
/// `bulletIslands` is scratch.
void updateSleep(std::vector<LinkedGroup>& groups, btDiscreteDynamicsWorld& world, btScalar tick,
                 std::vector<unsigned char>& bulletIslands);

// --- stepping ----------------------------------------------------------------------------------------------

/// Before the step: sets the group's stepper and substeps for this tick.
void chooseStepping(LinkedGroup& group, double tick);

/// Before the step of a cluster that is this group and nothing else that moves by itself or as told, with a
/// budget that leaves its oscillations next to unresolved: its energy must not rise while it is so. With
/// false: of any other cluster.
void guardIsland(LinkedGroup& group, bool alone);

/// Whether what bears points by these rows does not move.
bool standsOnStill(const std::vector<PlaneContact>& rows);

/// After the step: what the bodies tell of it.
void reportStepping(LinkedGroup& group, double tick);

/// Which bodies are stepped side by side: those of one network that take equally many substeps of Verlet.
/// Kept from tick to tick, so that a lane whose body stays the same need not copy its springs again.
class StepPlan {
 public:
  /// Steps all groups that are awake and in no cluster. Order and result do not depend on how they are put
  /// together.
  void step(std::vector<LinkedGroup>& groups, double tick);

  /// Forgets the bodies: the groups have been made anew.
  void clear();

 private:
  struct Candidate {
    std::size_t network;  ///< number of the body's network in order of first appearance
    int substeps;
    bool damped;
    int volumes;  ///< 0: no volume term, -1: of a body whose scale mirrors it, else 1
    std::size_t group;
    bool fitsWith(const Candidate& other) const;
    bool operator<(const Candidate& other) const;
  };

  void number(const std::vector<LinkedGroup>& groups);
  /// Steps the groups that do not fit into lanes and sorts the others into candidates_.
  void stepOrCollect(std::vector<LinkedGroup>& groups, double tick);
  void stepRun(std::vector<LinkedGroup>& groups, std::size_t begin, std::size_t end, double tick);
  void stepBlock(std::vector<LinkedGroup>& groups, std::size_t begin, std::size_t end, double tick);

  SharedFactors factors_;
  InstructionSet set_ = bestInstructionSet();
  std::vector<std::size_t> networkOf_;  ///< #groups
  std::vector<Candidate> candidates_;
  std::vector<LaneBlock> blocks_;
  LaneScratch scratch_;
  std::size_t blocksUsed_ = 0;
};

// --- clusters ----------------------------------------------------------------------------------------------

/// A meeting of members of a cluster.
struct IslandPair {
  const SurfaceCandidate* surfaces = nullptr;
  std::uint32_t a = 0, b = 0;  ///< in step.bodies; b, if it is rigid, in step.links.rigids
  double displacement = 0.0;   ///< see displacementOf()

  /// Too far in the tick for its contacts to stay what they are.
  bool moves() const { return displacement > kMaxBetweenSearches; }
};

/// A contact found within the tick.
struct LateContact {
  std::uint32_t candidate = 0;
  ContactSource source;
};

/// Groups and rigid bodies that touch in a tick, stepped together in it.
struct Island {
  SolverIsland step;  ///< bodies and links of its groups, one group after the other
  std::vector<LinkedGroup*> groups;
  std::vector<SoftBodyData*> softBodies;  ///< step.bodies[i] is softBodies[i]
  std::vector<std::uint32_t> rigids;      ///< numbers in TickContacts of those that are in no group; they are
                                          ///< the last of step.links.rigids
  std::vector<std::uint32_t> contacts;    ///< numbers in TickContacts, of the first step.pairs.contacts
  std::vector<PlaneContact*> rows;        ///< of the other step.pairs.contacts
  std::vector<std::uint32_t> joints;      ///< numbers in TickContacts, of step.pairs.joints
  std::vector<RigidState> start;          ///< of step.links.rigids before the step, if there are joints
  std::vector<IslandPair> candidates;
  std::vector<LateContact> late;                               ///< the last of step.pairs.contacts
  std::vector<std::pair<std::uint64_t, std::uint32_t>> known;  ///< scratch: contacts of a meeting, by key
};

/// The clusters of a tick. Kept from tick to tick for its memory.
struct Islands {
  std::vector<Island> all;
  std::size_t count = 0;  ///< of `all`, those of the present tick

  Island* begin() { return all.data(); }
  Island* end() { return all.data() + count; }

  // Scratch, by SoftBodyData::index.
  std::vector<std::uint32_t> groupOf, indexInGroup;
  // Scratch by node: groups, then rigid bodies.
  std::vector<std::uint32_t> parent;
  std::vector<std::uint32_t> island;  ///< of a root, the cluster
  std::vector<std::uint32_t> first;   ///< of a group, its first body in the cluster; of a rigid body, its own
};

/// Adds the rigid bodies that links join to awake groups to `found`, so that what they touch is looked for,
/// too. Call it before gatherRigidContacts().
void addLinkedRigids(const std::vector<LinkedGroup>& groups, TickContacts& found);

/// Puts together what contacts and joints couple, and tells groups that they are in a cluster
/// (LinkedGroup::clustered). Groups that nothing else moves with are in none.
void makeIslands(std::vector<LinkedGroup>& groups, TickContacts& found, btScalar tick, Islands& islands);

/// Steps a cluster by velocity Verlet, as finely as its most demanding group asks for. Contacts of surfaces
/// that move far against each other in the tick are searched for again within it. Joints that take errors
/// back against what pulls at them may not raise its energy by that.
void stepIsland(Island& island, const TickContacts& found, double tick, SurfaceSearch& search);

/// After the step: gives the groups their bodies' states back, and `found` the impulses of its contacts;
/// writes the rigid bodies that are in no group to Bullet.
void writeIslandToBullet(Island& island, TickContacts& found, btScalar tick);

/// After Bullet's part of the tick, see readRigidFromBullet(); of rigid bodies that are still in the world.
void readIslandFromBullet(const Island& island, TickContacts& found, const btCollisionWorld& world,
                          btScalar tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

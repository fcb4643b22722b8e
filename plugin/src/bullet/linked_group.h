// SPDX-License-Identifier: Zlib

// Springs and anchors join bodies into linked groups. Contacts in a tick join groups and rigid bodies into
// islands. This header declares how groups and islands are made, stepped, put to sleep and woken.

#pragma once

#include "bullet/kinematic_motion.h"
#include "bullet/surface_gather.h"

#include <limber/soft_body_system.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- groups ------------------------------------------------------------------------------------------------

/// Soft and rigid bodies that are joined by springs and anchors. They are stepped, put to sleep and woken
/// together. A soft body without springs or anchors to other bodies is a group of its own.
struct LinkedGroup {
  SolverIsland step;
  std::vector<SoftBodyData*> bodies;       ///< step.bodies[i] is bodies[i]
  std::vector<RigidPartner> rigids;        ///< step.links.rigids[i] is rigids[i]
  std::vector<SpringConstraint*> springs;  ///< step.links.springs[i] is springs[i]
  std::size_t model = 0;                   ///< number of the first body's model, in order of first appearance
  double calmTime = 0.0;        ///< s, time for which all motion has been below the sleeping thresholds
  bool hasWorldPoints = false;  ///< a body has its point masses in the world (Collision::Points)
  bool asleep = false;
  bool inIsland = false;  ///< in this tick it is stepped together with the bodies that it touches
  Stepping stepping;      ///< the strictest settings of its bodies
  double resolved = 0.0;  ///< rad^2/s^2, what its budget resolves in the longest tick so far; 0: no budget
  int substeps = 0;
  bool cut = false;  ///< maxSubsteps allows fewer substeps than it needs
  Stepper stepper = Stepper::Verlet;
};

/// The groups that are awake in a tick, in the order of all groups.
using AwakeGroups = std::vector<LinkedGroup*>;

using SpringList = std::vector<std::unique_ptr<SpringConstraint>>;

/// Returns the groups of these bodies and springs, in the order of their first bodies, then of their first
/// springs. A group is asleep if all its bodies are asleep.
std::vector<LinkedGroup> makeLinkedGroups(const btCollisionWorld& world,
                                          const std::vector<SoftBodyData*>& bodies,
                                          const std::vector<SpringConstraint*>& springs);

/// Puts a link's end in the world where the user has moved it, at once or, with a target, over the tick (s).
void placeEnds(LinkSpring& link, const SpringConstraint& spring, double tick);

/// Sets the stiffness of a link to a share of its settings.
void setStiffness(LinkSpring& link, const SpringConstraint& spring, double share);

/// Lets the bodies be stepped four springs at a time where the machine can. Bodies in lanes need no memory
/// for it.
void useSpringBatches(LinkedGroup& group);

/// Returns false if a point mass of the group has left the world. The groups must then be made again.
bool isWhole(const LinkedGroup& group);

/// Finds which springs and anchors have both ends in the world, and which of these ends are static. Writes
/// the result to `links` and returns whether `links` has changed. The groups must then be made again.
bool updateUsableLinks(const btCollisionWorld& world, const std::vector<SoftBodyData*>& bodies,
                       const std::vector<SpringConstraint*>& springs, std::vector<unsigned char>& links);

// The stages of a tick, see body_in_world.h. gatherBodies() comes first for all groups, because the contacts
// of a body depend on the positions of all bodies. Groups are independent in all of these stages but in
// updateBroadphaseBoxes(), and in readGroupFromBullet() if they have world points: Bullet's broadphase and
// its sweeps are for one thread.

void gatherBodies(LinkedGroup& group, btScalar tick);
void surroundBodies(LinkedGroup& group, btScalar tick);         ///< after fields
bool updateBroadphaseBoxes(LinkedGroup& group, btScalar tick);  ///< returns whether any has changed
void gatherGroup(LinkedGroup& group, btScalar tick);
void readGroupFromBullet(LinkedGroup& group, btScalar tick);

// --- sleep -------------------------------------------------------------------------------------------------

/// A box (m) around the motion of an object in the coming tick.
struct SleepBox {
  Eigen::AlignedBox3d box;
  const btCollisionObject* object;  ///< the surface of a soft body; nullptr if it has none
  SoftBodyData* body;               ///< nullptr: not a soft body
  LinkedGroup* group;               ///< of the soft body
};

struct SleepScratch {
  std::vector<unsigned char> islands;  ///< Bullet's islands of the last tick, by tag: 1 with awake bodies
  std::vector<SleepBox> awake, quiet;  ///< `quiet`: of groups that sleep or want to, sorted by the lowest x
  double widest = 0.0;                 ///< m along x, of `quiet`
  std::vector<const btRigidBody*> partners;       ///< rigid members of groups, sorted
  std::vector<const btRigidBody*> calm;           ///< rigid bodies in no group that want to sleep
  std::vector<const btCollisionObject*> holders;  ///< kinematic objects that move, sorted
  btScalar lastTick = 0;                          ///< s; 0: there was none
};

/// Puts whole groups to sleep and wakes them, by Bullet's own rules (gDeactivationTime, gDisableDeactivation,
/// each body's sleeping threshold, DISABLE_DEACTIVATION).
///
/// Bullet has no link between the points of a body and would put them to sleep one by one. So the
/// deactivation timer of awake points stays at 0. A group goes to sleep in one tick, when all its members
/// have been calm for gDeactivationTime and no awake body may touch any of them in the coming tick. It wakes
/// when one may, or a kinematic object that is awake or moves, or when one that moves holds a member by a
/// spring or anchor. A group whose members all are ISLAND_SLEEPING by the user's will sleeps at once. Returns
/// the groups that are awake.
void updateSleep(std::vector<LinkedGroup>& groups, btDiscreteDynamicsWorld& world,
                 const MovingObjects& objects, const KinematicMotions& kinematic, btScalar tick,
                 SleepScratch& scratch, AwakeGroups& awake);

// --- stepping ----------------------------------------------------------------------------------------------

std::size_t springCount(const std::vector<SoftBodyData*>& bodies);

/// Number of springs that must be computed in a tick.
double workOf(const LinkedGroup& group);

/// Share of the work of a tick that no thread should have alone: with less, others have as much to do.
constexpr double kLargeShare = 1.0 / 6.0;

/// Gives the body the constants whose fastest oscillation, with these inverse masses (3 x #points, 1/kg), is
/// at most `largest` (rad^2/s^2); 0: its full stiffness.
void softenTo(SoftBodyData& body, double largest, const Points& inverseMass);

/// Softens bodies and links for this tick so that maxSubsteps resolve them. Call it before islands are made,
/// which have copies of the links.
void keepBudget(LinkedGroup& group, double tick);

/// Sets the group's stepper and substeps for this tick, before the step.
void chooseStepping(LinkedGroup& group, double tick);

/// Starts the energy limit of a group in an island, before the step. `alone`: nothing but one soft body moves
/// in the island, neither dynamic nor kinematic. If it also bounces (`bouncing`: in contacts of the island),
/// or has a maximum of substeps, either of which may leave its oscillations hardly resolved, its energy must
/// not rise as long as that is so. `joined`: the island has joints, whose limit needs the work of drag.
void limitIslandEnergy(LinkedGroup& group, bool alone, bool bouncing, bool joined);

bool areSurfacesAtRest(const std::vector<PlaneContact>& rows);

/// Whether a body of the group has an error tolerance. A tick may then be stepped again.
bool hasTolerance(const LinkedGroup& group);

/// Steps a group that is in no island.
void stepAlone(LinkedGroup& group, double tick, SharedFactors& factors);

/// Steps a group that is in no island again, with its watches on (point_contacts.h), if a point has left its
/// search region and may have missed a contact.
void repeatIfMissed(LinkedGroup& group, double tick, SharedFactors& factors);

/// Updates the stepping results of the bodies, after the step.
void reportStepping(LinkedGroup& group, double tick);

/// Measures the stages of a tick, one after the other.
class LapTimer {
 public:
  /// Returns the milliseconds since the last call, or since the timer was made.
  double lap() {
    const Clock::time_point begin = begin_;
    begin_ = Clock::now();
    return std::chrono::duration<double, std::milli>(begin_ - begin).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point begin_ = Clock::now();
};

/// Steps the groups that are in no island. Bodies of one model with the same number of Verlet substeps are
/// stepped together in SIMD lanes.
class LoneGroups {
 public:
  /// Chooses the steppers of all groups that are in no island, steps these groups and writes them to Bullet.
  /// Does the three in blocks of groups, whose data stay in the processor's cache. The results do not depend
  /// on the blocks, nor on which bodies share lanes. Adds times and work to `profile`.
  void step(const AwakeGroups& groups, double tick, const Parallel& parallel, TickProfile& profile);

 private:
  struct Block {
    AwakeGroups groups;
    std::size_t forLanes = 0;       ///< number of the first groups, which can share lanes
    std::vector<std::size_t> runs;  ///< #runs + 1, begins in `groups`
    std::vector<SolverBody*> bodies;
    LaneScratch lanes;
    TickProfile work;
  };

  void collect(const AwakeGroups& groups);
  /// Moves the groups that a team steps out of `lone_`.
  void takeLarge();
  void stepLarge(double tick, const Parallel& parallel, TickProfile& profile);
  /// Sorts `lone_` by model and splits it into blocks.
  void makeBlocks();
  void stepBlock(Block& block, double tick);
  /// Splits a block into runs of bodies that are stepped together.
  void makeRuns(Block& block) const;
  void stepRun(Block& block, std::size_t run, double tick);

  SharedFactors factors_;
  InstructionSet set_ = bestInstructionSet();
  AwakeGroups lone_;
  AwakeGroups large_;
  std::vector<std::size_t> blocks_;  ///< #blocks + 1, begins in lone_
  ScratchPool<Block> scratch_;
  std::mutex lock_;  ///< of `sum_`
  TickProfile sum_;  ///< of the blocks
};

/// Reports what the step of a group was, and writes it to Bullet.
void writeGroup(LinkedGroup& group, btScalar tick, TickProfile& work);

// --- islands -----------------------------------------------------------------------------------------------

/// A pair of members of an island whose surfaces touch or may touch.
struct IslandPair {
  static constexpr std::uint32_t kNone = 0xffffffffu;

  const SurfaceCandidate* surfaces = nullptr;
  std::uint32_t a = 0, b = 0;  ///< indices in step.bodies; for a rigid b, in step.links.rigids
  double displacement = 0.0, searchDistance = 0.0;  ///< see displacementOf(), searchDistanceOf()
  double releases = 0.0;                            ///< 1/s, see releasesOf()

  /// Whether the surfaces move too far in the tick for their contacts to remain valid.
  bool needsNewSearch() const { return displacement > searchDistance; }

  SurfaceMotion held;  ///< of side b, if it is static or kinematic

  // Written by planSearches() and the searches within the step.
  MotionFrame frame = MotionFrame::Still;  ///< of the next one
  RelativeMotion known;                    ///< of side a to side b at the last search
  double moved = 0.0;        ///< since the last search, as a share of the motion after which one is due
  double moving = 0.0;       ///< until the next round of searches, likewise
  std::uint32_t period = 0;  ///< rounds until the next search, a power of 2; 0: it is not due now
  std::uint32_t firstLate = kNone, lastLate = kNone;  ///< of its contacts in Island::late
};

/// A contact found during the step.
struct LateContact {
  std::uint32_t candidate = 0;
  ContactSource source;
  std::uint32_t next = IslandPair::kNone;  ///< of the same candidate
};

/// Groups and rigid bodies that touch in a tick. They are stepped together in it.
struct Island {
  SolverIsland step;  ///< bodies and links of its groups, one group after the other
  std::vector<LinkedGroup*> groups;
  std::vector<SoftBodyData*> softBodies;  ///< step.bodies[i] is softBodies[i]
  std::vector<std::uint32_t> rigids;    ///< indices in TickContacts of the rigid bodies that are in no group;
                                        ///< they are the last of step.links.rigids
  std::vector<std::uint32_t> contacts;  ///< indices in TickContacts of the first step.pairs.contacts
  std::vector<PlaneContact*> rows;      ///< of the next step.pairs.contacts
  std::vector<std::uint32_t> joints;    ///< indices in TickContacts of step.pairs.joints
  std::vector<RigidState> start;        ///< step.links.rigids before the step, if there are joints
  std::vector<unsigned char> joined;    ///< step.bodies, then step.links.rigids: 1 if the body, or one that
                                        ///< springs or anchors link to it, has a joint
  LinkedBodies mean;                    ///< scratch, see offerToJoints()
  std::vector<IslandPair> candidates;
  std::vector<LateContact> late;                                     ///< of the last step.pairs.contacts
  std::vector<std::pair<std::uint64_t, std::uint32_t>> oldContacts;  ///< scratch: of one pair, sorted by key
  std::vector<std::pair<std::uint64_t, std::uint32_t>>
      endedContacts;                    ///< scratch: indices of those that have ended, sorted by their points
  std::vector<SurfaceMotion> motions;   ///< #softBodies, scratch of a search in the step
  std::vector<std::uint32_t> searched;  ///< numbers of the candidates that it searches
  std::vector<std::uint32_t> moved;     ///< numbers of their soft bodies
  std::vector<ContactsInStep> inStep;   ///< #searched or more
};

/// The islands of a tick. The object is kept from tick to tick to reuse its memory.
struct Islands {
  std::vector<Island> all;
  std::size_t count = 0;  ///< number of islands of the present tick, the first of `all`

  Island* begin() { return all.data(); }
  Island* end() { return all.data() + count; }

  std::vector<std::uint32_t> large, small;  ///< scratch: numbers of islands

  // Scratch, indexed by SoftBodyData::index.
  std::vector<std::uint32_t> groupOf, indexInGroup;
  // Scratch, indexed by node: first the groups, then the rigid bodies.
  DisjointSets sets;
  std::vector<std::uint32_t> island;  ///< index of the island of a root
  std::vector<std::uint32_t> first;   ///< index in the island of a group's first body, or of the rigid body
};

/// Adds the rigid bodies that links join to the groups to `found`, so that their contacts are found, too.
/// Call it before gatherRigidContacts().
void addLinkedRigids(const AwakeGroups& groups, TickContacts& found);

/// Makes the islands of groups and rigid bodies that contacts and joints couple, and sets
/// LinkedGroup::inIsland. A group that is coupled to no other moving body is in no island.
void makeIslands(const AwakeGroups& groups, TickContacts& found, btScalar tick, Islands& islands);

/// Sets SoftBodyData::island of bodies that are stepped together to their smallest index.
void numberIsland(const std::vector<SoftBodyData*>& bodies);

/// What a search within the step of an island uses.
struct SearchContext {
  Island* island;
  const TickContacts* found;
  ScratchPool<SurfaceSearch>* searches;
  std::mutex* lock;  ///< see stepIslands()
};

/// Returns the motion of a static or kinematic part in a tick, at whose start it is.
SurfaceMotion heldMotion(const RigidPart& part, double tick);

/// Decides how often the contacts of an island are searched for within its step, and sets island.step.again,
/// which uses `context`. Returns the number of substeps: `substeps`, or more if surfaces that touch would
/// move too far in one of them.
int planSearches(SearchContext& context, int substeps);

/// Steps the islands by velocity Verlet, each with the largest number of substeps that one of its groups
/// needs. Contacts of surfaces with a large relative displacement are searched for again during the tick. The
/// error correction of joints must not raise an island's energy. A large island is stepped by all threads
/// together, the others at the same time. `lock` is SoftBodyData::worldLock.
void stepIslands(Islands& islands, const TickContacts& found, double tick,
                 ScratchPool<SurfaceSearch>& searches, std::mutex& lock, const Parallel& parallel);

/// Copies the states of the bodies to their groups and the impulses of the contacts to `found`, after the
/// step. Writes the rigid bodies that are in no group to Bullet.
void writeIslandToBullet(Island& island, TickContacts& found, btScalar tick);

/// Reads the rigid bodies that are in no group and still in the world, after Bullet's part of the tick. See
/// readRigidFromBullet().
void readIslandFromBullet(const Island& island, TickContacts& found, const btCollisionWorld& world,
                          btScalar tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

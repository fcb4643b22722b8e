// SPDX-License-Identifier: Zlib

// This header defines the data of a soft body, from its network to its contacts. The Bullet objects of a body
// are in point_masses.h and surface_body.h. "Held" objects and points are static or kinematic.

#pragma once

#include "bullet/body_medium.h"
#include "bullet/point_masses.h"
#include "bullet/rigid_shapes.h"
#include "bullet/surface_body.h"
#include "collide/surface_contacts.h"
#include "solver/implicit_step.h"
#include "solver/simd_steps.h"
#include "solver/stepping_choice.h"

#include <limber/contact_filter.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

class MultiBodyLinks;
class ReportedManifold;
class SharedModels;

// --- contacts ----------------------------------------------------------------------------------------------

/// A point mass that moves with a rigid body.
struct Anchor {
  std::uint32_t point;
  btRigidBody* body;
  btVector3 pivot;                       ///< in the body's local coordinates
  double breakForce = 0.0;               ///< N; 0: never
  btVector3 force = btVector3(0, 0, 0);  ///< N on the point, mean of the last tick
  /// Sorted, the points around it, and it, that were inside the body when it was attached; may be null.
  std::shared_ptr<const std::vector<std::uint32_t>> inside{};
};

/// The impulse of a contact in the last tick, for the warm start of the next one.
struct StoredImpulse {
  int partner;                      ///< broadphase id, which the broadphase may later give to another object
  const btCollisionObject* object;  ///< the partner that had the id
  std::uint64_t key;                ///< of the features in contact
  ContactImpulse impulse;           ///< sum over the tick
};

/// An object that touched the body when the listener was last called.
struct TouchingPair {
  ObjectHandle other;
  SoftBody* otherBody;
};

/// m/s, speeds of a body's contacts. They scale with the scene's units of length, mass and time.
struct ContactSpeeds {
  double recovery = 0.0;  ///< maximum speed at which an overlap is corrected
  double bounce = 0.0;    ///< minimum approach speed of a bounce
};

/// A ContactWatch that is started in each tick.
struct SearchWatch : ContactWatch {
  virtual void start(btScalar tick) = 0;

  /// Sets the ball in which the contacts of point i are known.
  virtual void setRegion(std::uint32_t i, const Eigen::Vector3d& center, double distance) = 0;
};

/// The contacts of a body in the last tick in which it was awake.
struct ContactReport {
  std::vector<SoftContact> contacts;   ///< first the plane contacts, sorted by point, then other contacts
                                       ///< found by this plugin, then those found by Bullet
  std::vector<ObjectHandle> partners;  ///< #contacts, of SoftContact::other
  std::size_t planeCount = 0;          ///< number of plane contacts: points on held objects
  std::size_t ownCount = 0;            ///< number of contacts found by this plugin, planeCount included
  bool fresh = false;                  ///< from the last tick
  bool hasTriangles = false;           ///< ContactSide::triangle is up to date
};

// --- a body with a surface ---------------------------------------------------------------------------------

/// The last contact plane of a point on a static or kinematic convex body, in that body's coordinates.
struct CachedContact {
  std::uint64_t partner = 0;  ///< stamp of the body, see stampOf(); 0: none
  btVector3 surface = btVector3(0, 0, 0), normal = btVector3(0, 0, 0);
  btVector3 position = btVector3(0, 0, 0);  ///< of the point's centre when the contact was found
};

/// The region that a body may reach in a tick if nothing stops it, see sweptBoundsOf().
struct SweptBounds {
  Eigen::AlignedBox3d box;                                 ///< m
  double maxDisplacement = 0.0;                            ///< m, of any point
  double tick = 0.0;                                       ///< s, length of that tick; 0: unknown
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  ///< m, of the body as a whole
};

/// A static or kinematic object near a body in the present tick.
struct HeldPartner {
  ObjectHandle handle;
  Eigen::AlignedBox3d box;  ///< m
  std::uint64_t stamp = 0;  ///< see stampOf(); 0 if the object is at rest
  bool came = true;         ///< it was not near in the last tick, or elsewhere, or of another size
  const btCollisionObject& object() const { return *handle.object; }

  static constexpr std::size_t kNoSolid = static_cast<std::size_t>(-1);
  std::size_t solid = kNoSolid;  ///< index in SoftBodyData::held of its only piece, if it is
                                 ///< one convex solid at rest
  /// Unit, the shortest way out of a solid into which the body has been placed; 0: there is no such overlap.
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  double end = 0.0;  ///< m, of the solid along `out`
};

/// What a body knows of an object that was near in the last tick. Later its memory is reused.
struct CachedSearch {
  const btCollisionObject* partner = nullptr;  ///< nullptr: none
  int id = 0;                                  ///< of the partner in the broadphase, which may reuse it
  std::uint64_t part = 0;                      ///< of the partner's shape
  bool used = false;                           ///< in the present tick
  ContactCache cache;                          ///< of the last search
  std::unique_ptr<ConcavePatch> patch;         ///< of a concave partner
};

/// The last state that this plugin wrote to a surface object, see surface_rigid.cpp.
struct LeftObject {
  btTransform pose = btTransform::getIdentity();
  btVector3 velocity = btVector3(0, 0, 0), spin = btVector3(0, 0, 0);
};

/// The additional data of a body with Collision::Surface.
struct SurfaceData {
  SurfaceObject* object = nullptr;  ///< nullptr: Collision::Points, or the application has deleted it
  std::unique_ptr<SurfaceShape> shape;
  LeftObject left;
  Eigen::Quaterniond frame = Eigen::Quaterniond::Identity();  ///< the object's basis, rotates with the body;
                                                              ///< see followRotation()
  Eigen::Vector3d objectForce = Eigen::Vector3d::Zero();      ///< N, on the object in this stepSimulation()
  Eigen::Vector3d objectTorque = Eigen::Vector3d::Zero();     ///< N m
  bool pushed = false;  ///< the user has applied a force or torque to the object before
  btVector3 gravity;    ///< m/s^2, gravity of the world that was last given to the points
  Points force;         ///< 3 x #points, N, in this stepSimulation(); empty until exposed or first used
  Points newForce;      ///< 3 x #points, N, since the last tick, see addForce(); empty until first used
  bool hasNewForce = false;
  std::vector<CachedContact> contacts;  ///< #points; empty until a kinematic object is touched
  SweptBounds sweptBounds;              ///< predicted for the coming tick; Bullet's broadphase has its box
  SweptBounds presentBounds;            ///< of the present tick, if awake: they depend on the state alone
  std::vector<btCollisionObject*> partners;  ///< of the coming tick, see collectPartners()

  bool freed = false;        ///< since the last tick, something that held points has let go of them
  double freedMotion = 0.0;  ///< m in the tick, by which the springs may throw points after that
  Points motion;             ///< 3 x #points, m, predicted displacement in the tick
  Points positionInStep;     ///< 3 x #points, m, current positions during a step
  SurfaceBoxes boxes;
  MovingSurface moving;                ///< a view of the above
  double impact = 0.0;                 ///< m in the tick, into static and kinematic objects that stop it, and
                                       ///< `freedMotion`
  double release = 0.0;                ///< m/s^2, the largest with which springs push a point into a contact
  Eigen::AlignedBox3d motions;         ///< m in the tick, see addStoppedPairs(); empty before
  bool motionValid = false;            ///< `motion` and `impact` are those of this tick
  bool boxesValid = false;             ///< `boxes` are those of this tick
  std::vector<CachedSearch> searches;  ///< with the objects that were near in the last tick

  /// Ticks in which the body is tested for overlaps with others of any depth: some after it has been placed
  /// or scaled, and as long as there are any.
  int overlapTicks = kOverlapTicks;
  static constexpr int kOverlapTicks = 2;
};

// --- a body ------------------------------------------------------------------------------------------------

/// The constants that all bodies of one network with the same scale and material share. Immutable.
struct BodyModel {
  SharedNetwork network;
  std::vector<double> masses;  ///< #points, kg
  SpringArrays springs;        ///< a body starts with copies of the three, which share their constants
  VolumeArrays volumes;
  TetrahedronVolumes tetrahedra;
  SurfaceTopology topology;  ///< of the points and triangles; springs of ropes; empty: Collision::Points
  RestShape rest;
  WettedParts parts;
  double fastestAtRest = 0.0;  ///< rad^2/s^2, fastestOscillationSquared for the masses of the settings
  bool narrow = false;         ///< see SteppingProblem
  bool cheapNewton = false;    ///< see SteppingProblem
  std::shared_ptr<SharedSoftening> softening = std::make_shared<SharedSoftening>();
};

/// Rates of a body's internal motion.
struct MotionRates {
  double boundSquared = 0.0, fastestSquared = 0.0;  ///< rad^2/s^2, see Frequencies
  double turnRate = 0.0;                            ///< rad/s, fastestTurn
};

/// The largest rates of the present and the previous time span, see largestRecentRates() in group_step.cpp.
struct RateHistory {
  MotionRates now, before;
  double age = 0.0;  ///< s since the present span began
};

/// The limit of the energy of a body that is stepped alone, see startEnergyLimit() in group_step.cpp.
struct EnergyLimit {
  bool on = false;           ///< the energy must not rise in this tick
  bool persists = false;     ///< the energy must not exceed that of the first tick with this flag either
  bool forceScaled = false;  ///< the volume force was scaled down at the start of the tick
  double bound = 0.0;        ///< J, if on
  double atEnd = 0.0;        ///< J, at the end of the last tick, if on
  double tick = 0.0;         ///< s, length of the last tick; 0: there was none
  double unsteady = 0.0;     ///< s, time for which the last change of the tick's length still counts
};

/// What a body remembers of its motion. Saved states have it.
struct MotionMemory {
  double calmTime = 0.0;  ///< s, see LinkedGroup::calmTime
  double resolved = 0.0;  ///< rad^2/s^2, LinkedGroup::resolved, which ends with the group
  int resolvedBy = 0;     ///< the maximum of substeps that resolved it
  RateHistory rateHistory;
  EnergyLimit energyLimit;
  int substeps = 0;                   ///< in the last tick
  Stepper stepper = Stepper::Verlet;  ///< in the last tick
  double errorPerSecond = 0.0;        ///< m/s
  double errorCoefficient = 0.0;      ///< m/s^3, see SteppingProblem
  bool prefersImplicit = false;       ///< in the last tick, if it were in no island
  std::uint32_t restorations = 0;     ///< number of ticks with a restoration
};

/// The region of a cut.
struct Cut {
  Eigen::Vector3d point, normal;         ///< m, unit
  std::vector<Eigen::Vector3d> corners;  ///< m, of a blade's region; empty: the whole plane
};

/// How the surroundings of each point turn, for friction on objects that turn.
struct LocalSpins {
  bool areKnown = false;                  ///< a kinematic object that turns is near in this tick
  Eigen::Matrix3Xd spins;                 ///< 3 x #points, rad/s
  std::vector<Eigen::Matrix3d> inertias;  ///< scratch, m^2
};

/// The data of a SoftBody.
struct SoftBodyData : MotionMemory {
  std::shared_ptr<const BodyModel> model;
  SoftBodySettings settings;
  SoftBody* handle = nullptr;
  std::string name;  ///< the user's, like the next two
  void* userPointer = nullptr;
  int userIndex = -1;
  btDiscreteDynamicsWorld* world = nullptr;
  SharedModels* models = nullptr;   ///< of its system
  bool* groupsStale = nullptr;      ///< of the world's step: linked groups must be made again
  MultiBodyLinks* links = nullptr;  ///< of the world
  const bool* inTick =
      nullptr;  ///< of the world's step: bodies are being stepped; nullptr before the first tick
  const void* system = nullptr;     ///< identifies the shared step of all systems of the world
  ShapeCache* shapes = nullptr;     ///< of the world
  std::mutex* worldLock = nullptr;  ///< of the world: bodies may be read, searched and stepped at the same
                                    ///< time, but not what they share of Bullet and of their systems

  const ContactFilter* filter = nullptr;       ///< of the system; may be empty
  const Surroundings* surroundings = nullptr;  ///< of the system
  std::unique_ptr<BodyMedium> medium;          ///< nullptr: nothing has acted on the body yet

  PointState state;
  SpringArrays springs;
  std::unique_ptr<SpringConstants> startSprings;  ///< `springs.yielded` at the start of the tick, if a retry
                                                  ///< may need it
  std::size_t startBroken = 0;                    ///< likewise, `springs.broken`
  VolumeArrays volumes;
  TetrahedronVolumes tetrahedra;
  std::shared_ptr<const SoftenedConstants> softening;  ///< with a budget; then their constants are these
  PointMasses masses;
  SurfaceData surface;
  std::vector<Anchor> anchors;
  std::vector<PlaneContact> contacts;  ///< of the present tick, by point, with `heldPartners`
  HeldSurroundings held;               ///< pieces at rest near the body, see addStaticRows()
  std::vector<std::pair<std::uint32_t, std::uint32_t>>
      staticPartners;                                              ///< scratch of one point: indices in
                                                                   ///< `heldPartners`, ends of their owners
  std::vector<std::unique_ptr<HeldNeighbourhood>> neighbourhoods;  ///< of points, in `held`; kept to reuse
                                                                   ///< the memory
  std::size_t neighbourhoodCount = 0;                              ///< of the present tick
  LocalSpins localSpins;
  std::vector<double> searchDistance;         ///< #points, m, of the search for contacts
  std::unique_ptr<SearchWatch> watch;         ///< finds contacts beyond the search distance
  ContactSpeeds speeds;                       ///< of the present tick
  std::vector<HeldPartner> heldPartners;      ///< static and kinematic, near in this tick
  std::vector<HeldPartner> lastHeldPartners;  ///< those of the last tick
  std::vector<ObjectHandle> sensors;          ///< near in this tick, see addSensor()
  std::vector<btRigidBody*> freePartners;     ///< near in this tick, neither static nor kinematic
  std::vector<SoftBodyData*> softPartners;    ///< near in this tick, with surfaces
  ContactReport report;
  std::vector<Tear> tears;                    ///< of the last tick and since
  std::vector<BrokenAnchor> brokenAnchors;    ///< in the last tick
  std::vector<Cut> cuts;                      ///< asked for within a tick
  std::vector<TouchingPair> touching;         ///< for a listener, sorted by id
  std::vector<ReportedManifold*> shown;       ///< in Bullet's dispatcher
  std::vector<StoredImpulse> storedImpulses;  ///< of contacts with free bodies in the last tick
  std::vector<unsigned char> coupled;         ///< #points, scratch: 1 if a moving object touches the point

  std::uint32_t index = 0;  ///< among the living bodies of all systems of the world
  bool alive = true;
  bool asleep = false;
  bool restored = false;          ///< in this tick, see restoreIfUnsound()
  bool rolledBack = false;        ///< since the last tick, by restoreState()
  bool frequencyStale = true;     ///< inverse masses have changed since frequencySquared was computed
  double frequencySquared = 0.0;  ///< rad^2/s^2, bound of its own springs
  double fastestSquared = 0.0;    ///< rad^2/s^2, bound of fastestOscillationSquared for the present masses
  int island = -1;                ///< in the last tick, see SoftBody::island()
  std::vector<double> stiffnessSums;
  bool anyHeld = false;      ///< some point has an inverse mass of 0; frequencyStale applies to it, too
  MotionSums sums;           ///< see sumsOf()
  bool sumsValid = false;    ///< false once points have changed since; the bounds at the start of a tick
                             ///< are those of the tick in which `sums` were made
  Points startVelocity;      ///< 3 x #points, m/s, at the start of the tick
  double dampingRate = 0.0;  ///< 1/s, dampingRateBound; frequencyStale applies to it, too
  double approach = 0.0;     ///< m/s, largest at which it and a moving object near it approach each other in
                             ///< this tick; -HUGE_VAL: there is none
  double size = 0.0;         ///< m, diagonal of its initial bounding box
  std::unique_ptr<SpringBatchArrays> springBatches;  ///< see useSpringBatches()
  std::unique_ptr<ImplicitState> implicit;           ///< created when it is first stepped implicitly
  std::vector<float> skinned;                        ///< 3 x #points, scratch of a body with a skin

  /// Called when the application deletes one of the points.
  std::function<void(const btRigidBody&)> onPointDeleted;
  /// Called when the application gets access to the point masses of a body with Collision::Surface.
  std::function<void()> onPointsExposed;
};

/// Returns the data of a public body object.
SoftBodyData& dataOf(const SoftBody& body);

/// Returns the sums over the present points. Bodies in SIMD lanes have them from the step.
inline const MotionSums& sumsOf(SoftBodyData& body) {
  if (!body.sumsValid) body.sums = motionSums(body.state, body.masses.startPosition, body.model->rest);
  body.sumsValid = true;
  return body.sums;
}

inline std::uint32_t pointCount(const SoftBodyData& body) {
  return static_cast<std::uint32_t>(body.state.position.cols());
}

/// Returns the radius (m) of the points.
inline double radiusOf(const SoftBodyData& body) { return double(body.masses.shape->getRadius()); }

/// Returns the box (m) around points and a margin.
inline Eigen::AlignedBox3d boxAround(const Points& x, double margin) {
  return {x.rowwise().minCoeff().array() - margin, x.rowwise().maxCoeff().array() + margin};
}

/// Returns the gravity (m/s^2) that acts on points whose gravity the user has not set.
inline btVector3 gravityOf(const SoftBodyData& body) {
  return static_cast<btScalar>(body.settings.gravityFactor) * body.world->getGravity();
}

/// Returns the anchor of point i, or the end of the anchors.
template <class Body>
auto findAnchor(Body& body, std::uint32_t i) {
  return std::find_if(body.anchors.begin(), body.anchors.end(),
                      [&](const Anchor& anchor) { return anchor.point == i; });
}

inline bool isAttached(const SoftBodyData& body, std::uint32_t i) {
  return findAnchor(body, i) != body.anchors.end();
}

/// Returns whether point i is attached to the object, or was inside it around a point that is.
inline bool isAttached(const SoftBodyData& body, std::uint32_t i, const btCollisionObject& object) {
  return std::any_of(body.anchors.begin(), body.anchors.end(), [&](const Anchor& anchor) {
    if (anchor.body != &object) return false;
    return anchor.point == i ||
           (anchor.inside && std::binary_search(anchor.inside->begin(), anchor.inside->end(), i));
  });
}

/// Whether any point is: the body may be meant to be inside the object.
inline bool isAttached(const SoftBodyData& body, const btCollisionObject& object) {
  return std::any_of(body.anchors.begin(), body.anchors.end(),
                     [&](const Anchor& anchor) { return anchor.body == &object; });
}

inline bool isSurfaceBody(const SoftBodyData& body) { return body.settings.collision == Collision::Surface; }

/// Returns the object whose friction and restitution apply at point i; the user may have changed them.
inline const btRigidBody& materialOf(const SoftBodyData& body, std::uint32_t i) {
  if (!body.masses.exposed) return *body.surface.object;
  return *body.masses.bodies[i];
}

/// Returns whether the body has triangles, edges or vertices that collide.
inline bool hasSurface(const SoftBodyData& body) { return !body.model->topology.elements.empty(); }

/// Returns the static or kinematic object of one of the body's contacts.
inline const HeldPartner& partnerOf(const SoftBodyData& body, const PlaneContact& row) {
  return body.heldPartners[row.partner];
}

/// Returns the body that has the object as its surface or a point, or nullptr.
inline SoftBodyData* ownerOf(const btCollisionObject& object) {
  if (const SurfaceObject* surface = SurfaceObject::from(&object)) return surface->owner();
  const PointMass* point = PointMass::from(&object);
  return point ? point->owner() : nullptr;
}

/// Returns whether an object is a point or the surface of a soft body.
inline bool isSoft(const btCollisionObject* object) {
  return PointMass::from(object) != nullptr || SurfaceObject::from(object) != nullptr;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

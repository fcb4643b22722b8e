// SPDX-License-Identifier: Zlib

// This header holds what a soft body is made of, from its network to what it touches. The parts that live in
// Bullet's world are in point_masses.h and surface_body.h.

#pragma once

#include "bullet/bullet_objects.h"
#include "bullet/point_masses.h"
#include "bullet/rigid_shapes.h"
#include "bullet/surface_body.h"
#include "collide/surface_contacts.h"
#include "solver/contacts.h"
#include "solver/held_surface.h"
#include "solver/implicit_step.h"
#include "solver/plane_contacts.h"
#include "solver/point_state.h"
#include "solver/simd_steps.h"
#include "solver/springs.h"
#include "solver/volumes.h"

#include <limber/soft_body.h>
#include <limber/soft_contact.h>

#include <Eigen/Geometry>

#include <deque>
#include <functional>
#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

class MultiBodyLinks;
class ReportedManifold;

// --- contacts ----------------------------------------------------------------------------------------------

/// A point mass that moves with a rigid body.
struct Anchor {
  std::uint32_t point;
  btRigidBody* body;
  btVector3 pivot;  ///< in the body's local coordinates
};

/// What a contact bore in the last tick: a guess of what it will bear in the next.
struct StoredImpulse {
  int partner;                      ///< unique id in the broadphase, until that gives it to another object
  const btCollisionObject* object;  ///< that had it
  std::uint64_t key;                ///< of the features that touched
  ContactImpulse impulse;           ///< sum over the tick
};

/// Something that touched the body when the listener was last told.
struct TouchingPair {
  ObjectHandle other;
  SoftBody* otherBody;
};

/// m/s, what its contacts take from the scene: the same in other units of length, mass and time.
struct ContactSpeeds {
  double recovery = 0.0;  ///< at which what has got into something is lifted out at most
  double bounce = 0.0;    ///< what is slower does not bounce
};

/// A ContactWatch that must be told of each tick.
struct SearchWatch : ContactWatch {
  virtual void start(btScalar tick) = 0;
};

/// What a body tells of its contacts in the last tick in which it was awake.
struct ContactReport {
  std::vector<SoftContact> contacts;
  std::vector<ObjectHandle> partners;  ///< #contacts, their others
  std::size_t rows = 0, known = 0;     ///< the first are of points on what is held, by point; up to known
                                       ///< those found by us, the others by Bullet
  bool fresh = false;                  ///< of the last tick
  bool hasTriangles = false;           ///< ContactSide::triangle is up to date
};

// --- a body with a surface ---------------------------------------------------------------------------------

/// The plane in which a point last touched a static or kinematic convex body, in that body's coordinates.
struct CachedContact {
  std::uint64_t partner = 0;  ///< its stamp, see stampOf(); 0: none
  btVector3 surface = btVector3(0, 0, 0), normal = btVector3(0, 0, 0);
  btVector3 place = btVector3(0, 0, 0);  ///< of the point's centre when it was found
};

/// Where a body may get in a tick if nothing is in its way, see sweptBoundsOf().
struct SweptBounds {
  Eigen::AlignedBox3d box;                                 ///< m
  double maxDisplacement = 0.0;                            ///< m, of any point
  double tick = 0.0;                                       ///< s, of that tick; 0: not known
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  ///< m, of the body as a whole
};

/// The last search for contacts with a surface. Kept while the two are near, and then for its memory.
struct CachedSearch {
  const btCollisionObject* partner = nullptr;  ///< nullptr: none
  int id = 0;                                  ///< of the partner in the broadphase, unless used again
  std::uint64_t part = 0;                      ///< of the partner's shape
  bool used = false;                           ///< in the present tick
  ContactCache kept;
};

/// How a surface object was left, see surface_rigid.cpp.
struct LeftObject {
  btTransform pose = btTransform::getIdentity();
  btVector3 velocity = btVector3(0, 0, 0), spin = btVector3(0, 0, 0);
};

/// What a body with Collision::Surface has besides its points.
struct SurfaceData {
  SurfaceObject* object = nullptr;  ///< nullptr: Collision::Points, or the application has deleted it
  std::unique_ptr<SurfaceShape> shape;
  LeftObject left;
  Eigen::Quaterniond frame = Eigen::Quaterniond::Identity();  ///< the object's basis, turning with the body
  Eigen::Vector3d objectForce = Eigen::Vector3d::Zero();      ///< N, on the object in this stepSimulation()
  Eigen::Vector3d objectTorque = Eigen::Vector3d::Zero();     ///< N m
  bool pushed = false;                                        ///< there have been any
  bool joined = false;                                        ///< a constraint of Bullet's holds the object
  std::vector<double> gaps;             ///< #contacts, scratch of readObjectFromBullet()
  bool held = false;                    ///< taken out of the simulation by Bullet or the user
  btVector3 gravity;                    ///< m/s^2, of the world when the points were given it
  Points force;                         ///< 3 x #points, N, of the present stepSimulation(); once shared
  std::vector<CachedContact> contacts;  ///< #points
  SweptBounds sweptBounds;              ///< foreseen for the coming tick; Bullet's broadphase has its box
  std::vector<btCollisionObject*> partners;  ///< of the coming tick, see collectPartners()

  std::shared_ptr<const SurfaceTopology> topology;  ///< of its points, triangles and, of ropes, springs
  Points motion;                                    ///< 3 x #points, m, expected over the tick
  Points within;                                    ///< 3 x #points, m, where they are within a step
  SurfaceBoxes boxes;
  MovingSurface moving;                ///< a view of the above
  double impact = 0.0;                 ///< m in the tick, towards static and kinematic objects that stop it
  bool foreseen = false;               ///< `motion` and `impact` are those of this tick
  bool fitted = false;                 ///< and so are `boxes`
  std::vector<CachedSearch> searches;  ///< with what was near in the last tick
  std::deque<ConcavePatch> patches;    ///< of concave partners; views into a patch last as long as it does
};

// --- a body ------------------------------------------------------------------------------------------------

/// How fast a body moves within itself.
struct MotionRates {
  double boundSquared = 0.0, fastestSquared = 0.0;  ///< rad^2/s^2, see Frequencies
  double turnRate = 0.0;                            ///< rad/s, fastestTurn
};

/// The largest of the last two spans of time, see lasting() in group_stepping.cpp.
struct RateHistory {
  MotionRates now, before;
  double age = 0.0;  ///< s since the present span began
};

/// What a SoftBody is made of.
struct SoftBodyData {
  SharedNetwork network;
  SoftBodySettings settings;
  SoftBody* handle = nullptr;
  btDiscreteDynamicsWorld* world = nullptr;
  MultiBodyLinks* links = nullptr;  ///< of the world
  const void* system = nullptr;     ///< to tell bodies of several systems in a world apart
  ShapeCache* shapes = nullptr;     ///< the system's

  PointState state;
  SpringArrays springs;
  VolumeArrays volumes;
  TetrahedronVolumes tetrahedra;
  PointMasses masses;
  SurfaceData surface;
  std::vector<Anchor> anchors;
  std::vector<PlaneContact> contacts;                     ///< of the present tick, by point
  std::vector<const btCollisionObject*> contactPartners;  ///< #contacts
  std::vector<ObjectHandle> partnerHandles;               ///< of those partners
  HeldSurroundings held;                                  ///< what is static and not flat around the points
  std::vector<std::pair<const btCollisionObject*, std::uint32_t>> staticPartners;  ///< scratch, of one point:
                                                                                   ///< with its owners' end
  std::size_t staticPieces = 0;                                                    ///< scratch: their begin
  std::deque<HeldNeighbourhood> neighbourhoods;    ///< in it, of points; kept for their memory
  std::size_t neighbourhoodCount = 0;              ///< of the present tick
  std::vector<std::uint64_t> partnerStamps;        ///< #partners, see stampOf()
  std::vector<Eigen::AlignedBox3d> partnerBoxes;   ///< #partners, m
  std::vector<double> searchDistance;              ///< #points, m, how far contacts were looked for
  std::unique_ptr<SearchWatch> watch;              ///< finds what is beyond the reach
  ContactSpeeds speeds;                            ///< of the present tick
  std::vector<const btCollisionObject*> partners;  ///< scratch of gatherContacts
  std::vector<btRigidBody*> freePartners;          ///< near in this tick, neither static nor kinematic
  std::vector<SoftBodyData*> softPartners;         ///< near in this tick, with surfaces
  ContactReport report;
  std::vector<TouchingPair> touching;         ///< for a listener, by id
  std::vector<ReportedManifold*> shown;       ///< in Bullet's dispatcher
  std::vector<StoredImpulse> storedImpulses;  ///< with free bodies, of the last tick
  std::vector<unsigned char> coupled;  ///< #points, scratch: 1 if something that moves touches the point

  std::uint32_t index = 0;  ///< among the bodies of the system that are alive
  bool alive = true;
  bool asleep = false;
  bool restored = false;           ///< in this tick, see restoreIfUnsound()
  std::uint32_t restorations = 0;  ///< ticks in which it was
  double calmTime = 0.0;           ///< s for which its group has been calm
  bool frequencyStale = true;      ///< inverse masses have changed since frequencySquared was computed
  double frequencySquared = 0.0;   ///< rad^2/s^2, bound of its own springs
  double fastestSquared = 0.0;  ///< rad^2/s^2, fastestOscillationSquared with the masses it has now, at most
  double fastestAtRest = 0.0;   ///< the same with the masses of its settings
  RateHistory rateHistory;
  int substeps = 0;                   ///< in the last tick
  Stepper stepper = Stepper::Verlet;  ///< in the last tick
  double errorPerSecond = 0.0;        ///< m/s
  double errorCoefficient = 0.0;      ///< m/s^3, see SteppingProblem
  std::vector<double> stiffnessSums;
  Points startVelocity;             ///< 3 x #points, m/s, at the start of the tick
  double dampingRate = 0.0;         ///< 1/s, dampingRateBound, as stale as frequencySquared
  double size = 0.0;                ///< m, diagonal of the box around it at rest
  bool narrow = false;              ///< see SteppingProblem
  bool cheapNewton = false;         ///< see SteppingProblem
  bool prefersImplicit = false;     ///< in the last tick, whatever else moved with it
  SpringBatchArrays springBatches;  ///< empty unless it is stepped so
  ImplicitState implicit;           ///< empty unless it is stepped so
  std::vector<float> skinned;       ///< 3 x #points, scratch of a body with a skin

  /// Told when the application deletes one of the points.
  std::function<void(const btRigidBody&)> onPointDeleted;
  /// Told when the point masses of a body with Collision::Surface become known outside.
  std::function<void()> onPointsExposed;
};

/// The data of a body that users hold.
SoftBodyData& dataOf(const SoftBody& body);

inline bool isSurfaceBody(const SoftBodyData& body) { return body.settings.collision == Collision::Surface; }

/// Whether an object is a soft body's: one of its points, or its surface.
inline bool isSoft(const btCollisionObject* object) {
  return PointMass::from(object) != nullptr || SurfaceObject::from(object) != nullptr;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/contact_report.h"
#include "bullet/point_masses.h"
#include "bullet/surface_data.h"
#include "solver/contact_rows.h"
#include "solver/held_surface.h"
#include "solver/implicit_step.h"
#include "solver/pair_contacts.h"
#include "solver/point_state.h"
#include "solver/simd_steps.h"
#include "solver/springs.h"
#include "solver/volumes.h"

#include <limber/soft_body.h>

#include <deque>
#include <functional>
#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A point mass that moves with a rigid body.
struct Anchor {
  std::uint32_t point;
  btRigidBody* body;
  btVector3 pivot;  ///< in the body's local coordinates
};

/// What a contact bore in the last tick: a guess of what it will bear in the next.
struct KnownContact {
  int partner;                      ///< unique id in the broadphase, until that gives it to another object
  const btCollisionObject* object;  ///< that had it
  std::uint64_t key;                ///< of the features that touched
  Bearing bearing;                  ///< sum over the tick
};

class MultiBodyLinks;
class ShownContacts;

/// Something that touched the body when the listener was last told.
struct TouchingPair {
  PartnerMark other;
  SoftBody* otherBody;
};

/// m/s, what its contacts take from the scene: the same in other units of length, mass and time.
struct ContactSpeeds {
  double recovery = 0.0;  ///< at which what has got into something is lifted out at most
  double bounce = 0.0;    ///< what is slower does not bounce
};

/// A ContactWatch that must be told of each tick.
struct ReachWatch : ContactWatch {
  virtual void start(btScalar tick) = 0;
};

/// What a SoftBody is made of.
/// How fast a body moves within itself.
struct MotionRates {
  double boundSquared = 0.0, fastestSquared = 0.0;  ///< rad^2/s^2, see Frequencies
  double turnRate = 0.0;                            ///< rad/s, fastestTurn
};

/// The largest of the last two spans of time, see lasting() in group_stepping.cpp.
struct KeptRates {
  MotionRates now, before;
  double age = 0.0;  ///< s since the present span began
};

struct SoftBodyData {
  SharedNetwork network;
  SoftBodySettings settings;
  SoftBody* handle = nullptr;
  btDiscreteDynamicsWorld* world = nullptr;
  MultiBodyLinks* links = nullptr;  ///< of the world
  const void* system = nullptr;  ///< to tell bodies of several systems in a world apart
  ShapeCache* shapes = nullptr;  ///< the system's

  PointState state;
  SpringArrays springs;
  VolumeArrays volumes;
  TetrahedronVolumes tetrahedra;
  PointMasses masses;
  SurfaceData surface;
  std::vector<Anchor> anchors;
  std::vector<ContactRow> contacts;                       ///< of the present tick, by point
  std::vector<const btCollisionObject*> contactPartners;  ///< #contacts
  std::vector<PartnerMark> partnerMarks;                  ///< of those partners
  HeldSurroundings held;                                  ///< what is static and not flat around the points
  std::vector<std::pair<const btCollisionObject*, std::uint32_t>> staticPartners;  ///< scratch, of one point:
                                                                                   ///< with its owners' end
  std::size_t staticPieces = 0;                                                    ///< scratch: their begin
  std::deque<HeldNeighbourhood> neighbourhoods;           ///< in it, of points; kept for their memory
  std::size_t neighbourhoodCount = 0;                     ///< of the present tick
  std::vector<std::uint64_t> partnerStamps;               ///< #partners, see stampOf()
  std::vector<Eigen::AlignedBox3d> partnerBoxes;          ///< #partners, m
  std::vector<double> reach;                              ///< #points, m, how far contacts were looked for
  std::unique_ptr<ReachWatch> watch;                      ///< finds what is beyond the reach
  ContactSpeeds speeds;                                   ///< of the present tick
  std::vector<const btCollisionObject*> partners;         ///< scratch of gatherContacts
  std::vector<btRigidBody*> freePartners;                 ///< near in this tick, neither static nor kinematic
  std::vector<SoftBodyData*> softPartners;                ///< near in this tick, with surfaces
  ContactReport report;
  std::vector<TouchingPair> touching;       ///< for a listener, by id
  std::vector<ShownContacts*> shown;        ///< in Bullet's dispatcher
  std::vector<KnownContact> knownContacts;  ///< with free bodies, of the last tick
  std::vector<unsigned char> coupled;       ///< #points, scratch: 1 if something that moves touches the point

  std::uint32_t index = 0;  ///< among the bodies of the system that are alive
  bool alive = true;
  bool asleep = false;
  bool restored = false;           ///< in this tick, see restoreIfUnsound()
  std::uint32_t restorations = 0;  ///< ticks in which it was
  double calmTime = 0.0;          ///< s for which its group has been calm
  bool frequencyStale = true;     ///< inverse masses have changed since frequencySquared was computed
  double frequencySquared = 0.0;  ///< rad^2/s^2, bound of its own springs
  double fastestSquared = 0.0;  ///< rad^2/s^2, fastestOscillationSquared with the masses it has now, at most
  double fastestAtRest = 0.0;   ///< the same with the masses of its settings
  KeptRates keptRates;
  int substeps = 0;             ///< in the last tick
  Stepper stepper = Stepper::Verlet;  ///< in the last tick
  double errorPerSecond = 0.0;        ///< m/s
  double errorPerSquare = 0.0;        ///< m/s^3, see SteppingProblem
  std::vector<double> stiffnessSums;
  Points startVelocity;        ///< 3 x #points, m/s, at the start of the tick
  double dampingRate = 0.0;    ///< 1/s, dampingRateBound, as stale as frequencySquared
  double size = 0.0;           ///< m, diagonal of the box around it at rest
  bool narrow = false;         ///< see SteppingProblem
  bool cheapNewton = false;    ///< see SteppingProblem
  bool prefersImplicit = false;  ///< in the last tick, whatever else moved with it
  QuadArrays quads;            ///< empty unless it is stepped so
  ImplicitState implicit;      ///< empty unless it is stepped so
  std::vector<float> skinned;  ///< 3 x #points, scratch of a body with a skin

  /// Told when the application deletes one of the points.
  std::function<void(const btRigidBody&)> onPointDeleted;
  /// Told when the point masses of a body with Collision::Surface become known outside.
  std::function<void()> onPointsShared;
};

/// The data of a body that users hold.
SoftBodyData& dataOf(const SoftBody& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

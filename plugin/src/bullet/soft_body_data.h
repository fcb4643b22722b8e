// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/contact_report.h"
#include "bullet/point_masses.h"
#include "bullet/surface_data.h"
#include "core/contact_rows.h"
#include "core/implicit_step.h"
#include "core/pair_contacts.h"
#include "core/point_state.h"
#include "core/quad_step.h"
#include "core/spring_arrays.h"
#include "core/tetrahedron_volumes.h"
#include "core/volume_term.h"

#include <limber/soft_body.h>

#include <functional>
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
  int partner;        ///< unique id in the broadphase
  std::uint64_t key;  ///< of the features that touched
  Bearing bearing;    ///< sum over the tick
};

class ShownContacts;

/// Something that touched the body when the listener was last told.
struct TouchingPair {
  PartnerMark other;
  SoftBody* otherBody;
};

/// What a SoftBody is made of.
struct SoftBodyData {
  SharedNetwork network;
  SoftBodySettings settings;
  SoftBody* handle = nullptr;
  btDiscreteDynamicsWorld* world = nullptr;
  const void* system = nullptr;  ///< to tell bodies of several systems in a world apart

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
  std::vector<double> reach;                              ///< #points, m, how far contacts were looked for
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
  double calmTime = 0.0;          ///< s for which its group has been calm
  bool frequencyStale = true;     ///< inverse masses have changed since frequencySquared was computed
  double frequencySquared = 0.0;  ///< rad^2/s^2, bound of its own springs
  double fastestSquared = 0.0;  ///< rad^2/s^2, fastestOscillationSquared with the masses it has now, at most
  double fastestAtRest = 0.0;   ///< the same with the masses of its settings
  int substeps = 0;             ///< in the last tick
  Stepper stepper = Stepper::Verlet;  ///< in the last tick
  double errorPerSecond = 0.0;        ///< m/s
  double errorPerSquare = 0.0;        ///< m/s^3, see SteppingProblem
  std::vector<double> stiffnessSums;
  Points startVelocity;        ///< 3 x #points, m/s, at the start of the tick; empty without a tolerance
  double dampingRate = 0.0;    ///< 1/s, dampingRateBound, as stale as frequencySquared
  double size = 0.0;           ///< m, diagonal of the box around it at rest
  bool narrow = false;         ///< see SteppingProblem
  bool cheapNewton = false;    ///< see SteppingProblem
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

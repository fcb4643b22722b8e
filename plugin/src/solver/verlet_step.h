// SPDX-License-Identifier: Zlib
#pragma once

// Velocity Verlet for soft bodies: one by itself, or several with the rigid ones that are coupled with them.

#include "solver/contacts.h"
#include "solver/lane_kernels.h"
#include "solver/links.h"
#include "solver/plane_contacts.h"
#include "solver/point_state.h"
#include "solver/springs.h"
#include "solver/verlet_kernel.h"
#include "solver/volumes.h"

#include <vector>

namespace limber {

struct SpringBatchArrays;

/// A soft body as the step sees it.
struct SolverBody {
  PointState* points;
  SpringArrays* springs;
  std::vector<PlaneContact>* contacts;       ///< may be nullptr
  VolumeArrays* volumes = nullptr;           ///< may be nullptr
  TetrahedronVolumes* tetrahedra = nullptr;  ///< may be nullptr

  SpringBatchArrays* springBatches =
      nullptr;  ///< for stepping it four springs at a time, see simd_steps.h; may be nullptr

  ContactWatch* watch = nullptr;  ///< may be nullptr

  double errorRate = 0.0;  ///< m/s, written by the step, see verletErrorRate
};

/// Sets the points' forces to those of springs and volume, and keeps the springs' directions for the dampers.
void computeElasticForces(SolverBody& body);

/// J in springs and volume, with the points at `position`.
double elasticEnergy(SolverBody& body, const Points& position);

/// Makes the volume terms ready for substeps of dt seconds that must be stable; 0 for an implicit stepper.
void prepareVolumes(SolverBody& body, double dt);

/// m/s: how fast the positions of Verlet's solution depart from the exact one, root mean square over the
/// points. In substeps of dt an oscillation of frequency omega is wrong by (omega dt)^2 / 24 of its phase
/// (Hairer, Lubich, Wanner 2006, section I.5), so one of amplitude A departs by
///     A omega (omega dt)^2 / 24 = |jerk| dt^2 / 24  per second,   jerk = change of acceleration / dt.
/// `change` is the sum over the points of its square over one substep.
double verletErrorRate(double change, Eigen::Index points, double dt);

/// A body while it is stepped together with others.
struct BatchedBody {
  SolverBody* stepped;
  bool inBatches;  ///< its state is in the quads, else in the points
  kernel::SpringBatchBody springBatches;
};

struct SolverIsland;

/// Looks for contacts anew within a tick where surfaces move too far in it to be known at its start.
struct PairSearch {
  int every = 0;  ///< substeps from one search to the next; 0: none is needed
  void* context = nullptr;
  /// Replaces what it finds in group.pairs.contacts; s since the start of the tick and until the next search.
  /// The state of bodies[i] is at views[i].
  void (*search)(void* context, SolverIsland& group, double since, double ahead) = nullptr;
};

/// Bodies that links join or that touch; without links a group is one body.
struct SolverIsland {
  std::vector<SolverBody> bodies;
  LinkedBodies links;       ///< links.points[i] is bodies[i].points
  IslandConstraints pairs;  ///< what else couples them, and the rigid ones with their own surroundings
  PairSearch again;

  // Scratch of the step, #bodies.
  std::vector<BatchedBody> inStep;
  std::vector<PointView> views;  ///< where the bodies' points are meanwhile
};

/// Whether the group is one body that nothing but its own springs, volumes and contacts acts on.
bool isPlain(const SolverIsland& group);

/// Advances all bodies of the group by `tick` seconds in `substeps` substeps of velocity Verlet with damping
/// split off (Strang), per substep of dt:
///
///     damp dt/2 | kick dt/2 | drift dt | new forces | kick dt/2 | damp dt/2
///
/// with anchors and contacts solved before each drift (positions) and each damping (velocities).
/// Second order, symplectic without damping; linear momentum is exact and angular momentum is kept, since all
/// impulses run along the springs. Stable for omega dt < 2 whatever the damping: kick-drift-kick keeps
/// v^2 + omega^2 (1 - (omega dt)^2/4) x^2, whose velocity part the dampers can only shrink.
/// A body by itself and one in a lane (simd_steps.h) give the same bits.
/// Held points (inverse mass 0) move on with their velocity. Allocates nothing.
void stepVerlet(SolverIsland& group, double tick, int substeps);

// --- contacts of points, as steps call them ----------------------------------------------------------------

inline bool mayTouch(const SolverBody& body) {
  return (body.contacts && !body.contacts->empty()) || (body.watch && body.watch->on);
}

/// Before a drift: holds back what is on its way into something, foreseen or not.
inline void solvePositions(SolverBody& body, const PointView& points, double time, double dt) {
  if (body.contacts) solvePositions(*body.contacts, points, time, dt);
  if (!body.watch || !body.watch->on) return;
  body.watch->look(points, time, dt);
  if (!body.watch->rows.empty()) solvePositions(body.watch->rows, points, time, dt);
}

/// After the second kick.
inline void solveVelocities(SolverBody& body, const PointView& points) {
  if (body.contacts) solveVelocities(*body.contacts, points);
  if (body.watch && !body.watch->rows.empty()) solveVelocities(body.watch->rows, points);
}

/// A body's contacts as the kernels call them. `points` must hold the state of the start of the tick by the
/// time calls() is called.
struct BodyContacts {
  SolverBody* body;
  PointView points;

  kernel::ContactCalls calls() {
    const bool touches = mayTouch(*body);
    if (touches && body->contacts) prepareContacts(*body->contacts, points);
    return {touches ? this : nullptr, &BodyContacts::stop, &BodyContacts::settle};
  }

 private:
  static void stop(void* context, double time, double dt) {
    auto& self = *static_cast<BodyContacts*>(context);
    solvePositions(*self.body, self.points, time, dt);
  }
  static void settle(void* context) {
    auto& self = *static_cast<BodyContacts*>(context);
    solveVelocities(*self.body, self.points);
  }
};

}  // namespace limber

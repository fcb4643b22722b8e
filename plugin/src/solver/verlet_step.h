// SPDX-License-Identifier: Zlib
#pragma once

// Velocity Verlet for a single soft body, or for several together with the rigid bodies coupled to them.

#include "solver/contacts.h"
#include "solver/medium.h"
#include "solver/motion_sums.h"
#include "solver/volumes.h"

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

struct SpringBatchArrays;

/// The rest shape of a body, for motionSums().
struct RestShape {
  std::vector<double> fractions;  ///< #points, mass fractions
  Points weighted;                ///< 3 x #points, m, scaled rest positions times the mass fractions
  double meanSquare = 0.0;        ///< m^2, of the scaled rest positions
};

using MotionSums = kernel::MotionSums<double>;

/// Returns the sums of a body whose points were at `start` (3 x #points, m) when the tick began.
MotionSums motionSums(const PointState& state, const Points& start, const RestShape& rest);

/// The data of a soft body that a step uses.
struct SolverBody {
  PointState* points;
  SpringArrays* springs;
  std::vector<PlaneContact>* contacts;       ///< may be nullptr
  VolumeArrays* volumes = nullptr;           ///< may be nullptr
  TetrahedronVolumes* tetrahedra = nullptr;  ///< may be nullptr

  SpringBatchArrays* springBatches =
      nullptr;  ///< to step it four springs at a time, see simd_steps.h; may be nullptr

  PackedPlanes* packed = nullptr;  ///< rows of `contacts`; set in steps with springBatches
  ContactWatch* watch = nullptr;   ///< may be nullptr
  PointDrag* drag = nullptr;       ///< nullptr: none

  const RestShape* rest = nullptr;  ///< may be nullptr without `sums`
  MotionSums* sums = nullptr;       ///< written by stepLanes(); nullptr: not wanted

  double errorRate = 0.0;  ///< m/s, written by the step, see verletErrorRate()
};

/// Sets the points' forces to those of springs and volume terms. Stores the springs' directions for the
/// dampers.
void computeElasticForces(SolverBody& body, double crossing = kernel::kFirstCrossing);

/// Returns the argument of kernel::stepAlone(), without contacts and drag.
kernel::Body<double> kernelBody(SolverBody& body);

/// Returns the energy (J) of springs and volume terms with the points at `position`.
double elasticEnergy(SolverBody& body, const Points& position);

/// Prepares the volume terms for stable substeps of dt seconds; 0 for an implicit stepper.
void prepareVolumes(SolverBody& body, double dt);

/// Returns the speed (m/s) at which the positions of Verlet's solution depart from the exact ones, as root
/// mean square over the points. With substeps of dt the phase of an oscillation of frequency omega has a
/// relative error of (omega dt)^2 / 24 (Hairer, Lubich, Wanner 2006, section I.5). With amplitude A it
/// departs by
///     A omega (omega dt)^2 / 24 = |jerk| dt^2 / 24  per second,   jerk = change of acceleration / dt.
/// `change` is the sum over the points of the squared change of acceleration in one substep.
double verletErrorRate(double change, Eigen::Index points, double dt);

/// A body during a step together with others.
struct BatchedBody {
  SolverBody* stepped;
  bool inBatches;                  ///< its state is in stepped->springBatches, otherwise in stepped->points
  kernel::SpringBatchBody arrays;  ///< where its state is; only the fields of kernel::Body if not in batches
};

/// What one task of a step computes: a whole body, or a range of the points, springs or tetrahedra of a
/// divided one.
struct BodyPart {
  static constexpr std::uint32_t kWhole = static_cast<std::uint32_t>(-1);
  std::uint32_t body, begin = 0, end = kWhole;

  bool isWhole() const { return end == kWhole; }
};

/// The tasks of a step. Only bodies that several threads step are divided (see Division).
struct StepParts {
  std::vector<BodyPart> points;    ///< of Division::points, if divided
  std::vector<BodyPart> contacts;  ///< ranges of points whose plane contacts are solved by one task
  std::array<std::vector<BodyPart>, Division::kPhases> springs, tetrahedra;  ///< by phase
  std::vector<std::uint32_t> divided;                                        ///< numbers of bodies
};

struct SolverIsland;

/// Repeats the search for contacts within a tick, if surfaces move too far to predict all contacts at its
/// start.
struct PairSearch {
  int every = 0;  ///< number of substeps between searches; 0: no search
  void* context = nullptr;
  /// Updates group.pairs.contacts, with the help of the team. `since` is the time (s) since the start of the
  /// tick, `ahead` the time until the next search. The state of bodies[i] is at links.views[i].
  void (*search)(void* context, SolverIsland& group, Team& team, double since, double ahead) = nullptr;
};

/// Bodies that links or contacts couple; without them an island is one body. Each body alone has one, too:
/// its size counts in worlds of thousands of bodies.
struct SolverIsland {
  std::vector<SolverBody> bodies;
  LinkedBodies links;       ///< links.points[i] is bodies[i].points
  IslandConstraints pairs;  ///< contacts and joints of these, and of the rigid bodies with their surroundings
  PairSearch again;

  Team* team = nullptr;  ///< the threads that help to step it; nullptr: none

  std::vector<BatchedBody> inStep;  ///< scratch of the step, #bodies
  StepParts parts;                  ///< scratch of the step
};

/// Whether the island is one soft body without couplings to others and without elastic limits.
bool isPlain(const SolverIsland& group);

/// Advances all bodies of the island by `tick` seconds in `substeps` substeps of velocity Verlet with Strang
/// splitting of the damping. Each substep of dt consists of
///
///     damp dt/2 | kick dt/2 | drift dt | new forces | kick dt/2 | drag dt | damp dt/2
///
/// with anchors and contacts solved before each drift (positions) and each damping (velocities).
/// The method is of second order, and symplectic without damping. Linear momentum is exact and angular
/// momentum is conserved, since all impulses are along the springs. It is stable for omega dt < 2 with any
/// damping: kick-drift-kick conserves  v^2 + omega^2 (1 - (omega dt)^2/4) x^2,  and the dampers can only
/// reduce its velocity part. A single body and one in a lane (simd_steps.h) give the same results, to the
/// bit, with any number of threads. Held points (inverse mass 0) keep their velocity. Allocates nothing.
void stepVerlet(SolverIsland& group, double tick, int substeps);

// --- contacts of points ------------------------------------------------------------------------------------

inline bool mayTouch(const SolverBody& body) {
  return (body.contacts && !body.contacts->empty()) || (body.watch && body.watch->on);
}

/// Solves the unpredicted contacts of points before a drift. Looks for more if a point `leaves` its search
/// region.
inline void solveUnpredicted(SolverBody& body, const PointView& points, double time, double dt,
                             bool leaves = true) {
  if (!body.watch || !body.watch->on) return;
  if (leaves) body.watch->look(points, time, dt);
  if (!body.watch->rows.empty()) solvePositions(ContactRows(body.watch->rows), points, time, dt);
}

/// Solves the predicted and unpredicted contacts of points before a drift. Then no point enters a surface.
inline void solvePositions(SolverBody& body, const PointView& points, double time, double dt) {
  if (body.contacts) solvePositions(ContactRows(*body.contacts, body.packed), points, time, dt);
  solveUnpredicted(body, points, time, dt);
}

/// Applies the drag of a substep, after the second kick.
inline void applyDrag(SolverBody& body, const PointView& points, double dt) {
  if (body.drag) applyDrag(*body.drag, points, body.points->position.cols(), dt);
}

/// Starts the measurement of the drag's work.
inline void startDrag(SolverBody& body) {
  if (body.drag) startDrag(*body.drag, viewOf(*body.points), body.points->position.cols());
}

/// Solves the velocities at unpredicted contacts after the drag.
inline void settleUnpredicted(SolverBody& body, const PointView& points) {
  if (body.watch && !body.watch->rows.empty()) solveVelocities(ContactRows(body.watch->rows), points);
}

/// Solves the velocities at all contacts of points after the drag.
inline void solveVelocities(SolverBody& body, const PointView& points) {
  if (body.contacts) solveVelocities(ContactRows(*body.contacts, body.packed), points);
  settleUnpredicted(body, points);
}

}  // namespace limber

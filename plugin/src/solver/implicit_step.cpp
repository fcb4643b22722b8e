// SPDX-License-Identifier: Zlib
// Steps a soft body by the implicit midpoint rule: its equation, the iterations, and the limit of its energy.
#include "solver/implicit_step.h"

namespace limber {
namespace {

// --- the equation ------------------------------------------------------------------------------------------

/// A substep of the implicit midpoint rule during its solution. body.points->position is the midpoint x of
/// the iterations.
struct Substep {
  SolverBody& body;
  ImplicitState& implicit;
  double time;            ///< s since the start of the tick
  double h;               ///< s, of the whole substep
  bool euler = false;     ///< only its first half, by backward Euler
  bool downhill = false;  ///< the iterations start from x0 instead of x0 + h/2 v0

  PointState& points() const { return *body.points; }
  SpringArrays& springs() const { return *body.springs; }
  ContactSpan span() const { return euler ? ContactSpan{time, 0.5 * h, 1.0} : ContactSpan{time, h, 2.0}; }
  bool hasContacts() const { return !implicit.contacts.loads.empty(); }
};

/// y of implicit_step.h; held points move with their velocity.
Eigen::Vector3d inertialMidpoint(const Substep& s, Eigen::Index i) {
  return s.implicit.start.col(i) + 0.5 * s.h * s.implicit.startVelocity.col(i) +
         0.25 * s.h * s.h * s.points().acceleration.col(i);
}

/// 0 to 1, see lookAhead(); 0 for backward Euler, which uses the mean velocity.
double damperLookAhead(const Substep& s, std::size_t i) {
  if (s.euler) return 0.0;
  return lookAhead(s.springs()->damping[i], inverseMassesOf(s.springs(), s.points().inverseMass, i), s.h);
}

/// m: extension of the damper of spring i beyond its length without force. With the velocity
/// v_m + beta (v_m - v0) of lookAhead() and v_m = 2/h (x - x0), it has no force where
/// (1 + beta) (x - x0) = beta h/2 v0.
double damperStretch(const Substep& s, std::size_t i, const Points& x) {
  const ImplicitState& state = s.implicit;
  const auto a = s.springs()->a[i], b = s.springs()->b[i];
  const double beta = damperLookAhead(s, i), old = 0.5 * s.h * beta / (1.0 + beta);
  const auto displacement = [&](std::uint32_t j) -> Eigen::Vector3d {
    return x.col(j) - state.start.col(j) - old * state.startVelocity.col(j);
  };
  return state.damperDirection.col(static_cast<Eigen::Index>(i)).dot(displacement(b) - displacement(a));
}

/// kg: h/2 c (1 + beta).
double damperWeight(const Substep& s, std::size_t i) {
  return 0.5 * s.h * s.springs()->damping[i] * (1.0 + damperLookAhead(s, i));
}

/// Adds the dampers' forces for the velocities given by the present midpoint positions.
void addDampingForces(const Substep& s) {
  const SpringArrays& springs = s.springs();
  if (!springs->damped) return;
  Points& force = s.points().force;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double pull = 4.0 / (s.h * s.h) * damperWeight(s, i) * damperStretch(s, i, s.points().position);
    const Eigen::Vector3d f = pull * s.implicit.damperDirection.col(static_cast<Eigen::Index>(i));
    force.col(springs->a[i]) += f;
    force.col(springs->b[i]) -= f;
  }
}

/// Sets the points' forces to those of springs and dampers at x. `rotateDampers` gives the dampers the
/// directions of their springs, in the first iterations only: under strong damping changing directions would
/// not converge.
void computeForces(const Substep& s, bool rotateDampers) {
  computeElasticForces(s.body);
  if (rotateDampers) s.implicit.damperDirection = s.springs().direction;
  addDampingForces(s);
}

/// Sets implicit.residual to  M (y - x) + h^2/4 f(x) + loads  (implicit_step.h), 0 for held points.
void computeResidual(const Substep& s) {
  const PointState& p = s.points();
  Points& r = s.implicit.residual;
  for (Eigen::Index i = 0; i < p.position.cols(); ++i) {
    if (isHeld(p.inverseMass, i))
      r.col(i).setZero();
    else
      r.col(i) = massOf(p.inverseMass, i) * (inertialMidpoint(s, i) - p.position.col(i)) +
                 0.25 * s.h * s.h * p.force.col(i);
  }
  if (s.hasContacts()) addLoads(s.implicit.contacts, &RowLoad::load, r);
}

/// The function that the iterations minimise without contacts: |x - y|_M^2 / 2 + h^2/4 E(x) and the dampers'
/// part.
double objective(const Substep& s, const Points& position) {
  const PointState& p = s.points();
  double sum = 0.25 * s.h * s.h * elasticEnergy(s.body, position);
  for (Eigen::Index i = 0; i < position.cols(); ++i)
    if (!isHeld(p.inverseMass, i))
      sum += 0.5 * massOf(p.inverseMass, i) * (position.col(i) - inertialMidpoint(s, i)).squaredNorm();
  for (std::size_t i = 0; s.springs()->damped && i < s.springs().size(); ++i)
    sum += 0.5 * damperWeight(s, i) * std::pow(damperStretch(s, i, position), 2);
  return sum;
}

// --- the iterations ----------------------------------------------------------------------------------------

/// Iterations end when no point moves by more than this share of the longest spring.
constexpr double kConverged = 1e-11;

/// The same for the sweeps over the contacts in an iteration.
constexpr double kContactsConverged = 1e-12;
constexpr int kMaxSharedIterations = 20;

/// Largest last movement, as a share of the longest spring, of a midpoint that may be extrapolated.
constexpr double kNearlyConverged = 0.05;
constexpr int kMaxNewtonIterations = 12;

/// Share by which the energy may exceed its lowest value, apart from work and external changes: the midpoint
/// rule does not conserve it exactly but lets it oscillate about a value.
constexpr double kEnergySwing = 1e-4;

/// Share of the energy: rounding difference between work and kinetic energy of a body that falls from rest.
constexpr double kEnergyRounding = 1e-10;

/// Iterations in which the dampers rotate with their springs.
constexpr int kDamperRotations = 3;

/// Repetitions of a substep that leads through surfaces.
constexpr int kMaxRepeats = 3;

/// Halvings of a Newton step that would increase the objective.
constexpr int kMaxImplicitHalvings = 6;

/// Sets the start of the iterations. x0 + h/2 v0 preserves the rotation and fall of the whole body, however
/// stiff it is. With x0 the springs never get more energy than there was, but little of such motion remains.
void guess(const Substep& s) {
  PointState& p = s.points();
  p.position = s.implicit.start;
  for (Eigen::Index i = 0; i < p.position.cols(); ++i)
    if (!s.downhill || isHeld(p.inverseMass, i))
      p.position.col(i) += 0.5 * s.h * s.implicit.startVelocity.col(i);
}

double longest(const SpringArrays& springs) {
  return *std::max_element(springs->restLength.begin(), springs->restLength.end());
}

void start(const Substep& s) {
  s.implicit.start = s.points().position;
  s.implicit.startVelocity = s.points().velocity;
  const double tolerance = kContactsConverged * longest(s.springs());
  startSubstep(s.implicit.contacts, s.body.contacts, s.points().position.cols(), tolerance);
  guess(s);
}

/// Newton's method may overshoot where springs are strongly compressed. Either method may overshoot with
/// tetrahedra, or where a volume is far from its rest volume: the matrix contains the gradients of volumes
/// (the constant matrix those at rest), not the second derivatives.
bool mayOvershoot(const Substep& s) {
  if (s.implicit.solver.kind == MidpointSolver::Kind::Newton || s.body.tetrahedra) return true;
  return s.body.volumes && isFarFromRest(*s.body.volumes, s.points().position);
}

void shortenStep(const Substep& s) {
  if (!mayOvershoot(s)) return;
  const Points& x = s.points().position;
  Points& step = s.implicit.residual;
  const double before = objective(s, x);
  for (int i = 0; i < kMaxImplicitHalvings; ++i) {
    s.implicit.trial = x + step;
    if (objective(s, s.implicit.trial) <= before) return;
    step *= 0.5;
  }
}

/// Computes the loads for this iteration's step, and adds their effect to the step.
void solveContacts(const Substep& s) {
  ImplicitState& state = s.implicit;
  MidpointContacts& contacts = state.contacts;
  state.trial = s.points().position + state.residual;
  solveLoads(contacts, state.solver, state.trial, state.start, s.span());
  for (RowLoad& load : contacts.loads) load.load += load.change;
  state.trial.setZero();
  addLoads(contacts, &RowLoad::change, state.trial);
  solve(state.solver, state.trial);
  state.residual += state.trial;
}

/// Makes one iteration; returns the largest movement of a point (m). The step replaces the residual.
double iterate(const Substep& s, int iteration) {
  ImplicitState& state = s.implicit;
  computeForces(s, iteration < (s.euler ? 1 : kDamperRotations));
  update(state.solver, {s.springs(), s.body.tetrahedra}, state.damperDirection, s.points().position);
  if (s.body.volumes) updateVolumes(state.solver, *s.body.volumes, s.points());
  if (s.hasContacts() && (iteration == 0 || state.solver.kind == MidpointSolver::Kind::Newton))
    forgetResponse(state.contacts);
  computeResidual(s);
  solve(state.solver, state.residual);
  if (s.hasContacts()) solveContacts(s);
  if (!hasLoads(s.implicit.contacts)) shortenStep(s);
  s.points().position += state.residual;
  return state.residual.cwiseAbs().maxCoeff();
}

/// m: movement of all further iterations, if it falls by the same factor each time. Iterations with the
/// shared matrix approach the rotation of a stiff body about a pin very slowly: their last movement is no
/// measure of the error.
double remainder(double moved, double before) {
  constexpr double kSlowest = 0.999;
  const double factor = before > 0.0 ? std::min(moved / before, kSlowest) : 0.0;
  return moved * factor / (1.0 - factor);
}

/// Iterates to convergence or the limit; returns the last movement (m).
double solveMidpoint(const Substep& s) {
  const bool shared = s.implicit.solver.kind == MidpointSolver::Kind::Shared;
  const int maxIterations = shared ? kMaxSharedIterations : kMaxNewtonIterations;
  const double tolerance = kConverged * longest(s.springs());
  double moved = 0.0;
  for (int i = 0; i < maxIterations; ++i) {
    const double before = moved;
    moved = iterate(s, i);
    s.implicit.remainder = remainder(moved, before);
    if (moved <= tolerance || !std::isfinite(moved)) break;
  }
  return moved;
}

/// Does the same, and repeats it while the result leads through surfaces that the rows did not follow.
double solveFollowing(const Substep& s) {
  PointView atStart = viewOf(s.points());
  atStart.position = s.implicit.start.data();
  for (int repeats = kMaxRepeats;; --repeats) {
    const double lastMovement = solveMidpoint(s);
    if (repeats == 0 || !s.hasContacts() || !std::isfinite(lastMovement) ||
        !followDisplacement(s.implicit.contacts, s.points().position, atStart, s.span()))
      return lastMovement;
    guess(s);
  }
}

/// J, kinetic and elastic.
double energy(SolverBody& body) {
  return kineticEnergy(*body.points) + elasticEnergy(body, body.points->position);
}

/// J: work on the points since the start by the constant accelerations, by the constraints of held points,
/// and by contacts.
double work(const Substep& s) {
  const PointState& p = s.points();
  double sum = 0.0;
  for (Eigen::Index i = 0; i < p.position.cols(); ++i) {
    const Eigen::Vector3d moved = p.position.col(i) - s.implicit.start.col(i);
    sum += isHeld(p.inverseMass, i) ? -p.force.col(i).dot(moved)
                                    : massOf(p.inverseMass, i) * p.acceleration.col(i).dot(moved);
  }
  const MidpointContacts& c = s.implicit.contacts;
  for (std::size_t r = 0; r < c.loads.size(); ++r) {
    const auto point = (*c.rows)[r].point;
    sum += 4.0 / (s.h * s.h) * c.loads[r].load.dot(p.position.col(point) - s.implicit.start.col(point));
  }
  return sum;
}

/// Removes energy above the allowed swing from the motion, and updates the energy floor. Returns false, and
/// keeps the floor, if the motion has too little.
bool guardEnergy(const Substep& s) {
  ImplicitState& state = s.implicit;
  const double after = energy(s.body), floor = state.energyFloor + work(s);
  const double allowed = kEnergySwing * std::abs(state.energyFloor) + kEnergyRounding * std::abs(after);
  if (!std::isfinite(after)) return false;
  const double excess = after - floor - allowed;
  const double rest = excess > 0.0 ? removeKineticEnergy(s.points(), excess) : 0.0;
  if (rest > allowed) return false;
  state.energyFloor = std::min(floor, after - std::max(0.0, excess - rest));
  return true;
}

/// Sets the velocities of the free points to  2/h (x - x0) - (f - 1) v0, f = displacementFactor, and solves
/// their contacts.
void setVelocities(const Substep& s) {
  const double factor = s.span().displacementFactor;
  PointState& p = s.points();
  for (Eigen::Index i = 0; i < p.position.cols(); ++i)
    if (!isHeld(p.inverseMass, i))
      p.velocity.col(i) = 2.0 / s.h * (p.position.col(i) - s.implicit.start.col(i)) -
                          (factor - 1.0) * s.implicit.startVelocity.col(i);
  if (s.hasContacts()) finishSpan(s.implicit.contacts, p, s.span());
}

/// Restores the angular momentum of a free body, which unfinished iterations do not conserve (unlike linear
/// momentum). It changes only by the torque of the constant accelerations, from `before` at the start.
void keepSpin(const Substep& s, const Eigen::Vector3d& before) {
  PointState& p = s.points();
  if (hasLoads(s.implicit.contacts) || (p.inverseMass.array() == 0.0).any()) return;
  double mass = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), spin = before;
  for (Eigen::Index i = 0; i < p.position.cols(); ++i) {
    mass += massOf(p.inverseMass, i);
    center += 0.5 * massOf(p.inverseMass, i) * (p.position.col(i) + s.implicit.start.col(i));
  }
  center /= mass;
  for (Eigen::Index i = 0; i < p.position.cols(); ++i) {
    const Eigen::Vector3d r = 0.5 * (p.position.col(i) + s.implicit.start.col(i)) - center;
    spin += s.span().duration * massOf(p.inverseMass, i) * r.cross(Eigen::Vector3d(p.acceleration.col(i)));
  }
  setSpin(p, spin);
}

/// Sets the state and the contacts' impulses to those of the start.
void restart(const Substep& s) {
  undo(s.implicit.contacts);
  s.points().position = s.implicit.start;
  s.points().velocity = s.implicit.startVelocity;
}

/// Makes half a substep of backward Euler, which has the equation of the midpoint: x = x0 + h/2 v,
/// v = v0 + h/2 (a + M^-1 f(x)). Returns false if this adds energy.
bool stepHalfByEuler(const Substep& s, const Eigen::Vector3d& spin) {
  PointState& p = s.points();
  guess(s);
  solveFollowing(s);
  computeForces(s, false);
  setVelocities(s);
  // restoring the spin that dampers reduce in a straight step may need more energy than there is
  s.implicit.trial = p.velocity;
  keepSpin(s, spin);
  if (guardEnergy(s)) return true;
  p.velocity = s.implicit.trial;
  return guardEnergy(s);
}

/// Returns false if neither guess leads to a motion without additional energy.
bool advanceHalfByEuler(const Substep& s) {
  const Eigen::Vector3d spin = spinOf(s.points());
  start(s);
  if (stepHalfByEuler(s, spin)) return true;
  restart(s);
  Substep downhill = s;
  downhill.downhill = true;
  start(downhill);
  return stepHalfByEuler(downhill, spin);
}

/// m/s, root mean square: the midpoint rule's phase error (omega h)^2 / 12 (compare verletErrorRate), and the
/// remainder of the iterations.
double errorRate(const Substep& s) {
  const PointState& p = s.points();
  Points& mean = s.implicit.meanAcceleration;
  s.implicit.trial = p.force.cwiseProduct(p.inverseMass);
  const double change = s.implicit.meanOver == s.h ? (s.implicit.trial - mean).squaredNorm() : 0.0;
  mean = s.implicit.trial;
  s.implicit.meanOver = s.h;
  return 2.0 * verletErrorRate(change, p.position.cols(), s.h) + s.implicit.remainder / s.h;
}

/// Returns false if no rule gives a motion without additional energy: rounding errors or friction prevail.
bool advance(const Substep& s) {
  const Eigen::Vector3d spin = spinOf(s.points());
  start(s);
  const double lastMovement = solveFollowing(s);
  computeForces(s, false);
  s.body.errorRate = std::max(s.body.errorRate, errorRate(s));
  if (lastMovement <= kNearlyConverged * longest(s.springs())) {
    s.points().position = 2.0 * s.points().position - s.implicit.start;
    setVelocities(s);
    keepSpin(s, spin);
    if (guardEnergy(s)) return true;
  }
  restart(s);
  for (const double half : {0.0, 0.5}) {
    Substep euler{s.body, s.implicit, s.time + half * s.h, s.h};
    euler.euler = true;
    if (!advanceHalfByEuler(euler)) return false;
  }
  return true;
}

/// Applies the drag after a substep. The energy that it takes or gives does not count as an error.
void dragAfter(const Substep& s) {
  if (!s.body.drag) return;
  PointDrag& drag = *s.body.drag;
  drag.measured = true;
  const double before = drag.work;
  applyDrag(s.body, viewOf(s.points()), s.h);
  s.implicit.energyFloor += drag.work - before;
}

std::size_t countPoints(const std::vector<PlaneContact>& rows) {
  std::size_t count = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) count += r == 0 || rows[r].point != rows[r - 1].point;
  return count;
}

}  // namespace

bool canStepImplicitly(const SolverBody& body) {
  if (body.springs->size() == 0) return false;
  if ((*body.springs)->limited || (body.tetrahedra && !(*body.tetrahedra)->edgesAreSprings)) return false;
  if (body.volumes && (*body.volumes)->restVolume.size() > kMaxSolvedVolumes) return false;
  const Points& w = body.points->inverseMass;
  if (w.row(0) != w.row(1) || w.row(0) != w.row(2)) return false;
  if (!body.contacts) return true;
  const auto moves = [](const PlaneContact& row) {
    return !row.surfaceVelocity.isZero(0.0) || row.restitution > 0.0;
  };
  return countPoints(*body.contacts) <= kMaxMidpointPoints &&
         std::none_of(body.contacts->begin(), body.contacts->end(), moves);
}

bool stepImplicit(SolverBody& body, ImplicitState& implicit, MidpointSolver::Kind kind, double tick,
                  int substeps, SharedFactors& factors) {
  const double h = tick / substeps;
  implicit.solver.kind = kind;
  prepareVolumes(body, 0.0);
  prepare(implicit.solver, {*body.springs, body.tetrahedra}, body.points->inverseMass, h, factors);
  implicit.residual.resizeLike(body.points->position);
  implicit.trial.resizeLike(body.points->position);
  body.errorRate = 0.0;
  startDrag(body);
  implicit.energyAtStart = energy(body);
  implicit.energyFloor += implicit.energyAtStart - implicit.energyAtEnd;
  implicit.floorAtStart = implicit.energyFloor;
  for (int i = 0; i < substeps; ++i) {
    if (body.watch && body.watch->on) {
      body.watch->look(viewOf(*body.points), i * h, h);
      body.watch->merge();
    }
    if (body.contacts) followSurfaces(*body.contacts, viewOf(*body.points), h);
    const Substep substep{body, implicit, i * h, h, false};
    if (!advance(substep)) return false;
    dragAfter(substep);
  }
  implicit.energyAtEnd = energy(body);
  return true;
}

}  // namespace limber

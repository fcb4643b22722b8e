// SPDX-License-Identifier: Zlib
#include "stability/stability.h"

#include "mesh/linear_algebra.h"
#include "results.h"
#include "scene/reference.h"
#include "timing.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace limber::bench {

// --- energy and momentum ---

namespace {

constexpr double kUnit = 0.5 * double(std::numeric_limits<btScalar>::epsilon());

void addSpring(double stiffness, double restLength, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
               Energy& sum) {
  const double elongation = (b - a).norm() - restLength, error = kUnit * (a.norm() + b.norm());
  sum.value += 0.5 * stiffness * elongation * elongation;
  sum.rounding += stiffness * (std::abs(elongation) * error + 0.5 * error * error);
}

void addKinetic(double energy, Energy& sum) {
  sum.value += energy;
  sum.rounding += 2.0 * kUnit * energy;
}

}  // namespace

EnergyBalance::EnergyBalance(const HardCase& hard) : hard_(hard) {
  for (const BodySetup& body : hard.bodies) starts_.push_back(startOf(body));
}

void EnergyBalance::addPotential(double mass, const Eigen::Vector3d& x, Energy& sum) const {
  sum.value -= mass * hard_.gravity.y() * (x.y() - hard_.lowest);
  sum.rounding += mass * hard_.gravity.norm() * kUnit * x.norm();
}

void EnergyBalance::addBody(const BodyStates& states, std::size_t body, Energy& sum) const {
  const Eigen::Matrix3Xd &x = states.positions[body], &v = states.velocities[body];
  const BodyStart& start = starts_[body];
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    addKinetic(0.5 * start.masses[i] * v.col(i).squaredNorm(), sum);
    addPotential(start.masses[i], x.col(i), sum);
  }
  const auto& springs = hard_.bodies[body].network->springs;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto i = static_cast<Eigen::Index>(s);
    addSpring(start.stiffnesses[i], start.restLengths[i], x.col(springs[s].a), x.col(springs[s].b), sum);
  }
}

void EnergyBalance::addRigid(const btRigidBody& body, Energy& sum) const {
  if (body.isStaticOrKinematicObject()) return;
  const double mass = 1.0 / double(body.getInvMass());
  const btVector3 spin = body.getWorldTransform().getBasis().transpose() * body.getAngularVelocity();
  const Eigen::Vector3d omega = fromBullet(spin), inverse = fromBullet(body.getInvInertiaDiagLocal());
  addKinetic(0.5 * mass * fromBullet(body.getLinearVelocity()).squaredNorm(), sum);
  addKinetic(0.5 * omega.cwiseAbs2().cwiseQuotient(inverse).sum(), sum);
  addPotential(mass, fromBullet(body.getWorldTransform().getOrigin()), sum);
}

Energy EnergyBalance::energy(const BodyStates& states, const RigidBodies& rigid) const {
  Energy sum;
  for (std::size_t body = 0; body < starts_.size(); ++body) addBody(states, body, sum);
  for (const ExtraSpring& spring : hard_.springs)
    addSpring(spring.settings.stiffness, spring.settings.restLength.value(),
              states.positions[spring.a.body].col(spring.a.point),
              states.positions[spring.b.body].col(spring.b.point), sum);
  for (const auto& body : rigid.bodies) addRigid(*body, sum);
  return sum;
}

Eigen::Vector3d EnergyBalance::momentum(const BodyStates& states) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t body = 0; body < starts_.size(); ++body)
    sum += states.velocities[body] * starts_[body].masses;
  return sum;
}

double EnergyBalance::momentumScale(const BodyStates& states) const {
  double sum = 0.0;
  for (std::size_t body = 0; body < starts_.size(); ++body)
    sum += states.velocities[body].colwise().norm().dot(starts_[body].masses);
  return sum;
}

// --- shape ---

namespace {

/// Fraction of k times the size: the largest force on a point in equilibrium.
constexpr double kMaxBalanceForce = 1e-3;
/// Fraction of k: a curvature below minus this value is not a rounding error.
constexpr double kMinCurvature = 1e-3;

double largestChange(const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xd& rest) {
  double largest = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    for (Eigen::Index j = i + 1; j < x.cols(); ++j)
      largest =
          std::max(largest, std::abs((x.col(i) - x.col(j)).norm() - (rest.col(i) - rest.col(j)).norm()));
  return largest;
}

/// Returns the signed volume of the edges at the cube's first corner.
double handedness(const Eigen::Matrix3Xd& x) {
  const Eigen::Vector3d a = x.col(1) - x.col(0), b = x.col(2) - x.col(0), c = x.col(4) - x.col(0);
  return a.dot(b.cross(c));
}

Shape balancedShape(const ShapeQuestion& q) {
  const SpringDerivatives energy = springDerivatives(q.setup.network->springs, q.start, q.positions);
  const double k = q.start.stiffnesses.maxCoeff();
  if (energy.gradient.cwiseAbs().maxCoeff() > kMaxBalanceForce * k * q.size) return Shape::Lost;
  return limber::symmetricValues(energy.hessian)[0] < -kMinCurvature * k ? Shape::Saddle : Shape::Other;
}

/// Returns whether the rotation prevents the rest shape. A spring that provides the force m w^2 r for a point
/// alone is longer by m w^2 r / k. The rest shape is impossible if this exceeds the tolerance, where w is the
/// angular speed of a rigid body with the same angular momentum.
bool spinsTooFast(const ShapeQuestion& q) {
  const Eigen::VectorXd& m = q.start.masses;
  const Eigen::Vector3d centre = q.positions * m / m.sum();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < m.size(); ++i) {
    const Eigen::Vector3d r = q.positions.col(i) - centre;
    inertia += m[i] * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Eigen::Vector3d spin = spinOf(m, q.positions, q.velocities).momentum;
  const double omega = (limber::pseudoInverse(inertia) * spin).norm();
  const double radius = (q.positions.colwise() - centre).colwise().norm().maxCoeff();
  return m.maxCoeff() * omega * omega * radius > kShapeTolerance * q.size * q.start.stiffnesses.maxCoeff();
}

}  // namespace

const char* nameOf(Shape shape) {
  const char* const names[] = {"yes", "mirrored", "other balance", "saddle", "spinning", "no"};
  return names[static_cast<int>(shape)];
}

Spin spinOf(const Eigen::VectorXd& masses, const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xd& v) {
  const Eigen::Vector3d centre = x * masses / masses.sum(), flight = v * masses / masses.sum();
  Spin spin;
  for (Eigen::Index i = 0; i < masses.size(); ++i) {
    const Eigen::Vector3d r = x.col(i) - centre, u = v.col(i) - flight;
    spin.momentum += masses[i] * r.cross(u);
    spin.scale += masses[i] * r.norm() * u.norm();
  }
  return spin;
}

ShapeCheck checkShape(const ShapeQuestion& q) {
  const Eigen::Matrix3Xd rest = restPositions(q.setup);
  ShapeCheck check;
  check.error = largestChange(q.positions, rest) / q.size;
  if (check.error <= kShapeTolerance)
    check.shape = handedness(q.positions) * handedness(rest) > 0.0 ? Shape::Rest : Shape::Mirrored;
  else if (spinsTooFast(q))
    check.shape = Shape::Spinning;
  else if (q.alone)
    check.shape = balancedShape(q);
  return check;
}

// --- runs ---

namespace {

constexpr double kEnergyTarget = 1.001, kDriftTarget = 1e-6, kSpinTarget = 1e-3;

/// A value of a case, and whether it misses its target.
struct Check {
  const char* measure;
  std::optional<double> value;  ///< empty: the case does not ask for it
  std::optional<bool> missed;   ///< empty: it has no target
};

std::vector<Check> checksOf(const CaseResult& r) {
  const auto above = [](const std::optional<double>& value, double limit) {
    return value && !(*value <= limit);  // NaN is above
  };
  const std::optional<double> shapeError = r.shape ? std::optional(r.shape->error) : std::nullopt;
  return {{"finite", r.finite, !r.finite},
          {"energy", r.energyRatio, above(r.energyRatio, kEnergyTarget + r.rounding)},
          {"energy, rounding", r.rounding, std::nullopt},
          {"momentum drift", r.drift, above(r.drift, kDriftTarget)},
          {"angular momentum drift", r.spinDrift, above(r.spinDrift, kSpinTarget)},
          {"shape error", shapeError, r.shape && r.shape->shape == Shape::Lost},
          {"points on the wrong side", r.wrongSide, above(r.wrongSide, 0.0)}};
}

constexpr double kMaxDistance = 1e6;  // multiple of the size

/// Checks that were not reached count as failures.
void setLost(const HardCase& hard, CaseResult& row) {
  row.finite = false;
  row.energyRatio = kLost;
  if (row.drift) row.drift = kLost;
  if (row.spinDrift) row.spinDrift = kLost;
  if (hard.recovers) row.shape = ShapeCheck{Shape::Lost, kLost};
  if (hard.allowed) row.wrongSide = double(hard.bodies[0].network->restPoints.size());
}

/// Returns the check with the largest error.
ShapeCheck worstShape(const HardCase& hard, const EnergyBalance& balance, const BodyStates& states) {
  const bool alone = hard.gravity.isZero() && hard.springs.empty();
  ShapeCheck worst{Shape::Rest, -1.0};
  for (std::size_t i = 0; i < hard.bodies.size(); ++i) {
    const ShapeCheck check = checkShape(
        {hard.bodies[i], balance.start(i), states.positions[i], states.velocities[i], hard.size, alone});
    if (check.error > worst.error) worst = check;
  }
  return worst;
}

/// Returns whether two points are at the same position.
bool coincide(const Eigen::Matrix3Xd& x, double size) {
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    for (Eigen::Index j = i + 1; j < x.cols(); ++j)
      if ((x.col(i) - x.col(j)).norm() < 1e-6 * size) return true;
  return false;
}

class CaseRun {
 public:
  /// Throws std::runtime_error if the engine does not support the case.
  CaseRun(const HardCase& hard, const EngineChoice& choice, double dt)
      : hard_(hard), dt_(dt), balance_(hard) {
    if (!hard.sees && choice.engine == "btSoftBody")
      throw std::runtime_error("btSoftBody does not see planes");
    engine_ = open(hard, choice, dt, rigid_);
    for (const ExtraSpring& spring : hard.springs) engine_->addSpring(spring.a, spring.b, spring.settings);
    states_ = statesOf(hard, *engine_);
    momentum_ = balance_.momentum(states_);
    momentumScale_ = balance_.momentumScale(states_);
    spin_ = spinNow().momentum;
    if (hard.energyFrom <= 0.0) startBalance();
  }

  void play(CaseResult& row, std::FILE* trace) {
    const long ticks = std::lround(hard_.seconds / dt_);
    for (long i = 1; i <= ticks && !lost_; ++i) {
      time_ = static_cast<double>(i) * dt_;
      if (hard_.drive) hard_.drive(rigid_, time_);
      engine_->tick(dt_);
      states_ = statesOf(hard_, *engine_);
      lost_ = isLost(states_, kMaxDistance * hard_.size);
      if (lost_) break;
      if (!balanceStarted_ && time_ >= hard_.energyFrom) startBalance();
      measure(row);
      if (trace) print(trace);
    }
    lost_ ? setLost(hard_, row) : judgeEnd(row);
  }

 private:
  void startBalance() {
    balanceStarted_ = true;
    startEnergy_ = energy_ = balance_.energy(states_, rigid_);
  }
  void measure(CaseResult& row) {
    energy_ = balance_.energy(states_, rigid_);
    const double excess =
        energy_.value - energy_.rounding - kEnergyTarget * (startEnergy_.value + startEnergy_.rounding);
    if (balanceStarted_ && excess > largestExcess_) {
      largestExcess_ = excess;
      row.energyRatio = energy_.value / startEnergy_.value;
      row.rounding = (energy_.rounding + kEnergyTarget * startEnergy_.rounding) / startEnergy_.value;
    }
    momentumScale_ = std::max(momentumScale_, balance_.momentumScale(states_));
    change_ = std::max(change_, (balance_.momentum(states_) - momentum_).norm());
    if (row.drift) row.drift = change_ / momentumScale_;
    measureSpin(row);
  }
  /// Measures the change of spin. It is relative to the largest spin that the points could have at a distance
  /// of one size from the centre with all the energy of the start, size * sqrt(2 m E), or to the observed one
  /// if that is larger: stiff damped bodies come to rest between two ticks.
  void measureSpin(CaseResult& row) {
    if (!row.spinDrift) return;
    const Spin spin = spinNow();
    const double possible = hard_.size * std::sqrt(2.0 * balance_.start(0).masses.sum() * startEnergy_.value);
    spinScale_ = std::max({spinScale_, spin.scale, possible});
    spinChange_ = std::max(spinChange_, (spin.momentum - spin_).norm());
    row.spinDrift = spinScale_ > 0.0 ? spinChange_ / spinScale_ : 0.0;
  }
  /// Returns the spin about the centre of mass of the first body. Its change is only measured in cases with
  /// one body.
  Spin spinNow() const {
    return spinOf(balance_.start(0).masses, states_.positions[0], states_.velocities[0]);
  }
  void judgeEnd(CaseResult& row) const {
    if (hard_.recovers) row.shape = worstShape(hard_, balance_, states_);
    // free bodies must not start to spin
    const bool spun = row.shape && row.shape->shape == Shape::Spinning && hard_.freeFlight;
    const bool leftSaddle = row.shape && row.shape->shape == Shape::Saddle && !hard_.startsInBalance;
    if (spun || leftSaddle) row.shape->shape = Shape::Lost;
    const bool lost = row.shape && row.shape->shape == Shape::Lost;
    if (lost && hard_.startsInBalance && coincide(states_.positions[0], hard_.size))
      row.shape->shape = Shape::Saddle;
    if (!hard_.allowed) return;
    row.wrongSide = 0.0;
    for (const Eigen::Matrix3Xd& points : states_.positions)
      for (Eigen::Index i = 0; i < points.cols(); ++i) *row.wrongSide += !hard_.allowed(points.col(i));
  }
  void print(std::FILE* trace) const {
    double fastest = 0.0, low = kLost;
    for (const Eigen::Matrix3Xd& v : states_.velocities)
      fastest = std::max(fastest, v.colwise().norm().maxCoeff());
    for (const Eigen::Matrix3Xd& x : states_.positions) low = std::min(low, x.row(1).minCoeff());
    std::fprintf(trace, "%.5f %.9g %.3e %.6g %.6g\n", time_,
                 balanceStarted_ ? energy_.value / startEnergy_.value : energy_.value,
                 change_ / momentumScale_, fastest, low);
  }

  const HardCase& hard_;
  double dt_, time_ = 0.0;
  EnergyBalance balance_;
  RigidBodies rigid_;  // before the engine: its world refers to them
  std::unique_ptr<Engine> engine_;
  BodyStates states_;
  bool balanceStarted_ = false, lost_ = false;
  Energy energy_, startEnergy_;                // J, now and when the balance started
  double largestExcess_ = -1e300;              // J, excess over the limit, minus rounding
  Eigen::Vector3d momentum_;                   // kg m/s, at the start
  double momentumScale_ = 0.0, change_ = 0.0;  // kg m/s
  Eigen::Vector3d spin_;                       // kg m^2/s, at the start
  double spinScale_ = 0.0, spinChange_ = 0.0;  // kg m^2/s
};

// --- the bench ---

/// Returns Limber with each stepper, and those settings of other engines that are most similar to the springs
/// and most stable.
std::vector<EngineChoice> stableEngines(const Options& options) {
  const std::string others[] = {"btSoftBody 4 iterations, calibrated",
                                "btSoftBody 10 iterations, full stiffness", "btDeformable implicit"};
  std::vector<EngineChoice> engines;
  for (EngineChoice& choice : allEngines()) {
    const std::string full = choice.engine + " " + choice.setting;
    if (choice.isLimber() || std::find(std::begin(others), std::end(others), full) != std::end(others))
      engines.push_back(std::move(choice));
  }
  return wantedEngines(engines, options);
}

std::vector<HardCase> wantedCases(const Options& options) {
  std::vector<HardCase> cases;
  const double seed = options.number("seed", 0);
  for (HardCase& hard : allHardCases(options.quick)) {
    if (seed > 0 && hard.seed != seed) continue;
    hard.name += ", seed " + std::to_string(hard.seed);
    cases.push_back(std::move(hard));
  }
  return wantedScenes(std::move(cases), options);
}

void addRows(const Subject& subject, const CaseResult& r, Results& results) {
  if (!r.reason.empty()) return results.note(subject, "no result", r.reason);
  for (const auto& [measure, value, missed] : checksOf(r)) {
    if (value) results.add(subject, measure, "", *value);
    if (value && missed) results.add(subject, std::string("missed: ") + measure, "", *missed);
  }
  if (r.shape) results.note(subject, "shape", nameOf(r.shape->shape));
  results.add(subject, "passed", "", passes(r));
}

void runStability(const Options& options, Results& results) {
  Progress progress;
  const std::vector<HardCase> cases = wantedCases(options);
  const std::vector<EngineChoice> engines = stableEngines(options);
  std::FILE* trace = options.word("trace") == "yes" ? stdout : nullptr;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    progress.show(cases[i].name, static_cast<double>(i) / static_cast<double>(cases.size()));
    for (const double rate : options.numbers("ticks", {30, 60}))
      for (const EngineChoice& choice : engines)
        addRows({cases[i].group, cases[i].name, choice.engine, choice.setting, rate},
                playCase(cases[i], choice, 1.0 / rate, trace), results);
    if (i + 1 == cases.size() || cases[i + 1].group != cases[i].group) progress.finish(cases[i].group);
  }
}

}  // namespace

bool passes(const CaseResult& result) {
  const std::vector<Check> checks = checksOf(result);
  return result.reason.empty() && std::none_of(checks.begin(), checks.end(), [](const Check& check) {
           return check.missed.value_or(false);
         });
}

CaseResult playCase(const HardCase& hard, const EngineChoice& choice, double dt, std::FILE* trace) {
  CaseResult row;
  const bool slowed = choice.engine == "btSoftBody" && hard.bodies[0].drag > 0.0;
  if (hard.freeFlight && !slowed) row.drift = 0.0;
  if (row.drift && hard.bodies.size() == 1) row.spinDrift = 0.0;
  try {
    CaseRun(hard, choice, dt).play(row, trace);
  } catch (const std::runtime_error& error) {
    row.reason = error.what();
  }
  return row;
}

Bench stabilityBench() {
  return {"stability",
          "hard cases: finite, energy, momentum, shape, right side",
          "5 minutes",
          withEngineKeys({{"ticks", "ticks per second", 1, 10000, true},
                          {"seed", "only cases with this seed", 1, 1e6},
                          {"trace",
                           "print time, energy over that at the start, drift of momentum, largest speed and "
                           "lowest height of each tick",
                           {"yes", "no"}}}),
          [](const Options& options) { return namesOf(wantedCases(options)); },
          &runStability};
}

}  // namespace limber::bench

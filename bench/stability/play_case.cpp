// SPDX-License-Identifier: Zlib
#include "stability/play_case.h"

#include "stability/energy_balance.h"

#include <algorithm>
#include <cmath>

namespace limber::bench {
namespace {

constexpr double kMaxDistance = 1e6;  // multiple of the size

class CaseRun {
 public:
  /// Throws std::runtime_error if the engine does not support the case.
  CaseRun(const HardCase& hard, const EngineChoice& choice, double dt);

  void play(StabilityRow& row, std::FILE* trace);

 private:
  BodyStates readStates() const;
  void startBalance();
  void measure(StabilityRow& row);
  void measureSpin(StabilityRow& row);
  /// Returns the spin about the centre of mass of the first body. Its change is only measured in cases with
  /// one body.
  Spin spinNow() const {
    return spinOf(balance_.start(0).masses, states_.positions[0], states_.velocities[0]);
  }
  void judgeEnd(StabilityRow& row) const;
  void print(std::FILE* trace) const;

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

CaseRun::CaseRun(const HardCase& hard, const EngineChoice& choice, double dt)
    : hard_(hard), dt_(dt), balance_(hard), engine_(choice.make(dt)) {
  if (!hard.sees && choice.engine == "btSoftBody") throw std::runtime_error("btSoftBody does not see planes");
  engine_->world().setGravity(toBullet(hard.gravity));
  if (hard.addRigidBodies) hard.addRigidBodies(rigid_, engine_->world());
  for (const BodySetup& body : hard.bodies) engine_->addBody(body);
  for (const ExtraSpring& spring : hard.springs) engine_->addSpring(spring.a, spring.b, spring.settings);
  states_ = readStates();
  momentum_ = balance_.momentum(states_);
  momentumScale_ = balance_.momentumScale(states_);
  spin_ = spinNow().momentum;
  if (hard.energyFrom <= 0.0) startBalance();
}

BodyStates CaseRun::readStates() const {
  BodyStates states;
  for (std::size_t i = 0; i < hard_.bodies.size(); ++i) {
    states.positions.push_back(engine_->positions(i));
    states.velocities.push_back(engine_->velocities(i));
  }
  return states;
}

void CaseRun::startBalance() {
  balanceStarted_ = true;
  startEnergy_ = energy_ = balance_.energy(states_, rigid_);
}

bool isLost(const BodyStates& states, double size) {
  for (std::size_t i = 0; i < states.positions.size(); ++i) {
    const Eigen::Matrix3Xd& x = states.positions[i];
    if (!x.allFinite() || !states.velocities[i].allFinite()) return true;
    if (x.cwiseAbs().maxCoeff() > kMaxDistance * size) return true;
  }
  return false;
}

void CaseRun::measure(StabilityRow& row) {
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
void CaseRun::measureSpin(StabilityRow& row) {
  if (!row.spinDrift) return;
  const Spin spin = spinNow();
  const double possible = hard_.size * std::sqrt(2.0 * balance_.start(0).masses.sum() * startEnergy_.value);
  spinScale_ = std::max({spinScale_, spin.scale, possible});
  spinChange_ = std::max(spinChange_, (spin.momentum - spin_).norm());
  row.spinDrift = spinScale_ > 0.0 ? spinChange_ / spinScale_ : 0.0;
}

/// Checks that were not reached count as failures.
void setLost(const HardCase& hard, StabilityRow& row) {
  row.finite = false;
  row.energyRatio = kLost;
  if (row.drift) row.drift = kLost;
  if (row.spinDrift) row.spinDrift = kLost;
  if (hard.recovers) row.shape = ShapeCheck{Shape::Lost, kLost};
  if (hard.allowed) row.wrongSide = hard.bodies[0].network->restPoints.size();
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

void CaseRun::judgeEnd(StabilityRow& row) const {
  if (hard_.recovers) row.shape = worstShape(hard_, balance_, states_);
  // free bodies must not start to spin
  const bool spun = row.shape && row.shape->shape == Shape::Spinning && hard_.freeFlight;
  const bool leftSaddle = row.shape && row.shape->shape == Shape::Saddle && !hard_.startsInBalance;
  if (spun || leftSaddle) row.shape->shape = Shape::Lost;
  const bool lost = row.shape && row.shape->shape == Shape::Lost;
  if (lost && hard_.startsInBalance && coincide(states_.positions[0], hard_.size))
    row.shape->shape = Shape::Saddle;
  if (!hard_.allowed) return;
  std::size_t wrong = 0;
  for (const Eigen::Matrix3Xd& points : states_.positions)
    for (Eigen::Index i = 0; i < points.cols(); ++i) wrong += hard_.allowed(points.col(i)) ? 0u : 1u;
  row.wrongSide = wrong;
}

void CaseRun::print(std::FILE* trace) const {
  double fastest = 0.0, low = kLost;
  for (const Eigen::Matrix3Xd& v : states_.velocities)
    fastest = std::max(fastest, v.colwise().norm().maxCoeff());
  for (const Eigen::Matrix3Xd& x : states_.positions) low = std::min(low, x.row(1).minCoeff());
  std::fprintf(trace, "%.5f %.9g %.3e %.6g %.6g\n", time_,
               balanceStarted_ ? energy_.value / startEnergy_.value : energy_.value, change_ / momentumScale_,
               fastest, low);
}

void CaseRun::play(StabilityRow& row, std::FILE* trace) {
  const long ticks = std::lround(hard_.seconds / dt_);
  for (long i = 1; i <= ticks && !lost_; ++i) {
    time_ = static_cast<double>(i) * dt_;
    if (hard_.drive) hard_.drive(rigid_, time_);
    engine_->tick(dt_);
    states_ = readStates();
    lost_ = isLost(states_, hard_.size);
    if (lost_) break;
    if (!balanceStarted_ && time_ >= hard_.energyFrom) startBalance();
    measure(row);
    if (trace) print(trace);
  }
  lost_ ? setLost(hard_, row) : judgeEnd(row);
}

}  // namespace

StabilityRow playCase(const HardCase& hard, const EngineChoice& choice, double dt, std::FILE* trace) {
  StabilityRow row;
  row.group = hard.group, row.name = hard.name, row.seed = hard.seed, row.stiffness = hard.stiffness;
  row.engine = choice.engine, row.setting = choice.setting, row.dt = dt;
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

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#include "stability/energy_balance.h"

#include <limits>

namespace limber::bench {
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

void EnergyBalance::addPoints(const BodyStates& states, std::size_t body, Energy& sum) const {
  const Eigen::Matrix3Xd &x = states.positions[body], &v = states.velocities[body];
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double mass = starts_[body].masses[i];
    addKinetic(0.5 * mass * v.col(i).squaredNorm(), sum);
    addPotential(mass, x.col(i), sum);
  }
}

void EnergyBalance::addSprings(const BodyStates& states, std::size_t body, Energy& sum) const {
  const BodyStart& start = starts_[body];
  const Eigen::Matrix3Xd& x = states.positions[body];
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
  for (std::size_t body = 0; body < starts_.size(); ++body) {
    addPoints(states, body, sum);
    addSprings(states, body, sum);
  }
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

}  // namespace limber::bench

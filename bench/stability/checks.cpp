// SPDX-License-Identifier: Zlib
#include "mesh/linear_algebra.h"
#include "scene/reference.h"
#include "stability/stability.h"

#include <Eigen/Geometry>

#include <algorithm>
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

}  // namespace limber::bench

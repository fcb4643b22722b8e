// SPDX-License-Identifier: Zlib
#include "stability/case_parts.h"

#include "accuracy/bodies.h"
#include "text_format.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace limber::bench {
namespace {

constexpr double kMaxDrag = 2.0;                    // 1/s, so that a body with drag still falls
constexpr double kDragOfFalling = 2.0;              // 1/s: a body with drag must still fall
constexpr double kShortest = 2.0, kLongest = 60.0;  // s

}  // namespace

double Dice::within(double limit) { return limit * (2.0 * (double(engine_()) / 4294967296.0) - 1.0); }

Eigen::Vector3d Dice::vector(double limit) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = within(limit);
  return v;
}

Eigen::Matrix3Xd Dice::vectors(Eigen::Index count, double limit) {
  Eigen::Matrix3Xd all(3, count);
  for (Eigen::Index i = 0; i < count; ++i) all.col(i) = vector(limit);
  return all;
}

Eigen::Vector3d Dice::direction() {
  Eigen::Vector3d v = vector(1.0);
  while (v.squaredNorm() > 1.0 || v.squaredNorm() < 0.01) v = vector(1.0);
  return v.normalized();
}

Eigen::Quaterniond Dice::rotation() {
  const double angle = within(3.1);
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, direction()));
}

BodySetup hardCube(double stiffness, double damping, double size, double mass) {
  const double pointMass = mass / 8, critical = 2.0 * std::sqrt(stiffness * pointMass / 2.0);
  BodySetup body = bodyOf(closedCubeNetwork(), mass, stiffness, damping * critical);
  body.settings.scale.setConstant(size);
  return body;
}

Eigen::Matrix3Xd restPositions(const BodySetup& body) {
  const SoftBodySettings& s = body.settings;
  const auto& rest = body.network->restPoints;
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(rest.size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = s.position + s.rotation * rest[static_cast<std::size_t>(i)].cwiseProduct(s.scale);
  return points;
}

double settleTime(const BodySetup& cube) {
  const auto& fractions = cube.network->massFractions;
  const double heaviest = cube.settings.totalMass * *std::max_element(fractions.begin(), fractions.end());
  const double k = cube.settings.extensionStiffness, c = cube.settings.damping;
  const double slowest = std::sqrt(k / heaviest);
  return 10.0 / std::min(0.5 * c / k * slowest * slowest, k / c);
}

HardCase caseOf(const std::string& group, const std::string& name, unsigned seed, const BodySetup& cube) {
  HardCase hard;
  hard.group = group;
  hard.name = group + " " + name;
  hard.seed = seed;
  hard.stiffness = cube.settings.extensionStiffness;
  hard.size = cube.settings.scale.x();
  hard.bodies = {cube};
  return hard;
}

void setFree(HardCase& hard, Dice& dice) {
  hard.freeFlight = true;
  const Eigen::Vector3d flight = 0.1 * hard.size * dice.direction();
  for (BodySetup& body : hard.bodies) {
    body.settings.linearVelocity += flight;
    if (body.velocities.cols()) body.velocities.colwise() += flight;
  }
}

void letSettle(HardCase& hard) {
  hard.recovers = true;
  BodySetup& body = hard.bodies[0];
  hard.seconds = wholeTicks(std::clamp(settleTime(body), kShortest, kLongest));
  body.drag = 20.0 / hard.seconds;
}

void letFall(HardCase& hard, double seconds) {
  hard.gravity.y() = -kGravity;
  hard.seconds = seconds;
  for (BodySetup& body : hard.bodies) body.drag = std::min(body.drag, kDragOfFalling);
}

std::string exponentName(const char* what, double value) { return format("%s %.0e", what, value); }

}  // namespace limber::bench

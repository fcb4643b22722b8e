// SPDX-License-Identifier: Zlib
#include "bullet_soft/body_start.h"

#include <stdexcept>

namespace limber::bullet_soft {
namespace {

Eigen::Matrix3Xd initialPositions(const SpringNetwork& network, const SoftBodySettings& s) {
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(network.restPoints.size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) =
        s.position + s.rotation * network.restPoints[static_cast<std::size_t>(i)].cwiseProduct(s.scale);
  return points;
}

/// Returns the velocities of the points. Bodies rotate about their centre of mass.
Eigen::Matrix3Xd initialVelocities(const Eigen::Matrix3Xd& points, const Eigen::VectorXd& masses,
                                   const SoftBodySettings& s) {
  const Eigen::Vector3d centre = points * masses / masses.sum();
  Eigen::Matrix3Xd velocities(3, points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    velocities.col(i) = s.linearVelocity + s.angularVelocity.cross(points.col(i) - centre);
  return velocities;
}

/// Rounds to Bullet's numbers, in which every engine receives given positions.
Eigen::Matrix3Xd rounded(const Eigen::Matrix3Xd& points) { return points.cast<btScalar>().cast<double>(); }

void fillSprings(const BodySetup& setup, const Eigen::Matrix3Xd& rest, BodyStart& start) {
  const auto& springs = setup.network->springs;
  const auto count = static_cast<Eigen::Index>(springs.size());
  start.restLengths.resize(count);
  start.stiffnesses.resize(count);
  start.dampings.resize(count);
  for (Eigen::Index s = 0; s < count; ++s) {
    const NetworkSpring& spring = springs[static_cast<std::size_t>(s)];
    start.restLengths[s] = (rest.col(spring.b) - rest.col(spring.a)).norm();
    start.stiffnesses[s] = spring.stiffnessScale * setup.settings.extensionStiffness;
    start.dampings[s] = spring.stiffnessScale * setup.settings.damping;
  }
}

}  // namespace

BodyStart startOf(const BodySetup& setup) {
  const SoftBodySettings& s = setup.settings;
  if (s.extensionStiffness != s.compressionStiffness)
    throw std::runtime_error("springs that pull and push differently are Limber's alone");
  BodyStart start;
  const auto shares = Eigen::Map<const Eigen::VectorXd>(
      setup.network->massFractions.data(), static_cast<Eigen::Index>(setup.network->massFractions.size()));
  start.masses = s.totalMass * shares;
  const Eigen::Matrix3Xd rest = initialPositions(*setup.network, s);
  fillSprings(setup, rest, start);
  start.velocities = setup.velocities.cols() ? setup.velocities : initialVelocities(rest, start.masses, s);
  start.positions = setup.positions.cols() ? rounded(setup.positions) : rest;
  return start;
}

}  // namespace limber::bullet_soft

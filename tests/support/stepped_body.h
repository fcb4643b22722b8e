// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"
#include "solver/springs.h"
#include "solver/verlet_step.h"

#include <limber/spring_network.h>

#include <Eigen/Geometry>

#include <cmath>

namespace limber::test {

/// A body in its rest shape, to test the steppers without a world.
struct SteppedTestBody {
  SteppedTestBody(const SharedNetwork& network, double stiffness, double damping, double totalMass = 1.0)
      : net(network) {
    settings.extensionStiffness = settings.compressionStiffness = stiffness;
    settings.damping = damping;
    springs = makeSprings(*network, settings);
    volumes = makeVolumes(*network, settings);
    tetrahedra = makeTetrahedronVolumes(*network, settings);
    state.resize(static_cast<Eigen::Index>(network->restPoints.size()));
    for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
      state.position.col(i) = network->restPoints[static_cast<std::size_t>(i)];
      const double mass = totalMass * network->massFractions[static_cast<std::size_t>(i)];
      state.inverseMass.col(i).setConstant(1.0 / mass);
    }
    group.bodies.push_back({&state, &springs, nullptr});
    if (!volumes.empty()) group.bodies[0].volumes = &volumes;
    if (!tetrahedra.empty()) group.bodies[0].tetrahedra = &tetrahedra;
    tetrahedronFrequencyBoundSquared(tetrahedra, state);
    group.links.points.push_back(&state);
  }
  SteppedTestBody(const SteppedTestBody&) = delete;
  SteppedTestBody& operator=(const SteppedTestBody&) = delete;

  /// Deforms the body, moves its points in all directions and lets it fall; the first point is held.
  void disturb() {
    for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
      const double t = static_cast<double>(i);
      state.position.col(i) *= 1.1;
      state.position.col(i) += 0.02 * Eigen::Vector3d(std::sin(t), std::cos(3 * t), std::sin(5 * t));
      state.velocity.col(i) = Eigen::Vector3d(std::cos(t), -1.0, 0.3 * std::sin(2 * t));
      state.acceleration.col(i) = Eigen::Vector3d(0.0, -9.81, 0.0);
    }
    state.inverseMass.col(0).setZero();
  }
  void spin(const Eigen::Vector3d& omega) {
    for (Eigen::Index i = 0; i < state.position.cols(); ++i)
      state.velocity.col(i) += omega.cross(Eigen::Vector3d(state.position.col(i)));
  }
  double energy() { return kineticEnergy(state) + elasticEnergy(group.bodies[0], state.position); }

  SolverBody& stepped() {
    group.bodies[0].contacts = contacts;
    return group.bodies[0];
  }

  SharedNetwork net;
  SoftBodySettings settings;
  PointState state;
  SpringArrays springs;
  VolumeArrays volumes;
  TetrahedronVolumes tetrahedra;
  std::vector<PlaneContact>* contacts = nullptr;
  SolverIsland group;
};

}  // namespace limber::test

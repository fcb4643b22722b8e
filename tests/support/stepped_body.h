// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"
#include "solver/springs.h"
#include "solver/verlet_step.h"

#include <limber/spring_network.h>

#include <Eigen/Geometry>

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
    group.links.points.push_back(&state);
  }
  SteppedTestBody(const SteppedTestBody&) = delete;
  SteppedTestBody& operator=(const SteppedTestBody&) = delete;

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

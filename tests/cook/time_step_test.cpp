// SPDX-License-Identifier: Zlib
#include "analysis/analysis.h"

#include "mesh/random.h"
#include "network/stability.h"
#include "solver/springs.h"
#include "solver/verlet_step.h"
#include "solver/volumes.h"
#include "support/network_shapes.h"
#include "support/networks.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <optional>

using limber::SharedNetwork;
using limber::SoftBodySettings;
using limber::TimeSteps;
using limber::timeSteps;
using network_shapes::bare;

namespace {

SoftBodySettings settingsOf(double stiffness, double totalMass) {
  SoftBodySettings settings;
  settings.extensionStiffness = settings.compressionStiffness = stiffness;
  settings.damping = 0.0;
  settings.totalMass = totalMass;
  return settings;
}

void disturb(limber::PointState& state) {
  limber::Random random(1);
  for (double& x : state.position.reshaped()) x += 1e-9 * (random.uniform() - 0.5);
}

/// Whether a disturbance of a billionth of the size grows by a factor of 1000 in 400 substeps of `dt`. A step
/// that is too long by a fraction e multiplies the stiffest oscillation by exp(2 sqrt(2 e)) each time.
bool blowsUp(const SharedNetwork& network, const SoftBodySettings& settings, double dt) {
  limber::PointState state = restState(*network, settings);
  const limber::Points rest = state.position;
  disturb(state);
  limber::SpringArrays springs = makeSprings(*network, settings);
  limber::VolumeArrays volumes = makeVolumes(*network, settings);
  limber::SolverIsland island;
  island.bodies.push_back({&state, &springs, nullptr});
  if (!volumes.empty()) island.bodies[0].volumes = &volumes;
  island.links.points.push_back(&state);
  stepVerlet(island, 400 * dt, 400);
  return !((state.position - rest).cwiseAbs().maxCoeff() < 1e-6);
}

/// The same without the limit on volume terms that stabilises steps that are too long for them. The
/// symplectic Euler method has the same stability limit as Verlet's.
bool blowsUpUnlimited(const SharedNetwork& network, const SoftBodySettings& settings, double dt) {
  limber::PointState state = restState(*network, settings);
  const limber::Points rest = state.position;
  disturb(state);
  limber::BodyTerms terms(*network, settings);
  limber::SolverBody body = solverBody(terms, state);
  prepareVolumes(body, 0.0);
  for (int i = 0; i < 400; ++i) {
    computeElasticForces(body);
    state.velocity += dt * state.force.cwiseProduct(state.inverseMass);
    state.position += dt * state.velocity;
  }
  return !((state.position - rest).cwiseAbs().maxCoeff() < 1e-6);
}

double simulatedBlowUp(const SharedNetwork& network, const SoftBodySettings& settings, double guess,
                       decltype(blowsUp)& blows = blowsUp) {
  double stable = 0.5 * guess, unstable = 2.0 * guess;
  EXPECT_FALSE(blows(network, settings, stable));
  EXPECT_TRUE(blows(network, settings, unstable));
  while (unstable / stable > 1.001) {
    const double middle = 0.5 * (stable + unstable);
    (blows(network, settings, middle) ? unstable : stable) = middle;
  }
  return unstable;
}

}  // namespace

TEST(TimeSteps, valuesOfTheNotes) {
  // the paper's cubes without volume term: 0.125 kg at each point, 20 N/m
  SoftBodySettings settings = settingsOf(20.0, 1.0);
  settings.volumeModulus = 0.0;
  EXPECT_NEAR(timeSteps(*bare(network_shapes::cube8()), settings).critical, 0.07403, 1e-5);
  EXPECT_NEAR(timeSteps(*limber::test::cubeNetwork(), settings).critical, 0.06455, 1e-5);
  EXPECT_NEAR(timeSteps(*limber::test::fullCubeNetwork(), settings).critical, 0.0559, 1e-5);
}

TEST(TimeSteps, twoPercentOfTheBlowUp) {
  for (const auto make : {network_shapes::cube8, network_shapes::ico42, network_shapes::lshape90,
                          network_shapes::torus128, network_shapes::noise162}) {
    for (const std::optional<double> volumeModulus : {std::optional<double>(), std::optional(0.0)}) {
      const SharedNetwork network = bare(make());
      SoftBodySettings settings = settingsOf(1000.0, 3.0);
      settings.volumeModulus = volumeModulus;
      const TimeSteps steps = timeSteps(*network, settings);
      const double blowUp = simulatedBlowUp(network, settings, steps.critical) / steps.critical;
      EXPECT_GE(blowUp, 0.98);
      // a step that is too long weakens the volume term, and so becomes stable again
      if (volumeModulus == 0.0) {
        EXPECT_LE(blowUp, 1.02);
      }
      EXPECT_LE(steps.safe, steps.critical);
      EXPECT_GT(steps.safe, 0.3 * steps.critical) << "a bound of use";
    }
  }
}

TEST(TimeSteps, twoPercentOfTheBlowUpOfMaterials) {
  limber::MaterialMesh coarse;
  coarse.points = 60;
  for (const auto& mesh : {network_shapes::cube8(), network_shapes::ico42()}) {
    const SharedNetwork network = *buildMaterialNetwork(mesh, coarse);
    for (const double poissonRatio : {0.25, 0.3, 0.45}) {
      limber::Material material;
      material.poissonRatio = poissonRatio;
      SoftBodySettings settings = *withMaterial(*network, material, {});
      settings.damping = 0.0;
      const TimeSteps steps = timeSteps(*network, settings);
      EXPECT_NEAR(simulatedBlowUp(network, settings, steps.critical, blowsUpUnlimited) / steps.critical, 1.0,
                  0.02)
          << poissonRatio;
      EXPECT_LE(steps.safe, steps.critical);
      EXPECT_GT(steps.safe, 0.3 * steps.critical) << "a bound of use";
      EXPECT_FALSE(blowsUp(network, settings, 0.98 * steps.critical)) << "the hold does no harm";
    }
  }
}

TEST(TimeSteps, unevenMassesScalesAndSprings) {
  limber::SpringNetwork uneven = *bare(network_shapes::hull60());
  limber::Random random(1);
  double sum = 0.0;
  for (double& fraction : uneven.massFractions) sum += fraction = 0.2 + random.uniform();
  for (double& fraction : uneven.massFractions) fraction /= sum;
  for (auto& s : uneven.springs) s.stiffnessScale = 0.3 + random.uniform();
  SoftBodySettings settings = settingsOf(50.0, 0.5);
  settings.scale = {2.0, 0.5, 1.0};
  const auto network = std::make_shared<limber::SpringNetwork>(uneven);
  const TimeSteps steps = timeSteps(uneven, settings);
  EXPECT_NEAR(simulatedBlowUp(network, settings, steps.critical) / steps.critical, 1.0, 0.02);
}

TEST(TimeSteps, nothingStiff) {
  const SharedNetwork pair = limber::test::pairNetwork();
  EXPECT_EQ(timeSteps(*pair, settingsOf(0.0, 1.0)).critical, HUGE_VAL);
  // two masses of m/2 on a spring: omega^2 = 4 k / m
  EXPECT_NEAR(timeSteps(*pair, settingsOf(100.0, 4.0)).critical, 2.0 / std::sqrt(100.0), 1e-9);
}

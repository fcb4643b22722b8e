// SPDX-License-Identifier: Zlib
// The volume term alone and in all steppers, compared with closed forms and conservation laws.
#include "mesh/linear_algebra.h"
#include "solver/implicit_step.h"
#include "solver/point_state.h"
#include "solver/stepping_choice.h"
#include "solver/volumes.h"
#include "support/networks.h"
#include "support/small_meshes.h"
#include "support/stepped_body.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <cmath>

namespace limber {
namespace {

using test::SteppedTestBody;

SharedNetwork bare(const TriangleMesh& mesh) {
  NetworkSettings settings;
  settings.braces = BraceRule::None;
  settings.braceWeight = 1.0;
  return *buildNetwork(mesh, settings);
}

VolumeArrays volumesOf(const SharedNetwork& network, double modulus, double pressure,
                       const Eigen::Vector3d& scale = Eigen::Vector3d::Ones(), double ambientPressure = 0.0) {
  SoftBodySettings settings;
  settings.volumeModulus = modulus;
  settings.pressure = pressure;
  settings.ambientPressure = ambientPressure;
  settings.scale = scale;
  return makeVolumes(*network, settings);
}

/// Returns the signed volume (m^3) of all components: the work against an ambient pressure of 1 Pa.
double enclosedVolume(const VolumeArrays& volumes, const Points& position) {
  VolumeConstants constants = *volumes.constants;
  constants.modulus = constants.gasPressure = 0.0;
  constants.ambient = 1.0;
  VolumeArrays inAir = volumes;
  inAir.constants = SharedConstants<VolumeConstants>(constants);
  double sum = volumeEnergy(inAir, position);
  for (const double rest : constants.restVolume) sum += rest;
  return sum;
}

PointState stateOf(const SharedNetwork& network, double noise) {
  PointState state;
  state.resize(static_cast<Eigen::Index>(network->restPoints.size()));
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    const double t = static_cast<double>(i);
    state.position.col(i) = network->restPoints[static_cast<std::size_t>(i)] +
                            noise * Eigen::Vector3d(std::sin(3 * t), std::cos(5 * t), std::sin(7 * t + 1));
  }
  state.inverseMass.setConstant(static_cast<double>(state.position.cols()));
  return state;
}

TEST(VolumeTerm, knowsTheVolumesOfTheCubeAndItsMirrorImage) {
  const SharedNetwork cube = test::closedCubeNetwork();
  PointState state = stateOf(cube, 0.0);
  VolumeArrays v = volumesOf(cube, 1.0, 0.0);
  EXPECT_NEAR(enclosedVolume(v, state.position), 1.0, 1e-15);
  state.position.row(0) *= -2.0;
  EXPECT_NEAR(enclosedVolume(v, state.position), -2.0, 1e-15);
  state.position.colwise() += Eigen::Vector3d(1e6, 1e6, 0.0);
  EXPECT_NEAR(enclosedVolume(v, state.position), -2.0, 1e-9) << "far from the origin";
  EXPECT_NEAR(volumesOf(cube, 1.0, 0.0, {-1, 2, 3})->restVolume[0], 6.0, 1e-14) << "mirrored by its scale";
}

TEST(VolumeTerm, hasTheGradientOfItsEnergyAsForceAndNoNetForceOrTorque) {
  const SharedNetwork ball = bare(small_meshes::icosphere(1));
  for (const double size :
       {1.0, 0.3, 1.6})  // in the linear range, with the gas at its limit, with the swelling at its limit
    for (const auto& [pressure, ambient] :
         {std::pair(0.0, 0.0), std::pair(40.0, 0.0), std::pair(40.0, 70.0)}) {
      SCOPED_TRACE(testing::Message() << "size " << size << ", pressure " << pressure << " in " << ambient);
      VolumeArrays v = volumesOf(ball, 100.0, pressure, Eigen::Vector3d::Ones(), ambient);
      PointState state = stateOf(ball, 0.1);
      state.position *= size;
      state.position.colwise() += Eigen::Vector3d(3, 2, 1);
      addVolumeForces(v, state);
      const double largest = state.force.cwiseAbs().maxCoeff();
      for (Eigen::Index i = 0; i < 5; ++i)
        for (int axis = 0; axis < 3; ++axis) {
          Points left = state.position, right = state.position;
          left(axis, i) -= 1e-5, right(axis, i) += 1e-5;
          const double slope = (volumeEnergy(v, right) - volumeEnergy(v, left)) / 2e-5;
          // rounding of energies of some hundred J over 2e-5 m
          EXPECT_NEAR(state.force(axis, i), -slope, 1e-7 * std::max(largest, 1.0));
        }
      Eigen::Vector3d torque = Eigen::Vector3d::Zero();
      for (Eigen::Index i = 0; i < state.force.cols(); ++i)
        torque += state.position.col(i).head<3>().cross(state.force.col(i).head<3>());
      EXPECT_LT(state.force.rowwise().sum().norm(), 1e-13 * largest * 42);
      EXPECT_LT(torque.norm(), 1e-12 * largest * 42);
    }
}

/// Boyle's law: the pressure inside is that at rest times V0 / V. Under the pressure q the forces on the
/// points have the virial  sum x . F = 3 q V.
TEST(VolumeTerm, pushesWithThePressureInsideLessTheOneOutside) {
  const SharedNetwork ball = bare(small_meshes::icosphere(1));
  for (const double ambient : {0.0, 500.0})
    for (const double size : {0.5, 0.8, 1.0, 1.3, 2.0}) {
      VolumeArrays v = volumesOf(ball, 0.0, 20.0, Eigen::Vector3d::Ones(), ambient);
      PointState state = stateOf(ball, 0.0);
      state.position *= size;
      addVolumeForces(v, state);
      const double volume = enclosedVolume(v, state.position);
      const double inside = (20.0 + ambient) / (size * size * size);
      EXPECT_NEAR(state.position.cwiseProduct(state.force).sum() / (3.0 * volume), inside - ambient,
                  1e-12 * (inside + ambient));
    }
}

TEST(VolumeTerm, withoutAmbientPressureHasTheBitsOfGaugePressureAlone) {
  const double modulus = 123.4, pressure = 56.7, rest = 0.89;
  for (double volume = -2.5; volume < 2.5; volume += 0.0371) {
    const kernel::Push<double> p = kernel::pushOf(volume, rest, modulus, pressure, 0.0);
    const double gas = rest / std::max(volume, kernel::kMinGasVolume * rest);
    const double change = std::clamp((volume - rest) / rest, -2.0, 1.0);
    EXPECT_EQ(p.push, pressure * gas - modulus * change) << volume;
    EXPECT_EQ(p.stiffness, (modulus + pressure * gas * gas) / rest) << volume;
  }
}

TEST(VolumeTerm, isAsStiffAsTheSpringsByDefaultForClosedBodiesOnly) {
  const SharedNetwork cube = test::closedCubeNetwork();
  // 12 edges of 1 m and 12 diagonals of sqrt(2) m: sum k L^2 / (6 V) = 36 k / 6
  EXPECT_NEAR(makeVolumes(*cube, {})->modulus, 6000.0, 1e-9);
  EXPECT_TRUE(volumesOf(cube, 0.0, 0.0).empty());
  EXPECT_TRUE(makeVolumes(**buildCloth(), {}).empty());
  EXPECT_TRUE(makeVolumes(*bare(small_meshes::singleTriangle()), {}).empty());
}

TEST(VolumeTerm, saysWhyAnOpenMeshCannotHaveIt) {
  SoftBodySettings settings;
  settings.pressure = 5.0;
  EXPECT_EQ(checkVolume(*bare(small_meshes::singleTriangle()), settings),
            "pressure: the surface is not closed: it has 3 open edges");
  EXPECT_EQ(checkVolume(**buildRope(), settings), "pressure: a rope or cloth encloses no volume");
  settings.pressure = 0.0;
  settings.ambientPressure = 5.0;
  EXPECT_EQ(checkVolume(**buildRope(), settings), "ambientPressure: a rope or cloth encloses no volume");
  settings.ambientPressure = 0.0;
  settings.volumeModulus = 5.0;
  EXPECT_EQ(checkVolume(*bare(small_meshes::flippedTriangle()), settings),
            "volumeModulus: the surface is not closed: it has 3 inconsistent edges");
  EXPECT_EQ(checkVolume(*test::closedCubeNetwork(), settings), "");
}

TEST(VolumeTerm, keepsComponentsApart) {
  VolumeArrays v = volumesOf(bare(small_meshes::twoIslands()), 7.0, 0.0);
  ASSERT_EQ(v->restVolume.size(), 2u);
  EXPECT_NEAR(v->restVolume[0], v->restVolume[1], 1e-12);
}

TEST(VolumeTerm, isThatOfSmallPiecesFarApartToo) {
  TriangleMesh mesh = small_meshes::cube();
  for (Eigen::Vector3d& p : mesh.positions) p *= 0.01;
  const std::size_t count = mesh.positions.size(), triangles = mesh.triangles.size();
  for (std::size_t i = 0; i < count; ++i)
    mesh.positions.push_back(mesh.positions[i] + Eigen::Vector3d(2, 3, 4));
  for (std::size_t t = 0; t < triangles; ++t) {
    Triangle moved = mesh.triangles[t];
    for (std::uint32_t& corner : moved) corner += static_cast<std::uint32_t>(count);
    mesh.triangles.push_back(moved);
  }
  const VolumeArrays v = volumesOf(bare(mesh), 7.0, 0.0);
  ASSERT_EQ(v->restVolume.size(), 2u);
  EXPECT_NEAR(v->restVolume[1], 1e-6, 1e-18);
}

TEST(VolumeTerm, asksTheSurfaceWhetherItIsClosedAndNotItsReport) {
  SpringNetwork open = *test::closedCubeNetwork();
  open.surface.pop_back();
  ASSERT_TRUE(open.report.watertight());
  EXPECT_TRUE(makeVolumes(open, {}).empty());
  SoftBodySettings settings;
  settings.pressure = 1.0;
  EXPECT_EQ(checkVolume(open, settings), "pressure: the surface is not closed: it has 3 open edges");
}

TEST(VolumeTerm, isThatOfTheClosedPiecesOfAMeshThatIsOpenElsewhere) {
  TriangleMesh mesh = small_meshes::cube();
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Eigen::Vector3d& p : small_meshes::singleTriangle().positions)
    mesh.positions.push_back(p + Eigen::Vector3d(5, 0, 0));
  mesh.triangles.push_back({first, first + 1, first + 2});
  const VolumeArrays v = volumesOf(bare(mesh), 7.0, 0.0);
  ASSERT_EQ(v->restVolume.size(), 1u);
  EXPECT_NEAR(v->restVolume[0], 1.0, 1e-12);
}

/// Returns the largest eigenvalue (rad^2/s^2) of the volume term's Hessian, by differences of forces.
double largestSquared(VolumeArrays& v, const PointState& state) {
  const Eigen::Index size = state.position.size();
  Eigen::MatrixXd hessian(size, size);
  const auto gradientAt = [&](Eigen::Index i, double step) {
    PointState moved = state;
    moved.position.reshaped()[i] += step;
    addVolumeForces(v, moved);
    return Eigen::VectorXd(-moved.force.reshaped());
  };
  for (Eigen::Index i = 0; i < size; ++i)
    hessian.col(i) = (gradientAt(i, 1e-6) - gradientAt(i, -1e-6)) / 2e-6 * state.inverseMass(0, 0);
  return symmetricValues(0.5 * (hessian + hessian.transpose())).cwiseAbs().maxCoeff();
}

TEST(VolumeTerm, boundsTheFrequencyItAdds) {
  const SharedNetwork ball = bare(small_meshes::icosphere(1));
  for (const double ambient : {0.0, 1000.0}) {
    VolumeArrays v = volumesOf(ball, 100.0, 30.0, Eigen::Vector3d::Ones(), ambient);
    const PointState state = stateOf(ball, 0.1);
    const double largest = largestSquared(v, state), bound = volumeFrequencyBoundSquared(v, state, 0.0);
    EXPECT_GE(bound, largest);
    EXPECT_LE(bound, 4.0 * largest) << "no waste of substeps";
  }
}

/// In thin air the push grows from 0 to the ambient pressure, inwards, while the volume grows.
TEST(VolumeTerm, boundsTheFrequencyOfABodyThatSwellsDuringTheTick) {
  const SharedNetwork ball = bare(small_meshes::icosphere(1));
  VolumeArrays v = volumesOf(ball, 0.0, 0.0, Eigen::Vector3d::Ones(), 1000.0);
  PointState state = stateOf(ball, 0.0);
  state.inverseMass.leftCols(41).setZero();  // a single point feels little of the volume's stiffness
  state.velocity = 2.0 * state.position;
  const double bound = volumeFrequencyBoundSquared(v, state, 1.0);
  for (int i = 0; i <= 10; ++i) {
    PointState later = state;
    later.position += 0.1 * i * state.velocity;
    EXPECT_GE(bound, largestSquared(v, later)) << i;
  }
}

TEST(VolumeTerm, aBoundWithSlackHoldsForAllShapesWithinIt) {
  for (const SharedNetwork& network : {test::closedCubeNetwork(), bare(small_meshes::icosphere(1))})
    for (const double noise : {0.0, 0.03, 0.1}) {
      VolumeArrays v = volumesOf(network, 100.0, 30.0);
      PointState state = stateOf(network, noise);
      const double slack = 0.02, bound = volumeFrequencyBoundSquared(v, state, 0.0, slack);
      const Points middle = state.position;
      std::srand(1);
      for (int i = 0; i < 200; ++i) {
        state.position = middle;
        for (Eigen::Index p = 0; p < middle.cols(); ++p)
          state.position.col(p) += slack * Eigen::Vector3d::Random().normalized();
        EXPECT_GE(bound, volumeFrequencyBoundSquared(v, state, 0.0)) << noise;
      }
    }
}

TEST(VolumeTerm, keepsItsBoundWhileTheShapeIsKept) {
  const SharedNetwork cube = test::closedCubeNetwork();
  VolumeArrays v = volumesOf(cube, 100.0, 30.0);
  PointState state = stateOf(cube, 0.01);
  const double bound = keptVolumeBoundSquared(v, state, 1.0);
  const double exact = volumeFrequencyBoundSquared(v, state, 1.0);
  EXPECT_GE(bound, exact);
  EXPECT_LE(bound, 1.01 * exact) << "no waste of substeps";
  state.position.col(3) *= 1.0001;
  state.position.colwise() += Eigen::Vector3d(3, 4, 5);
  state.velocity.colwise() += Eigen::Vector3d(30, 40, 50);
  EXPECT_EQ(keptVolumeBoundSquared(v, state, 1.0), bound);
  state.velocity(0, 0) += 0.5;
  const double faster = keptVolumeBoundSquared(v, state, 1.0);
  EXPECT_GE(faster, volumeFrequencyBoundSquared(v, state, 1.0)) << "an edge may become half as long again";
  EXPECT_GT(faster, 1.5 * bound);
  state.velocity(0, 0) = 30.0;
  state.position *= 2.0;
  EXPECT_GT(keptVolumeBoundSquared(v, state, 1.0), 1.5 * bound);
}

enum class VolumeStepper { Verlet, Shared, Newton };

class VolumeSteps : public testing::TestWithParam<VolumeStepper> {
 public:
  void advance(SteppedTestBody& body, double time, int substeps) {
    if (GetParam() == VolumeStepper::Verlet) return stepVerlet(body.group, time, substeps);
    const auto kind =
        GetParam() == VolumeStepper::Shared ? MidpointSolver::Kind::Shared : MidpointSolver::Kind::Newton;
    stepImplicit(body.stepped(), implicit, kind, time, substeps, factors);
  }
  ImplicitState implicit;
  SharedFactors factors;
};

/// By symmetry, an icosahedron that is enlarged uniformly keeps its shape and oscillates:
///     omega^2 = (k sum L^2 + 9 K V0) / sum m |x|^2,   |x| = 1 m.
TEST_P(VolumeSteps, breatheWithTheRightPeriod) {
  SteppedTestBody body(bare(small_meshes::icosphere(0)), 100.0, 0.0);
  double squares = 0.0;
  for (const double length : body.springs->restLength) squares += length * length;
  const double stiffness = 100.0 * squares + 9.0 * body.volumes->modulus * body.volumes->restVolume[0];
  ASSERT_GT(9.0 * body.volumes->modulus * body.volumes->restVolume[0], 100.0 * squares)
      << "the volume matters";
  body.state.position *= 1.0 + 1e-4;
  const double before = body.energy();
  advance(body, 2.0 * std::acos(-1.0) / std::sqrt(stiffness), 400);
  // the errors of the period are (2 pi / 400)^2 / 24 and / 12 or less, 2e-5
  for (Eigen::Index i = 0; i < 12; ++i)
    EXPECT_NEAR((body.state.position.col(i).norm() - 1.0) / 1e-4, 1.0, 1e-3);
  EXPECT_NEAR(body.energy(), before, 1e-3 * before);
}

TEST_P(VolumeSteps, keepMomentumAndComeBackFromFlatAndInsideOut) {
  for (const double squash : {0.0, -1.0}) {
    SteppedTestBody body(test::closedCubeNetwork(), 100.0, 0.5);
    for (Eigen::Index i = 0; i < 8; ++i)
      body.state.position.col(i) +=
          1e-3 * Eigen::Vector3d(std::sin(9.0 * double(i)), std::cos(7.0 * double(i)), 0);
    body.state.position.row(2) *= squash;
    body.state.velocity.colwise() = Eigen::Vector3d(1, 2, 3);
    const Eigen::Vector3d momentum = linearMomentum(body.state);
    for (int i = 0; i < 1200; ++i) advance(body, 1.0 / 60.0, 8);
    // rounding of 10 000 substeps; the implicit ones solve factorised systems in each
    EXPECT_LT((linearMomentum(body.state) - momentum).norm(),
              GetParam() == VolumeStepper::Verlet ? 1e-11 : 1e-9);
    EXPECT_NEAR(enclosedVolume(body.volumes, body.state.position), 1.0, 1e-6) << "squashed to " << squash;
    EXPECT_LT(body.energy() - 0.5 * momentum.squaredNorm(), 1e-6) << "squashed to " << squash;
  }
}

/// The same with gas of the pressure a inside and outside: at rest it is like a volume modulus of a.
TEST_P(VolumeSteps, breatheWithTheRightPeriodInAir) {
  SteppedTestBody body(bare(small_meshes::icosphere(0)), 100.0, 0.0);
  body.settings.volumeModulus = 0.0;
  body.settings.ambientPressure = 2000.0;
  body.volumes = makeVolumes(*body.net, body.settings);
  double squares = 0.0;
  for (const double length : body.springs->restLength) squares += length * length;
  const double ofGas = 9.0 * 2000.0 * body.volumes->restVolume[0];
  ASSERT_GT(ofGas, 3.0 * 100.0 * squares) << "the gas matters";
  body.state.position *= 1.0 + 1e-4;
  const double before = body.energy();
  advance(body, 2.0 * std::acos(-1.0) / std::sqrt(100.0 * squares + ofGas), 400);
  // errors as above, and of the anharmonic gas: its stiffness changes by 1e-3 over the amplitude
  for (Eigen::Index i = 0; i < 12; ++i)
    EXPECT_NEAR((body.state.position.col(i).norm() - 1.0) / 1e-4, 1.0, 1e-3);
  EXPECT_NEAR(body.energy(), before, 1e-3 * before);
}

/// The gas of an undamped ball that breathes by a quarter of its volume stores most of the energy.
TEST_P(VolumeSteps, conserveTheEnergyOfGasInAir) {
  SteppedTestBody body(bare(small_meshes::icosphere(0)), 100.0, 0.0);
  body.settings.volumeModulus = 0.0;
  body.settings.pressure = 100.0;
  body.settings.ambientPressure = 2000.0;
  body.volumes = makeVolumes(*body.net, body.settings);
  body.state.velocity = 14.0 * body.state.position;
  const double start = body.energy();
  double lowest = start, highest = start, largestVolume = 0.0;
  for (int i = 0; i < 600; ++i) {
    advance(body, 1.0 / 240.0, 20);
    lowest = std::min(lowest, body.energy()), highest = std::max(highest, body.energy());
    largestVolume = std::max(largestVolume, enclosedVolume(body.volumes, body.state.position));
  }
  EXPECT_GT(largestVolume, 1.25 * body.volumes->restVolume[0]);
  // (omega dt)^2 / 4 = 6e-4 of the kinetic energy of 98 J, with omega = 230/s, and as much for the harder gas
  EXPECT_LT(highest - lowest, 1.2e-3 * 98.0);
}

/// Returns the radius at which springs of the given k sum L^2 (N m) balance gas of the pressure p in the
/// ambient pressure a:  k sum L^2 (s - 1) = 3 V0 ((p + a) / s - a s^2).
double balancedRadius(double springs, double restVolume, double p, double a) {
  double low = 1.0, high = 10.0;
  while (high - low > 1e-12) {
    const double s = 0.5 * (low + high);
    (springs * (s - 1.0) < 3.0 * restVolume * ((p + a) / s - a * s * s) ? low : high) = s;
  }
  return low;
}

TEST_P(VolumeSteps, swellUntilSpringsAndAirBalanceTheGas) {
  for (const double stiffness : {1e-3, 100.0}) {
    SteppedTestBody body(bare(small_meshes::icosphere(0)), stiffness, 5.0);
    body.settings.volumeModulus = 0.0;
    body.settings.pressure = 200.0;
    body.settings.ambientPressure = 800.0;
    body.volumes = makeVolumes(*body.net, body.settings);
    body.group.bodies[0].volumes = &body.volumes;
    double squares = 0.0;
    for (const double length : body.springs->restLength) squares += length * length;
    for (int i = 0; i < 600; ++i) advance(body, 1.0 / 60.0, 20);
    const double rest = body.volumes->restVolume[0];
    const double relative = enclosedVolume(body.volumes, body.state.position) / rest;
    EXPECT_NEAR(std::cbrt(relative), balancedRadius(stiffness * squares, rest, 200.0, 800.0), 1e-6);
    EXPECT_LT(relative, 1.0 + 200.0 / 800.0) << "what the air alone allows";
  }
}

/// Without springs and air nothing balances gauge pressure.
TEST_P(VolumeSteps, swellWithoutEndInAVacuum) {
  SteppedTestBody body(bare(small_meshes::icosphere(0)), 0.0, 5.0);
  body.settings.volumeModulus = 0.0;
  body.settings.pressure = 200.0;
  body.volumes = makeVolumes(*body.net, body.settings);
  body.group.bodies[0].volumes = &body.volumes;
  double volume = body.volumes->restVolume[0];
  for (int second = 0; second < 3; ++second) {
    for (int i = 0; i < 60; ++i) advance(body, 1.0 / 60.0, 20);
    const double later = enclosedVolume(body.volumes, body.state.position);
    EXPECT_GT(later, 1.5 * volume);
    volume = later;
  }
}

/// Gas of pressure P enlarges the icosahedron to the radius s:  k sum L^2 (s - 1) = 3 P V0 / s.
TEST_P(VolumeSteps, areBlownUpByGas) {
  SteppedTestBody body(bare(small_meshes::icosphere(0)), 100.0, 5.0);
  body.settings.volumeModulus = 0.0;
  body.settings.pressure = 200.0;
  body.volumes = makeVolumes(*body.net, body.settings);
  double squares = 0.0;
  for (const double length : body.springs->restLength) squares += length * length;
  for (int i = 0; i < 600; ++i) advance(body, 1.0 / 60.0, 8);
  const double s = 0.5 + std::sqrt(0.25 + 3.0 * 200.0 * body.volumes->restVolume[0] / (100.0 * squares));
  EXPECT_NEAR(body.state.position.col(7).norm(), s, 1e-6);
}

std::string nameOfVolumeStepper(const testing::TestParamInfo<VolumeStepper>& how) {
  const char* const names[] = {"Verlet", "Shared", "Newton"};
  return names[static_cast<int>(how.param)];
}

INSTANTIATE_TEST_SUITE_P(Steppers, VolumeSteps,
                         testing::Values(VolumeStepper::Verlet, VolumeStepper::Shared, VolumeStepper::Newton),
                         nameOfVolumeStepper);

}  // namespace
}  // namespace limber

// SPDX-License-Identifier: Zlib
// Bodies of a material: the measured properties must be the requested ones.
#include <limber/cook.h>
#include <limber/network_builder.h>

#include "analysis/analysis.h"
#include "cook/cooked_figure.h"
#include "network/masses.h"
#include "network/material.h"
#include "network/tetrahedra.h"
#include "support/elastic_measures.h"
#include "support/network_shapes.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"
#include "support/variants.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace limber {
namespace {

SharedNetwork make(const TriangleMesh& mesh, std::uint32_t points) {
  MaterialMesh settings;
  settings.points = points;
  const Result<SharedNetwork> network = buildMaterialNetwork(mesh, settings);
  EXPECT_TRUE(network) << network.error();
  return *network;
}

ElasticModuli measure(const SpringNetwork& network, const SoftBodySettings& s) {
  return measureModuli({network, s.extensionStiffness, s.volumeModulus.value(), s.scale});
}

double volumeOfAll(const SpringNetwork& network) {
  double volume = 0.0;
  for (const Tetrahedron& t : network.tetrahedra) volume += volumeOf(network.restPoints, t);
  return volume;
}

/// Returns the calibration of setMaterialSprings for a lattice of about `points` points.
double calibration(const TriangleMesh& mesh, std::size_t points) {
  TetrahedralMesh filled = *fillWithPoints(*weld(mesh), points);
  SpringNetwork network;
  network.restPoints = filled.points;
  network.tetrahedra = filled.tetrahedra;
  network.surface = filled.surface;
  return setMaterialSprings(network);
}

TEST(MaterialNetwork, hasTheModulusAndPoissonRatioAskedForInAllDirections) {
  for (const TriangleMesh& mesh : {small_meshes::cube(1), small_meshes::icosphere(3), test_shapes::lShape(),
                                   test_shapes::figure(), test_shapes::noiseSphere(2)}) {
    const SharedNetwork network = make(mesh, 300);
    ASSERT_EQ(validate(*network).error(), "");
    for (const double poisson : {0.25, 0.35, 0.45}) {
      SCOPED_TRACE(testing::Message() << network->restPoints.size() << " points, ratio " << poisson);
      Material material;
      material.youngsModulus = 3e4;
      material.poissonRatio = poisson;
      const Result<SoftBodySettings> settings = withMaterial(*network, material);
      ASSERT_TRUE(settings) << settings.error();
      const ElasticModuli moduli = measure(*network, *settings);
      EXPECT_NEAR(moduli.youngsModulus / 3e4, 1.0, 0.01);
      EXPECT_NEAR(moduli.poissonRatio / poisson, 1.0, 0.01);
    }
    EXPECT_GT(measureModuli({*network, 1.0}).isotropy, 0.93);
  }
}

TEST(MaterialNetwork, isAsStiffOnAFinerLattice) {
  for (const TriangleMesh& mesh : {small_meshes::cube(1), small_meshes::icosphere(3), test_shapes::lShape(),
                                   network_shapes::lshape90()}) {
    const double coarse = calibration(mesh, 300), fine = calibration(mesh, 1200);
    EXPECT_NEAR(fine / coarse, 1.0, 0.1);
  }
}

TEST(MaterialNetwork, scalesWithItsBody) {
  const SharedNetwork network = make(test_shapes::lShape(), 200);
  Material material;
  material.density = 500.0;
  for (const Eigen::Vector3d& scale :
       {Eigen::Vector3d(2, 2, 2), Eigen::Vector3d(-1, 1, 1), Eigen::Vector3d(1, 1.3, 0.9)}) {
    SoftBodySettings settings;
    settings.scale = scale;
    settings.friction = 0.7;
    const SoftBodySettings made = *withMaterial(*network, material, settings);
    // after uneven scaling the springs, which were fitted to be isotropic, no longer are
    EXPECT_NEAR(measure(*network, made).youngsModulus / 1e5, 1.0, 0.02);
    EXPECT_NEAR(made.totalMass, 500.0 * volumeOfAll(*network) * std::abs(scale.prod()), 1e-9);
    EXPECT_EQ(made.friction, 0.7) << "all else stays";
  }
}

TEST(MaterialNetwork, sharesTheMassByVolume) {
  const SharedNetwork network = make(test_shapes::star(), 300);
  std::vector<double> quarters(network->restPoints.size(), 0.0);
  for (const Tetrahedron& t : network->tetrahedra)
    for (const std::uint32_t corner : t)
      quarters[corner] += volumeOf(network->restPoints, t) / (4.0 * volumeOfAll(*network));
  double sum = 0.0, moved = 0.0;
  for (std::size_t i = 0; i < quarters.size(); ++i) {
    sum += network->massFractions[i];
    moved += 0.5 * std::abs(network->massFractions[i] - quarters[i]);
    EXPECT_GT(network->massFractions[i], 0.0);
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_LT(moved, 0.3) << "7 % to light points, the rest so that the inertia is the solid's";
}

/// A body that tumbles: where its mass is in all, and how hard it is to turn.
TEST(MaterialNetwork, hasTheCentreAndNearlyTheInertiaOfTheSolid) {
  for (const TriangleMesh& mesh : {small_meshes::cube(1), test_shapes::star(), test_shapes::figure()}) {
    const SharedNetwork network = make(mesh, 300);
    const SolidMoments solid = solidMoments(network->restPoints, network->surface);
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double second = 0.0;
    for (std::size_t i = 0; i < network->massFractions.size(); ++i) {
      centre += network->massFractions[i] * network->restPoints[i];
      second += network->massFractions[i] * (network->restPoints[i] - solid.centre).squaredNorm();
    }
    EXPECT_LT((centre - solid.centre).norm(), 1e-3) << "of a body 1 m large";
    EXPECT_NEAR(second / solid.second.trace(), 1.0, 0.1) << "a quarter of each tetrahedron has up to 1.1";
  }
}

/// The fastest oscillation decides how many substeps a tick takes. With a quarter of each tetrahedron's mass
/// at each corner a few points at the tips of limbs decide it; a smallest mass of a fifth of the mean leaves
/// small and stiff points too light.
TEST(MaterialNetwork, givesMassToThePointsThatLimitTheTimeStep) {
  const SpringNetwork& network = *test::cookedFigure().bodies[0];
  SpringNetwork quarters = network;
  quarters.massFractions.assign(network.restPoints.size(), 0.0);
  for (const Tetrahedron& t : network.tetrahedra)
    for (const std::uint32_t corner : t)
      quarters.massFractions[corner] += volumeOf(network.restPoints, t) / (4.0 * volumeOfAll(network));
  for (double& f : quarters.massFractions)
    f = std::max(f, 0.2 / static_cast<double>(network.restPoints.size()));
  EXPECT_GT(timeSteps(network, {}).critical, 1.25 * timeSteps(quarters, {}).critical);
}

TEST(MaterialNetwork, rendersTheMeshItCameFrom) {
  const TriangleMesh mesh = test_shapes::lShape();
  const SharedNetwork network = make(mesh, 200);
  EXPECT_EQ(network->render.triangles.size(), mesh.triangles.size());
  EXPECT_GT(network->render.skin.size(), 0u);
  for (const NetworkSpring& s : network->springs)
    EXPECT_TRUE(s.kind == SpringKind::Structural || s.kind == SpringKind::Brace);
  const auto inside = std::count_if(network->springs.begin(), network->springs.end(),
                                    [](const NetworkSpring& s) { return s.kind == SpringKind::Brace; });
  EXPECT_GT(inside, 0);
}

/// It ends at any call of progress(), and does not call it again.
TEST(MaterialNetwork, endsWithAnErrorWhenProgressSaysSo) {
  MaterialMesh settings;
  settings.points = 60;
  int totalCalls = 0;
  double last = 0.0;
  std::string part;
  settings.progress = [&](const char* what, double done) {
    EXPECT_GE(done, part == what ? last : 0.0) << what;
    part = what;
    last = done;
    return ++totalCalls > 0;
  };
  ASSERT_TRUE(buildMaterialNetwork(test_shapes::lShape(), settings));
  EXPECT_EQ(last, 1.0);
  EXPECT_GT(totalCalls, 8) << "between the lattices tried and the corrections of the springs, too";
  for (const int lastCall : {1, 2, totalCalls / 2, totalCalls}) {
    int calls = 0;
    settings.progress = [&](const char*, double) { return ++calls < lastCall; };
    const Result<SharedNetwork> network = buildMaterialNetwork(test_shapes::lShape(), settings);
    ASSERT_FALSE(network) << "ended at call " << lastCall << " of " << totalCalls;
    EXPECT_EQ(network.error(), "ended early: progress returned false");
    EXPECT_EQ(calls, lastCall);
  }
}

/// With four times the points, the same material must respond equally to loads that were not used in the
/// calibration.
TEST(MaterialNetwork, bendsAlikeOnAFinerLattice) {
  for (const TriangleMesh& mesh : {small_meshes::cube(1), network_shapes::lshape90()}) {
    std::array<double, 2> mean{};
    for (std::size_t i = 0; i < 2; ++i) {
      const SharedNetwork network = make(mesh, i == 0 ? 300 : 1200);
      for (const BendingModulus& b : measureModuli({*network, network->stiffnessPerModulus}).bending)
        mean[i] += b.modulus / 6.0;
      EXPECT_NEAR(mean[i], 1.0, 0.2) << "of 1 Pa";
    }
    EXPECT_NEAR(mean[1] / mean[0], 1.0, 0.1);
  }
}

/// Beam theory, which was not used in the fit, on a bar with two and with four cells across. Before the fit
/// the springs are too stiff by 1.30 and 1.07 in bending, by 1.50 and 1.25 in torsion; linear elements
/// by 1.43 and 1.13 in torsion. 10 % is the target of the bench.
TEST(MaterialNetwork, bendsAndTwistsLikeABeam) {
  const TriangleMesh mesh = test::boxMesh({4.0, 1.0, 1.0});
  double coarseTorsion = 0.0;
  for (const std::uint32_t points : {185u, 969u}) {
    const SharedNetwork network = make(mesh, points);
    const test::BeamModuli beam = test::measureBeam({*network, network->stiffnessPerModulus});
    SCOPED_TRACE(testing::Message() << network->restPoints.size() << " points");
    EXPECT_NEAR(measureModuli({*network, network->stiffnessPerModulus}).youngsModulus, 1.0, 1e-12);
    EXPECT_NEAR(beam.tension, 1.0, 0.1);
    EXPECT_NEAR(beam.bending, 1.0, 0.1);
    EXPECT_NEAR(beam.torsion, 1.0, 0.1);
    if (points == 185u) coarseTorsion = beam.torsion;
    EXPECT_NEAR(beam.torsion / coarseTorsion, 1.0, 0.1);
  }
}

/// Slender bars with two cells across: with small changes of the springs alone they are too stiff in torsion
/// by 1.4 to 1.7.
TEST(MaterialNetwork, slenderBarsTwistLikeBeams) {
  struct Bar {
    double length;
    std::uint32_t points;
  };
  for (const Bar& bar : test::variants({Bar{5.0, 185}}, {Bar{5.0, 300}, Bar{20.0, 600}})) {
    const SharedNetwork network = make(test::boxMesh({bar.length, 1.0, 1.0}), bar.points);
    const test::BeamModuli beam = test::measureBeam({*network, network->stiffnessPerModulus});
    SCOPED_TRACE(testing::Message() << bar.length << " long, " << network->restPoints.size() << " points");
    EXPECT_NEAR(beam.tension, 1.0, 0.1);
    EXPECT_NEAR(beam.bending, 1.0, 0.15);
    EXPECT_NEAR(beam.torsion, 1.0, 0.15);
  }
}

/// Thin bodies, one or two cells thick: at a Poisson ratio near 1/2 a plate of the modulus E / (1 - nu^2) is
/// up to a quarter harder to bend than at 1/4. With the volume terms of a ratio of 0.4 the thinnest was 3.7
/// times as hard, of 0.49 4.3 times.
TEST(MaterialNetwork, thinBodiesDoNotLockWhenTheyBendNearIncompressibility) {
  using Eigen::Vector3d;
  for (const Vector3d& size : test::variants({Vector3d(1, 0.4, 0.05), Vector3d(1, 0.2, 0.2)},
                                             {Vector3d(1, 0.4, 0.03), Vector3d(1, 0.4, 0.1)})) {
    const SharedNetwork network = make(test::boxMesh(size), 200);
    Material material;
    const auto moduliAt = [&](double poisson) {
      material.poissonRatio = poisson;
      return measure(*network, *withMaterial(*network, material));
    };
    const ElasticModuli springs = moduliAt(0.25);
    for (const double poisson : test::variants({0.4, 0.49}, {0.45})) {
      const ElasticModuli moduli = moduliAt(poisson);
      SCOPED_TRACE(testing::Message() << size.transpose() << ", ratio " << poisson);
      EXPECT_NEAR(moduli.youngsModulus / springs.youngsModulus, 1.0, 0.01);
      EXPECT_LT(moduli.poissonRatio, poisson + 0.001);
      for (std::size_t i = 0; i < 6; ++i) {
        if (moduli.bending[i].slenderness < 3.0) continue;
        EXPECT_GT(moduli.bending[i].modulus / springs.bending[i].modulus, 0.9);
        EXPECT_LT(moduli.bending[i].modulus / springs.bending[i].modulus, 1.31);
      }
    }
  }
}

/// A rope and a cloth that a scale makes longer have the stiffness and the mass of longer ones.
TEST(MaterialNetwork, scalesOfOneAxisAreLengths) {
  for (const double factor : {0.5, 3.0}) {
    RopeSettings rope;
    rope.thickness = 0.02;
    ClothSettings cloth;
    cloth.thickness = 0.002;
    const SharedNetwork networks[] = {*buildRope(rope), *buildCloth(cloth)};
    rope.length *= factor, cloth.width *= factor;
    const SharedNetwork longer[] = {*buildRope(rope), *buildCloth(cloth)};
    for (const int i : {0, 1}) {
      SoftBodySettings scaled;
      scaled.scale.x() = factor;
      const SoftBodySettings seen = *withMaterial(*networks[i], {}, scaled),
                             wanted = *withMaterial(*longer[i], {});
      EXPECT_NEAR(seen.extensionStiffness, wanted.extensionStiffness, 1e-9 * wanted.extensionStiffness) << i;
      EXPECT_NEAR(seen.totalMass, wanted.totalMass, 1e-9 * wanted.totalMass) << i;
    }
  }
}

TEST(MaterialNetwork, saysWhatItCannotDo) {
  EXPECT_EQ(buildMaterialNetwork(small_meshes::singleTriangle()).error(),
            "the mesh is not closed: it has 3 open edges; wrap() closes it, cook() does so by itself");
  MaterialMesh mesh;
  mesh.spacing = -1.0;
  EXPECT_EQ(buildMaterialNetwork(small_meshes::cube(1), mesh).error(), "spacing is -1, must be above 0");
  const SharedNetwork network = make(small_meshes::cube(1), 50);
  Material material;
  material.poissonRatio = 0.5;
  EXPECT_EQ(withMaterial(*network, material).error(), "poissonRatio is 0.5, must be from 0.25 to below 0.5");
  material = {};
  material.youngsModulus = 0.0;
  EXPECT_EQ(withMaterial(*network, material).error(), "youngsModulus is 0, must be above 0");
  material = {};
  material.density = -1.0;
  EXPECT_EQ(withMaterial(*network, material).error(), "density is -1, must be above 0");
  EXPECT_EQ(withMaterial(**buildRope(), {}).error(),
            "the thickness of the rope is 0: a material needs it (see RopeSettings and ClothSettings)");
  EXPECT_EQ(withMaterial(**buildCloth(), {}).error(),
            "the thickness of the cloth is 0: a material needs it (see RopeSettings and ClothSettings)");
  EXPECT_EQ(withMaterial(**buildNetwork(small_meshes::singleTriangle()), {}).error(),
            "the surface of the network is open: a material needs its volume");
  TriangleMesh flipped = small_meshes::cube(2);
  std::swap(flipped.triangles[0][1], flipped.triangles[0][2]);
  EXPECT_EQ(
      withMaterial(**buildNetwork(flipped), {}).error(),
      "at 3 edges the triangles of the network face different sides: a material needs its volume (cook() or "
      "wrap() the mesh)");
}

}  // namespace
}  // namespace limber

// SPDX-License-Identifier: Zlib
// cook(): what becomes of meshes of every kind, and materials of what is not filled with tetrahedra.

#include "cook/cooked_figure.h"
#include "mesh/surface.h"
#include "mesh/triangle_bvh.h"
#include "network/tetrahedra.h"
#include "support/constants.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <limber/cook.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

namespace limber {
namespace {

using Eigen::Vector3d;
using small_meshes::joined;
using test::kPi;

/// A ball of radius 0.5 about `middle`, without the triangles above `cut`.
TriangleMesh ball(const Vector3d& middle, double cut = 1.0) {
  constexpr std::uint32_t kRings = 24, kSectors = 48;
  TriangleMesh mesh;
  for (std::uint32_t r = 0; r <= kRings; ++r)
    for (std::uint32_t s = 0; s < kSectors; ++s) {
      const double polar = kPi * r / kRings, angle = 2.0 * kPi * s / kSectors;
      mesh.positions.push_back(middle + 0.5 * Vector3d(std::sin(polar) * std::cos(angle), std::cos(polar),
                                                       -std::sin(polar) * std::sin(angle)));
    }
  for (Vector3d* pole : {&mesh.positions.front(), &mesh.positions[kRings * kSectors]})
    for (std::uint32_t s = 1; s < kSectors; ++s) pole[s] = *pole;
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const double height = (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]).y() / 3.0 - middle.y();
    if (height < cut) mesh.triangles.push_back({a, b, c});
  };
  for (std::uint32_t r = 0; r < kRings; ++r)
    for (std::uint32_t s = 0; s < kSectors; ++s) {
      const std::uint32_t a = r * kSectors + s, b = r * kSectors + (s + 1) % kSectors;
      add(a, a + kSectors, b + kSectors);
      add(a, b + kSectors, b);
    }
  return mesh;
}

/// A closed ring of wire.
TriangleMesh ring(double radius, double wire) {
  constexpr std::uint32_t kRings = 48, kSides = 8;
  TriangleMesh mesh;
  for (std::uint32_t r = 0; r < kRings; ++r)
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const double angle = 2.0 * kPi * r / kRings, side = 2.0 * kPi * s / kSides;
      const double reach = radius + wire * std::cos(side);
      mesh.positions.emplace_back(reach * std::cos(angle), reach * std::sin(angle), wire * std::sin(side));
      const std::uint32_t a = r * kSides + s, b = r * kSides + (s + 1) % kSides, next = kRings * kSides;
      mesh.triangles.push_back({a, (b + kSides) % next, b});
      mesh.triangles.push_back({a, (a + kSides) % next, (b + kSides) % next});
    }
  return mesh;
}

/// A trefoil knot of 1 m, a closed tube.
TriangleMesh knot(double radius) {
  constexpr std::uint32_t kRings = 120, kSides = 12;
  const auto axis = [](double t) -> Vector3d {
    return Vector3d(std::sin(t) + 2.0 * std::sin(2.0 * t), std::cos(t) - 2.0 * std::cos(2.0 * t),
                    -std::sin(3.0 * t)) /
           6.0;
  };
  TriangleMesh mesh;
  for (std::uint32_t r = 0; r < kRings; ++r) {
    const double t = 2.0 * kPi * r / kRings;
    const Vector3d along = (axis(t + 1e-3) - axis(t - 1e-3)).normalized();
    const Vector3d across = along.cross(axis(t)).normalized(), up = across.cross(along);
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const double side = 2.0 * kPi * s / kSides;
      mesh.positions.push_back(axis(t) + radius * (std::cos(side) * across + std::sin(side) * up));
      const std::uint32_t a = r * kSides + s, b = r * kSides + (s + 1) % kSides, all = kRings * kSides;
      mesh.triangles.push_back({a, (a + kSides) % all, b});
      mesh.triangles.push_back({b, (a + kSides) % all, (b + kSides) % all});
    }
  }
  return mesh;
}

/// A tube around an arc of 90 degrees, open at both ends.
TriangleMesh tube(double length, double radius) {
  constexpr std::uint32_t kRings = 80, kSides = 8;
  const double bend = 2.0 * length / kPi;  // radius of the arc
  TriangleMesh mesh;
  for (std::uint32_t r = 0; r <= kRings; ++r)
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const double angle = 0.5 * kPi * r / kRings, side = 2.0 * kPi * s / kSides;
      const double reach = bend + radius * std::cos(side);
      mesh.positions.emplace_back(reach * std::cos(angle), reach * std::sin(angle), radius * std::sin(side));
    }
  for (std::uint32_t r = 0; r < kRings; ++r)
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const std::uint32_t a = r * kSides + s, b = r * kSides + (s + 1) % kSides;
      mesh.triangles.push_back({a, b, b + kSides});
      mesh.triangles.push_back({a, b + kSides, a + kSides});
    }
  return mesh;
}

/// A grid in the plane z = 0, waved along z.
TriangleMesh flag(double wave) {
  constexpr std::uint32_t kCells = 16;
  TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= kCells; ++j)
    for (std::uint32_t i = 0; i <= kCells; ++i) {
      const double x = double(i) / kCells, y = double(j) / kCells;
      mesh.positions.emplace_back(x, y, wave * std::sin(9.0 * x));
    }
  for (std::uint32_t j = 0; j < kCells; ++j)
    for (std::uint32_t i = 0; i < kCells; ++i) {
      const std::uint32_t a = j * (kCells + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + kCells + 2});
      mesh.triangles.push_back({a, a + kCells + 2, a + kCells + 1});
    }
  return mesh;
}

TriangleMesh scaled(TriangleMesh mesh, double factor) {
  for (Vector3d& p : mesh.positions) p *= factor;
  return mesh;
}

CookedMesh cooked(const TriangleMesh& mesh, const CookSettings& settings = {}) {
  Result<CookedMesh> result = cook(mesh, settings);
  if (!result) {
    ADD_FAILURE() << result.error();
    return {};
  }
  for (const SharedNetwork& body : result->bodies) EXPECT_EQ(validate(*body).error(), "");
  for (const std::string& line : result->report) EXPECT_FALSE(line.empty());
  return std::move(*result);
}

/// Largest distance of the skinned points at rest from the mesh's own vertices: the skin is exact at rest.
double skinError(const SpringNetwork& network, const TriangleMesh& mesh, double scale) {
  std::vector<Eigen::Vector3f> points, places(network.render.skin.size());
  for (const Vector3d& p : network.restPoints) points.push_back(p.cast<float>());
  applySkin(network.render.skin, points.front().data(), places.front().data());
  double largest = 0.0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const std::uint32_t place = network.render.vertexToPoint[v];
    if (place == kNoPoint) continue;
    largest = std::max(largest, (places[place].cast<double>() - scale * mesh.positions[v]).norm());
  }
  return largest;
}

/// Three quarters of a ball, which has to be wrapped first. Some tests share it: it takes a second.
const TriangleMesh& openBall() {
  static const TriangleMesh mesh = ball(Vector3d::Zero(), 0.4);
  return mesh;
}
CookedMesh openBallAnew(const TriangleMesh& mesh = openBall()) {
  CookSettings settings;
  settings.points = 60;
  return cooked(mesh, settings);
}
const CookedMesh& cookedOpenBall() {
  static const CookedMesh shared = openBallAnew();
  return shared;
}

TEST(Cook, aClosedMeshIsFilledWithTetrahedra) {
  const TriangleMesh mesh = ball(Vector3d::Zero());
  const CookedMesh c = cooked(mesh);
  ASSERT_EQ(c.bodies.size(), 1u);
  const SpringNetwork& n = *c.bodies[0];
  EXPECT_EQ(c.scale, 1.0);
  EXPECT_GT(n.tetrahedra.size(), 100u);
  EXPECT_GE(n.restPoints.size(), 100u);
  EXPECT_LE(n.restPoints.size(), 480u);
  EXPECT_EQ(c.bodies[0]->thickness, 0.0);
  EXPECT_LT(skinError(n, mesh, 1.0), 1e-5);
}

TEST(Cook, aBodyHasTheMassOfItsMesh) {
  const Material rubber = Material::rubber();
  SoftBodySettings twice;
  twice.scale.setConstant(2.0);
  const Result<SoftBodySettings> made =
      withMaterial(*cooked(ball(Vector3d::Zero())).bodies[0], rubber, twice);
  ASSERT_TRUE(made) << made.error();
  // a polyhedron of 24 rings has about a percent less than the ball of radius 1
  EXPECT_NEAR(made->totalMass, rubber.density * 4.0 / 3.0 * kPi, 0.015 * made->totalMass);
}

/// Limbs of 0.095 m and arms of a star of 0.17 m: the tetrahedra of about 150 points would miss some of them,
/// and bodies whose thin parts are thickened have up to two thirds more mass.
TEST(Cook, limbsGetMorePointsInsteadOfMoreMass) {
  CookSettings settings;
  settings.points = 250;
  const CookedMesh star = cooked(test_shapes::star(), settings);
  for (const CookedMesh* c : {&test::cookedFigure(), &star}) {
    EXPECT_EQ(c->report[1].find("thin parts made"), std::string::npos) << c->report[1];
    EXPECT_GT(c->bodies[0]->volume, 0.0);
    EXPECT_LE(c->bodies[0]->restPoints.size(), c == &star ? 375u : 400u);
  }
}

/// The largest distance of the mesh outside of a body's surface.
double missedBy(const SpringNetwork& network, const TriangleMesh& mesh) {
  const TriangleBvh bvh(network.restPoints, network.surface);
  double largest = 0.0;
  for (const Vector3d& p : mesh.positions)
    if (!bvh.inside(p)) largest = std::max(largest, bvh.nearest(p).distance);
  return largest;
}

TEST(Cook, tooFewPointsBecomeMoreInsteadOfLeavingPartsOut) {
  CookSettings settings;
  settings.points = 50;
  const TriangleMesh mesh = test_shapes::star();
  const SharedNetwork body = cooked(mesh, settings).bodies[0];
  EXPECT_LT(missedBy(*body, mesh), 0.1);  // of about 1 m
  EXPECT_GT(body->restPoints.size(), 1.2 * 50.0);
  EXPECT_LE(body->restPoints.size(), 1.2 * 150.0);
}

/// With 160 points it was a lump of 2.8 times its volume, without holes.
TEST(Cook, aKnotKeepsItsHoles) {
  const TriangleMesh mesh = knot(0.058);
  const SharedNetwork body = cooked(mesh).bodies[0];
  EXPECT_GT(body->volume, 0.0) << "it is thickened";
  const TriangleBvh surface(body->restPoints, body->surface);
  EXPECT_FALSE(surface.inside(Vector3d::Zero()));
  EXPECT_NEAR(std::abs(signedVolume(body->restPoints, body->surface)) / body->volume, 1.0, 0.1);
}

TEST(Cook, aBallOfAnyNumberOfPointsHasNoThinParts) {
  CookSettings settings;
  for (const std::uint32_t points : {100u, 120u}) {
    settings.points = points;
    const SharedNetwork body = cooked(ball(Vector3d::Zero()), settings).bodies[0];
    EXPECT_GT(body->volume, 0.0) << points << ": it is thickened";
    EXPECT_GT(static_cast<double>(body->restPoints.size()), points / 1.6) << points;
    EXPECT_LT(static_cast<double>(body->restPoints.size()), 1.6 * points) << points;
  }
}

TEST(Cook, aRingOfWireHasAboutTheChosenNumberOfPoints) {
  CookSettings settings;
  settings.points = 300;
  const std::size_t points = cooked(ring(0.5, 0.01), settings).bodies[0]->restPoints.size();
  EXPECT_GT(points, 0.75 * 300);
  EXPECT_LT(points, 1.25 * 300);
}

TEST(Cook, verticesThatNoTriangleUsesCountForNothing) {
  TriangleMesh mesh = openBall();
  mesh.positions.emplace_back(1000.0, 0.0, 0.0);
  const double size = extent(cookedOpenBall().bodies[0]->restPoints);
  EXPECT_NEAR(extent(openBallAnew(mesh).bodies[0]->restPoints), size, 0.02 * size);
}

/// Voxels in a ring that closes at one corner: a mesh of one piece that touches itself at a vertex.
TEST(Cook, partsThatTouchAtAVertexHaveTheirOwnPoints) {
  const std::set<std::array<int, 3>> voxels{{0, 0, 0},  {-1, 0, 0}, {-2, 0, 0}, {-2, 0, 1},
                                            {-2, 0, 2}, {-2, 0, 3}, {-2, 1, 3}, {-1, 1, 3},
                                            {0, 1, 3},  {1, 1, 3},  {1, 1, 2},  {1, 1, 1}};
  TriangleMesh mesh;
  const auto addSide = [&](const Vector3d& corner, const Vector3d& u, const Vector3d& v) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vector3d& p : {corner, Vector3d(corner + u), Vector3d(corner + u + v), Vector3d(corner + v)})
      mesh.positions.push_back(0.25 * p);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  };
  for (const auto& voxel : voxels)
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      for (const int side : {0, 1}) {
        std::array<int, 3> beside = voxel;
        beside[static_cast<std::size_t>(axis)] += 2 * side - 1;
        if (voxels.count(beside)) continue;
        Vector3d corner(voxel[0], voxel[1], voxel[2]);
        const Vector3d u = Vector3d::Unit((axis + 1) % 3), v = Vector3d::Unit((axis + 2) % 3);
        corner[axis] += side;
        side ? addSide(corner, u, v) : addSide(corner, v, u);
      }
  const CookedMesh c = cooked(mesh);
  for (const SharedNetwork& body : c.bodies) EXPECT_EQ(validate(*body).error(), "");
}

TEST(Cook, anOpenMeshGetsAnInside) {
  const CookedMesh& c = cookedOpenBall();
  ASSERT_EQ(c.bodies.size(), 1u);
  EXPECT_GT(c.bodies[0]->tetrahedra.size(), 100u);
  EXPECT_LT(skinError(*c.bodies[0], openBall(), 1.0), 1e-5);
  EXPECT_NE(c.report[1].find("wrapped"), std::string::npos) << c.report[1];
  EXPECT_NE(c.report[1].find("openings filled"), std::string::npos) << c.report[1];
}

TEST(Cook, meshesInOtherUnitsBecomeAMetreLong) {
  const CookedMesh c = cooked(scaled(ball(Vector3d::Zero()), 1000.0));
  EXPECT_NEAR(c.scale, 1e-3, 1e-12);
  CookSettings settings;
  settings.size = 0.25;
  EXPECT_NEAR(cooked(ball(Vector3d::Zero()), settings).scale, 0.25, 1e-12);
}

TEST(Cook, farPiecesAreBodiesOfTheirOwnOrConnected) {
  const TriangleMesh mesh = joined(scaled(ball({2.0, 0.0, 0.0}), 0.5), ball(Vector3d::Zero()));
  CookSettings settings;
  settings.points = 60;
  const CookedMesh apart = cooked(mesh, settings);
  ASSERT_EQ(apart.bodies.size(), 2u);
  EXPECT_GT(apart.bodies[0]->restPoints.size(), apart.bodies[1]->restPoints.size());
  settings.pieces = PieceRule::Connected;
  const CookedMesh together = cooked(mesh, settings);
  ASSERT_EQ(together.bodies.size(), 1u);
  EXPECT_LT(skinError(*together.bodies[0], mesh, 1.0), 1e-5);
}

/// As a scan has them: no rod leads to them.
TEST(Cook, crumbsAreLeftOut) {
  const TriangleMesh alone = ball(Vector3d::Zero());
  const TriangleMesh crumbs =
      joined(scaled(ball({900.0, 0.0, 0.0}), 1e-3), scaled(ball({0.0, 400.0, 0.0}), 2e-3));
  CookSettings settings;
  settings.points = 60;
  const CookedMesh cookedAlone = cooked(alone, settings),
                   withCrumbs = cooked(joined(alone, crumbs), settings);
  ASSERT_EQ(withCrumbs.bodies.size(), 1u);
  EXPECT_EQ(withCrumbs.bodies[0]->restPoints, cookedAlone.bodies[0]->restPoints);
}

TEST(Cook, smallPiecesBesideALargeOneAreBodiesToo) {
  CookSettings settings;
  settings.points = 60;
  const CookedMesh c = cooked(joined(ball(Vector3d::Zero()), scaled(ball({40.0, 0.0, 0.0}), 0.02)), settings);
  ASSERT_EQ(c.bodies.size(), 2u) << c.report[1];
  EXPECT_LT(extent(c.bodies[1]->restPoints), 0.05);
}

TEST(Cook, bothProgressFunctionsAreAsked) {
  CookSettings settings;
  settings.mode = CookMode::Braces;
  settings.points = 30;
  int whole = 0, ofBraces = 0;
  settings.progress = [&](const char*, double) { return ++whole > 0; };
  settings.network.progress = [&](const char*, double) { return ++ofBraces < 3; };
  cooked(ball(Vector3d::Zero()), settings);
  EXPECT_GT(whole, 3);
  EXPECT_EQ(ofBraces, 3) << "once told to end, it asks no more";
}

TEST(Cook, aConeIsARopeWithItsCentreOfMass) {
  constexpr std::uint32_t kRings = 60, kSides = 12;
  TriangleMesh mesh;
  for (std::uint32_t r = 0; r < kRings; ++r)
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const double radius = 0.04 * (1.0 - double(r) / kRings), side = 2.0 * kPi * s / kSides;
      mesh.positions.emplace_back(2.0 * r / kRings, radius * std::cos(side), radius * std::sin(side));
      const std::uint32_t a = r * kSides + s, b = r * kSides + (s + 1) % kSides, tip = kRings * kSides;
      if (r + 1 < kRings) {
        mesh.triangles.push_back({a, a + kSides, b});
        mesh.triangles.push_back({b, a + kSides, b + kSides});
      } else {
        mesh.triangles.push_back({a, tip, b});
      }
      if (r == 0) mesh.triangles.push_back({a, b, tip + 1});
    }
  mesh.positions.emplace_back(2.0, 0.0, 0.0);
  mesh.positions.emplace_back(0.0, 0.0, 0.0);
  const SharedNetwork body = cooked(mesh).bodies.at(0);
  ASSERT_EQ(body->kind, NetworkKind::Rope);
  double middle = 0.0;
  for (std::size_t i = 0; i < body->restPoints.size(); ++i)
    middle += body->massFractions[i] * body->restPoints[i].x();
  EXPECT_NEAR(middle, 0.5, 0.1) << "at a quarter of the length";
}

TEST(Cook, sheetsBecomeClothAndTubesRopes) {
  for (const double wave : {0.0, 0.15}) {
    const CookedMesh cloth = cooked(flag(wave));
    ASSERT_EQ(cloth.bodies.size(), 1u);
    EXPECT_EQ(cloth.bodies[0]->kind, NetworkKind::Cloth);
    EXPECT_GT(cloth.bodies[0]->thickness, 0.0);
  }
  const CookedMesh rope = cooked(tube(2.0, 0.015));
  ASSERT_EQ(rope.bodies.size(), 1u);
  EXPECT_EQ(rope.bodies[0]->kind, NetworkKind::Rope);
  EXPECT_NEAR(rope.bodies[0]->thickness, 0.03, 0.003);
  // a tube as thick as a finger is long is a solid
  EXPECT_EQ(cooked(tube(1.0, 0.1)).bodies[0]->kind, NetworkKind::Solid);
}

TEST(Cook, isDeterministic) {
  EXPECT_EQ(toBytes(*openBallAnew().bodies[0]), toBytes(*cookedOpenBall().bodies[0]));
}

TEST(Cook, errorsSayWhy) {
  CookSettings settings;
  settings.points = 5;
  EXPECT_EQ(cook(ball(Vector3d::Zero()), settings).error(), "points is 5, must be 8 or more, or 0");
  settings = {};
  settings.size = -1.0;
  EXPECT_EQ(cook(ball(Vector3d::Zero()), settings).error(), "size is -1 m, must be above 0");
  settings = {};
  settings.wrap.join = -1.0;
  EXPECT_EQ(cook(ball(Vector3d::Zero()), settings).error(), "wrap.join is -1, must be 0 or more");
  settings.wrap.join = 0.0;
  settings.wrap.resolution = 1e-4;
  settings.pieces = PieceRule::Separate;
  const TriangleMesh two = joined(ball(Vector3d::Zero()), ball({5.0, 0.0, 0.0}));
  EXPECT_EQ(cook(two, settings).error().rfind("wrap.resolution is 0.0001 m, must be larger", 0), 0u);
  settings = {};
  settings.progress = [](const char*, double) { return false; };
  EXPECT_EQ(cook(ball(Vector3d::Zero()), settings).error(), "ended early: progress returned false");
  EXPECT_FALSE(cook(TriangleMesh{}));
}

/// Energy of the springs for a small even strain: J.
double strainEnergy(const SpringNetwork& n, double stiffness, const Eigen::Matrix3d& strain) {
  double energy = 0.0;
  for (const NetworkSpring& s : n.springs) {
    const Vector3d along = n.restPoints[s.b] - n.restPoints[s.a];
    const double x = along.dot(strain * along) / along.norm();
    energy += 0.5 * stiffness * s.stiffnessScale * x * x;
  }
  return energy;
}

double dilationEnergy(const SpringNetwork& n, double stiffness, double e) {
  return strainEnergy(n, stiffness, e * Eigen::Matrix3d::Identity());
}

// a sheet of modulus E, Poisson ratio 1/3 (the lattice's), thickness t: E t A e^2 / (1 - nu)
TEST(CookMaterial, aSheetHasTheEnergyOfItsMaterial) {
  const SharedNetwork body = cooked(flag(0.0)).bodies.at(0);
  Material m;
  m.youngsModulus = 3e5;
  const Result<SoftBodySettings> settings = withMaterial(*body, m);
  ASSERT_TRUE(settings) << settings.error();
  const double e = 1e-3, area = 1.0;
  EXPECT_NEAR(dilationEnergy(*body, settings->extensionStiffness, e),
              m.youngsModulus * body->thickness * area * e * e / (1.0 - 1.0 / 3.0), 1e-9);
  EXPECT_NEAR(settings->totalMass, m.density * area * body->thickness, 1e-9);
}

/// The work on a sheet that is strained by e along an axis and is free to contract across is E t A e^2 / 2.
/// Cells of 1 : 4 have no springs that could do this exactly; equal constants are off by factors of 3 and 8.
TEST(CookMaterial, aSheetIsEquallyStiffAlongAndAcrossStretchedCells) {
  for (const Vector3d& size : {Vector3d(1, 1, 1), Vector3d(2, 0.5, 1)}) {
    TriangleMesh mesh = flag(0.0);
    for (Vector3d& p : mesh.positions) p = p.cwiseProduct(size);
    const SharedNetwork body = cooked(mesh).bodies.at(0);
    const Result<SoftBodySettings> settings = withMaterial(*body, Material::rubber());
    ASSERT_TRUE(settings) << settings.error();
    const auto energy = [&](double x, double y) {
      return strainEnergy(*body, settings->extensionStiffness, Vector3d(x, y, 0).asDiagonal());
    };
    // energy = (a x^2 + 2 b x y + c y^2) / 2
    const double a = 2.0 * energy(1, 0), c = 2.0 * energy(0, 1), b = energy(1, 1) - 0.5 * (a + c);
    const double expected = Material::rubber().youngsModulus * body->thickness;
    EXPECT_NEAR((a - b * b / c) / expected, 1.0, 0.5) << size.transpose();
    EXPECT_NEAR((c - b * b / a) / expected, 1.0, 0.5) << size.transpose();
  }
}

/// Triangles a thirtieth as wide as the others have springs thirty times as stiff: these would rule the time
/// step of the whole sheet.
TEST(CookMaterial, aFewSliversDoNotMakeASheetFast) {
  TriangleMesh mesh = flag(0.0);
  for (Vector3d& p : mesh.positions)
    if (p.x() == 0.5) p.x() -= 0.97 / 16.0;
  const SharedNetwork body = cooked(mesh).bodies.at(0);
  std::vector<double> rates(body->restPoints.size(), 0.0);
  for (const NetworkSpring& s : body->springs)
    for (const std::uint32_t p : {s.a, s.b}) rates[p] += s.stiffnessScale / body->massFractions[p];
  std::sort(rates.begin(), rates.end());
  EXPECT_LT(rates.back(), 1.6 * rates[rates.size() / 2]);
}

// braces: nu is 1/4, so the bulk modulus is 2/3 E and the energy 9/2 K V e^2 = 3 E V e^2
TEST(CookMaterial, aBracedBodyHasTheEnergyOfItsMaterial) {
  CookSettings how;
  how.mode = CookMode::Braces;
  how.points = 60;
  const SharedNetwork body = cooked(ball(Vector3d::Zero()), how).bodies.at(0);
  EXPECT_TRUE(body->tetrahedra.empty());
  const Result<SoftBodySettings> settings = withMaterial(*body, Material::rubber());
  ASSERT_TRUE(settings) << settings.error();
  const double e = 1e-3, volume = settings->totalMass / Material::rubber().density;
  const double expected = 3.0 * Material::rubber().youngsModulus * volume * e * e;
  EXPECT_NEAR(dilationEnergy(*body, settings->extensionStiffness, e), expected, 1e-9 * expected);
}

// A rope of the section A that is strained by e has the energy  E A e^2 / 2  per length. Its arc of 90
// degrees has chords that are shorter than it, those of the springs against bending by 0.1 %.
TEST(CookMaterial, aRopeHasTheStiffnessOfItsMaterial) {
  const SharedNetwork body = cooked(tube(2.0, 0.015)).bodies.at(0);
  const Result<SoftBodySettings> settings = withMaterial(*body, Material::rubber());
  ASSERT_TRUE(settings) << settings.error();
  const double section = 0.25 * kPi * body->thickness * body->thickness, e = 1e-3;
  const double expected = 0.5 * Material::rubber().youngsModulus * section * e * e * 2.0;
  EXPECT_NEAR(dilationEnergy(*body, settings->extensionStiffness, e), expected, 0.03 * expected);
  EXPECT_EQ(settings->pointRadius, 0.5 * body->thickness);
}

TEST(CookMaterial, aClosedTubeOfAnySectionHasTheMassOfItsVolume) {
  TriangleMesh rod = small_meshes::cube(16);
  for (Vector3d& p : rod.positions) p = p.cwiseProduct(Vector3d(0.02, 1.0, 0.02));
  const SharedNetwork body = cooked(rod).bodies.at(0);
  ASSERT_EQ(body->kind, NetworkKind::Rope);
  const Result<SoftBodySettings> settings = withMaterial(*body, Material::rubber());
  ASSERT_TRUE(settings) << settings.error();
  EXPECT_NEAR(settings->totalMass, Material::rubber().density * 4e-4, 1e-9);
}

/// Strips and rods of few sides have edges that cross them: the middles of their sections are not those of
/// the edges. A rope that zigzags is softer than its material, and shorter than the tube.
TEST(Cook, ropesRunStraightThroughStraightTubes) {
  TriangleMesh strip = small_meshes::cube(16);
  for (Vector3d& p : strip.positions) p = p.cwiseProduct(Vector3d(0.02, 1.0, 0.002));
  const SharedNetwork body = cooked(strip).bodies.at(0);
  ASSERT_EQ(body->kind, NetworkKind::Rope);
  const std::vector<Vector3d>& axis = body->restPoints;
  double length = 0.0;
  for (std::size_t i = 1; i < axis.size(); ++i) length += (axis[i] - axis[i - 1]).norm();
  EXPECT_NEAR((axis.back() - axis.front()).norm(), 1.0, 0.002);
  EXPECT_NEAR(length, (axis.back() - axis.front()).norm(), 0.002);
}

TEST(Cook, sheetsOfMixedOrientationGetOneSide) {
  for (const std::size_t period : {2u, 3u, 5u}) {
    TriangleMesh mesh = flag(0.0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (t / 2 % period == 0) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    const SharedNetwork body = cooked(mesh).bodies.at(0);
    ASSERT_EQ(body->kind, NetworkKind::Cloth);
    const std::vector<Vector3d>& p = body->restPoints;
    double area = 0.0;
    for (const Triangle& t : body->surface) area += 0.5 * (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).z();
    EXPECT_NEAR(std::abs(area), 1.0, 1e-6) << period;
  }
}

/// As after a boolean operation of a modeller: the faces are closed, but have other vertices on their edges.
TEST(Cook, openingsWithoutAreaDoNotMakeASheet) {
  TriangleMesh mesh = small_meshes::cube(4);
  const std::vector<Triangle> all = mesh.triangles;
  mesh.triangles.clear();
  for (const Triangle& t : all)
    if (std::min({mesh.positions[t[0]].y(), mesh.positions[t[1]].y(), mesh.positions[t[2]].y()}) < 0.5)
      mesh.triangles.push_back(t);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const auto& [x, z] :
       {std::pair(-0.5, -0.5), std::pair(-0.5, 0.5), std::pair(0.5, 0.5), std::pair(0.5, -0.5)})
    mesh.positions.emplace_back(x, 0.5, z);
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  const SharedNetwork body = cooked(mesh).bodies.at(0);
  double volume = 0.0;
  for (const Tetrahedron& t : body->tetrahedra) volume += volumeOf(body->restPoints, t);
  EXPECT_NEAR(volume, 1.0, 0.1);
}

TEST(Cook, cubesThatTouchInAnEdgeAreOneBody) {
  TriangleMesh second = small_meshes::cube(4);
  for (Vector3d& p : second.positions) p += Vector3d(1, 1, 0);
  CookSettings settings;
  settings.points = 100;
  const CookedMesh c = cooked(joined(small_meshes::cube(4), second), settings);
  ASSERT_EQ(c.bodies.size(), 1u);
  double volume = 0.0;
  for (const Tetrahedron& t : c.bodies[0]->tetrahedra) volume += volumeOf(c.bodies[0]->restPoints, t);
  EXPECT_NEAR(volume, 2.0, 0.3) << "with the joint along the edge";
}

TEST(Cook, closedPlatesBecomeClothInTheirMiddle) {
  TriangleMesh mesh = small_meshes::cube(8);
  for (Vector3d& p : mesh.positions) p.y() *= 0.02;
  const SharedNetwork body = cooked(mesh).bodies.at(0);
  ASSERT_EQ(body->kind, NetworkKind::Cloth);
  EXPECT_NEAR(body->thickness, 0.02, 1e-12);
  for (const Vector3d& p : body->restPoints) EXPECT_NEAR(p.y(), 0.0, 1e-12);
  for (const std::uint32_t point : body->render.vertexToPoint) EXPECT_NE(point, kNoPoint);
}

TEST(Cook, platesWithADefectBecomeClothInTheirMiddle) {
  for (const bool isTurned : {false, true}) {
    TriangleMesh mesh = small_meshes::cube(8);
    for (Vector3d& p : mesh.positions) p.y() *= 0.02;
    if (isTurned)
      std::swap(mesh.triangles[9][1], mesh.triangles[9][2]);
    else
      mesh.triangles.erase(mesh.triangles.begin() + 9);
    const SharedNetwork body = cooked(mesh).bodies.at(0);
    ASSERT_EQ(body->kind, NetworkKind::Cloth);
    EXPECT_NEAR(body->thickness, 0.02, 1e-3);
    double farthest = 0.0;
    for (const Vector3d& p : body->restPoints) farthest = std::max(farthest, std::abs(p.y()));
    EXPECT_LT(farthest, 1e-3) << isTurned;
  }
}

/// A disc of triangles around its middle, as modellers make them.
TEST(Cook, fansHaveFewSprings) {
  constexpr std::uint32_t kRim = 300;
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < kRim; ++i) {
    mesh.positions.emplace_back(std::cos(2.0 * kPi * i / kRim), 0.0, std::sin(2.0 * kPi * i / kRim));
    mesh.triangles.push_back({i, (i + 1) % kRim, kRim});
  }
  mesh.positions.emplace_back(Vector3d::Zero());
  const SharedNetwork body = cooked(mesh).bodies.at(0);
  ASSERT_EQ(body->kind, NetworkKind::Cloth);
  EXPECT_LT(body->springs.size(), 6 * body->restPoints.size());
}

/// A closed plate of 1 x 1 m of 8 x 8 cells, without those in the middle.
TriangleMesh plateWithHole(double thickness) {
  constexpr int kCells = 8;
  const auto isSolid = [](int i, int j) {
    const bool inside = i >= 0 && j >= 0 && i < kCells && j < kCells;
    return inside && !(i >= 3 && i < 5 && j >= 3 && j < 5);
  };
  TriangleMesh mesh;
  const auto corner = [&](int i, int j, int top) {
    mesh.positions.emplace_back(double(i) / kCells, (top - 0.5) * thickness, double(j) / kCells);
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
  };
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      if (!isSolid(i, j)) continue;
      add(corner(i, j, 1), corner(i, j + 1, 1), corner(i + 1, j + 1, 1), corner(i + 1, j, 1));
      add(corner(i, j, 0), corner(i + 1, j, 0), corner(i + 1, j + 1, 0), corner(i, j + 1, 0));
      const auto side = [&](int x0, int z0, int x1, int z1) {
        add(corner(x0, z0, 0), corner(x0, z0, 1), corner(x1, z1, 1), corner(x1, z1, 0));
      };
      if (!isSolid(i - 1, j)) side(i, j + 1, i, j);
      if (!isSolid(i + 1, j)) side(i + 1, j, i + 1, j + 1);
      if (!isSolid(i, j - 1)) side(i, j, i + 1, j);
      if (!isSolid(i, j + 1)) side(i + 1, j + 1, i, j + 1);
    }
  return mesh;
}

/// Places of the mesh lie exactly on edges of the tetrahedra: their barycentric coordinates are rounding
/// errors there. Turned, the plate is the same.
TEST(Cook, aPlateWithAHoleIsFilledAndSkinned) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.8, Vector3d(1, 2, 3).normalized()));
  for (const bool isTurned : {false, true}) {
    TriangleMesh mesh = plateWithHole(0.064);
    if (isTurned)
      for (Vector3d& p : mesh.positions) p = turn * p;
    const SharedNetwork body = cooked(mesh).bodies.at(0);
    EXPECT_NEAR(body->volume, 60.0 / 64.0 * 0.064, 1e-9);
    double volume = 0.0;
    for (const Tetrahedron& t : body->tetrahedra) volume += volumeOf(body->restPoints, t);
    EXPECT_NEAR(volume / body->volume, 1.0, 0.05) << isTurned;
  }
}

/// A plate of 5 % of its length is thinner than the tetrahedra of 200 points. Its tetrahedra are as flat as
/// it is: thickened by the lattice, it had twice its thickness.
TEST(Cook, platesKeepTheirThickness) {
  const double thickness = 0.05;
  for (TriangleMesh mesh : {small_meshes::cube(8), test_shapes::lShape()}) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()));
    for (Vector3d& p : mesh.positions) p = turn * p.cwiseProduct(Vector3d(1.0, 1.0, thickness));
    CookSettings settings;
    settings.points = 200;
    const CookedMesh c = cooked(mesh, settings);
    const SharedNetwork& body = c.bodies.at(0);
    EXPECT_GT(body->volume, 0.0) << c.report[1];
    EXPECT_FALSE(body->tetrahedra.empty());
    double low = HUGE_VAL, high = -HUGE_VAL, meshLow = HUGE_VAL, meshHigh = -HUGE_VAL;
    for (const Vector3d& p : body->restPoints) {
      low = std::min(low, (turn.inverse() * p).z());
      high = std::max(high, (turn.inverse() * p).z());
    }
    for (const Vector3d& p : mesh.positions) {
      meshLow = std::min(meshLow, (turn.inverse() * p).z());
      meshHigh = std::max(meshHigh, (turn.inverse() * p).z());
    }
    EXPECT_NEAR((high - low) / (meshHigh - meshLow), 1.0, 0.1) << c.report[1];
  }
}

TEST(CookMaterial, dampingFollowsTheStiffness) {
  CookSettings coarse;
  coarse.points = 60;
  const SharedNetwork body = cooked(ball(Vector3d::Zero()), coarse).bodies.at(0);
  const Result<SoftBodySettings> settings = withMaterial(*body, Material::jelly());
  ASSERT_TRUE(settings) << settings.error();
  EXPECT_DOUBLE_EQ(settings->damping, *Material::jelly().dampingTime * settings->extensionStiffness);
  Material bad = Material::jelly();
  bad.dampingTime = -1.0;
  EXPECT_EQ(withMaterial(*body, bad).error(), "dampingTime is -1, must be 0 or more");
}

}  // namespace
}  // namespace limber

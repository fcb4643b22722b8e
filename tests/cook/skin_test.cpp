// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>

#include "network/skin.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <limber/mesh.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using Eigen::Vector3d;
using limber::SkinKind;
using limber::SkinSettings;
using limber::SkinWeights;
using limber::SpringNetwork;
using limber::TriangleMesh;
using limber::WeldedMesh;

namespace {

constexpr SkinKind kKinds[] = {SkinKind::Dense, SkinKind::Sparse, SkinKind::Barycentric};

using Points = std::vector<Vector3d>;
using Motion = Vector3d (*)(const Vector3d&);

Vector3d affine(const Vector3d& p) {
  Eigen::Matrix3d a;
  a << 1.2, 0.3, -0.1, 0.2, 0.8, 0.1, -0.3, 0.1, 1.1;
  return a * p + Vector3d(3, -2, 1);
}

/// Bends by 1 rad per metre of height.
Vector3d bend(const Vector3d& p) {
  return {(1.0 + p.x()) * std::cos(p.y()) - 1.0, (1.0 + p.x()) * std::sin(p.y()), p.z()};
}

/// Twists by a quarter turn per metre of height.
Vector3d twist(const Vector3d& p) {
  const double angle = 1.57 * p.y(), c = std::cos(angle), s = std::sin(angle);
  return {c * p.x() - s * p.z(), p.y(), s * p.x() + c * p.z()};
}

Vector3d squash(const Vector3d& p) {
  const double width = 1.0 / std::sqrt(0.7 + 0.3 * p.y() * p.y());
  return {width * p.x(), 0.7 * p.y() + 0.1 * p.y() * p.y(), width * p.z()};
}

/// Adds waves with a length of about the body's size and an amplitude of a twentieth of it.
Vector3d wobble(const Vector3d& p) {
  return p + 0.05 * Vector3d(std::sin(6 * p.y() + 1), std::sin(6 * p.z()), std::sin(6 * p.x() + 2));
}

SpringNetwork networkOf(const WeldedMesh& mesh) {
  SpringNetwork network;
  network.restPoints = mesh.points;
  network.surface = mesh.triangles;
  network.massFractions.assign(mesh.points.size(), 1.0 / double(mesh.points.size()));
  return network;
}

SpringNetwork coarseNetwork(const TriangleMesh& mesh, std::uint32_t points) {
  return networkOf(*weld(*simplify(mesh, points)));
}

Points moved(Points points, Motion motion) {
  for (Vector3d& p : points) p = motion(p);
  return points;
}

Points applyWeights(const SkinWeights& skin, const Points& points) {
  Points vertices(skin.firstWeight.size() - 1, Vector3d::Zero());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (std::uint32_t w = skin.firstWeight[i]; w < skin.firstWeight[i + 1]; ++w)
      vertices[i] += skin.weights[w] * points[skin.points[w]];
  }
  return vertices;
}

double largestError(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

double rmsError(const Points& a, const Points& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / double(a.size()));
}

double meanNormalError(const WeldedMesh& mesh, const Points& a, const Points& b) {
  const Points onA = limber::vertexNormals(a, mesh.triangles), onB = limber::vertexNormals(b, mesh.triangles);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::acos(std::min(1.0, onA[i].dot(onB[i])));
  return sum / double(a.size());
}

SkinSettings settingsOf(SkinKind kind) {
  SkinSettings settings;
  settings.kind = kind;
  return settings;
}

}  // namespace

TEST(Skin, affineMotionsAreExact) {
  const TriangleMesh meshes[] = {test_shapes::rabbit(0.03), test_shapes::horseshoe(0.04),
                                 small_meshes::cube(12), test_shapes::lShape()};
  for (const TriangleMesh& mesh : meshes) {
    const WeldedMesh welded = *weld(mesh);
    const SpringNetwork network = coarseNetwork(mesh, 60);
    for (const SkinKind kind : kKinds) {
      const auto weights = skinWeights(network, welded, settingsOf(kind));
      ASSERT_TRUE(weights) << weights.error();
      EXPECT_LT(largestError(applyWeights(*weights, moved(network.restPoints, affine)),
                             moved(welded.points, affine)),
                1e-10);
    }
  }
}

/// 100 points for 8 320 vertices.
TEST(Skin, smoothDeformations) {
  const WeldedMesh mesh = *weld(test_shapes::rabbit(0.0142));
  const SpringNetwork network = coarseNetwork(test_shapes::rabbit(0.0142), 100);
  struct Limit {
    SkinKind kind;
    double position, normal;  // m, rad
  };
  // limit of 1e-3 of the size for radial weights; barycentric ones are piecewise linear
  for (const Limit& limit : {Limit{SkinKind::Dense, 1e-3, 0.01}, Limit{SkinKind::Sparse, 1e-3, 0.01},
                             Limit{SkinKind::Barycentric, 5e-3, 0.1}}) {
    const auto weights = skinWeights(network, mesh, settingsOf(limit.kind));
    ASSERT_TRUE(weights) << weights.error();
    for (const Motion motion : {bend, twist, squash, wobble}) {
      const Points found = applyWeights(*weights, moved(network.restPoints, motion));
      const Points expected = moved(mesh.points, motion);
      EXPECT_LT(rmsError(found, expected), limit.position);
      EXPECT_LT(meanNormalError(mesh, found, expected), limit.normal);
    }
  }
}

/// The points of the cube sample the motion on flat faces only.
TEST(Skin, smoothDeformationsOfACube) {
  const WeldedMesh mesh = *weld(small_meshes::cube(20));
  const SpringNetwork network = coarseNetwork(small_meshes::cube(20), 100);
  const SkinWeights skin = *skinWeights(network, mesh, settingsOf(SkinKind::Dense));
  for (const Motion motion : {bend, twist, squash})
    EXPECT_LT(rmsError(applyWeights(skin, moved(network.restPoints, motion)), moved(mesh.points, motion)),
              1e-3);
}

namespace {

/// Returns the mean displacement of the vertices at x > 0 in the region, divided by that of the points at x <
/// 0 in it.
double bleeding(const SkinWeights& skin, const SpringNetwork& network, const WeldedMesh& mesh,
                bool (*inRegion)(const Vector3d&)) {
  Points points = network.restPoints;
  for (Vector3d& p : points) {
    if (inRegion(p) && p.x() < 0.0) p.x() -= 0.1;
  }
  const Points vertices = applyWeights(skin, points);
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (!inRegion(mesh.points[i]) || mesh.points[i].x() < 0.0) continue;
    sum += (vertices[i] - mesh.points[i]).norm();
    count += 1.0;
  }
  return sum / count / 0.1;
}

bool isHorseshoeEnd(const Vector3d& p) { return p.y() > 0.2 && std::abs(p.x()) < 0.2; }
bool isEar(const Vector3d& p) { return p.y() > 0.25; }

}  // namespace

TEST(Skin, partsThatNearlyTouchDoNotDragEachOther) {
  struct Case {
    TriangleMesh mesh;
    bool (*inRegion)(const Vector3d&);
    double
        withoutGaps;  // the motion of the other part if gaps are ignored, which shows that the test can fail
  };
  const Case cases[] = {{test_shapes::horseshoe(0.025), isHorseshoeEnd, 0.05},
                        {test_shapes::rabbit(0.025), isEar, 0.02}};
  for (const Case& c : cases) {
    const WeldedMesh mesh = *weld(c.mesh);
    const SpringNetwork network = coarseNetwork(c.mesh, 100);
    for (const SkinKind kind : kKinds) {
      const auto weights = skinWeights(network, mesh, settingsOf(kind));
      ASSERT_TRUE(weights) << weights.error();
      EXPECT_LT(bleeding(*weights, network, mesh, c.inRegion), 0.002);
    }
    limber::SkinProblem problem{network.restPoints, mesh.points, {}, {}};
    problem.variances.resize(Eigen::Index(mesh.points.size()), Eigen::Index(network.restPoints.size()));
    EXPECT_GT(bleeding(denseWeights(problem), network, mesh, c.inRegion), c.withoutGaps);
  }
}

TEST(Skin, bodiesApartDoNotDragEachOther) {
  const TriangleMesh ball = small_meshes::icosphere(2);
  const TriangleMesh mesh = small_meshes::joined(ball, small_meshes::moved(ball, {2.1, 0, 0}));
  const WeldedMesh welded = *weld(mesh);
  const SpringNetwork network = coarseNetwork(mesh, 84);
  Points points = network.restPoints;
  for (Vector3d& p : points) p.y() += p.x() > 1.05 ? 0.1 : 0.0;
  for (const SkinKind kind : kKinds) {
    const Points vertices = applyWeights(*skinWeights(network, welded, settingsOf(kind)), points);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const double expected = welded.points[i].x() > 1.05 ? 0.1 : 0.0;
      EXPECT_NEAR(vertices[i].y() - welded.points[i].y(), expected, 0.001) << i;
    }
  }
}

TEST(Skin, placesInPointsMoveWithThem) {
  const WeldedMesh mesh = *weld(small_meshes::icosphere(2));
  const SpringNetwork network = networkOf(mesh);
  for (const SkinKind kind : kKinds) {
    const SkinWeights skin = *skinWeights(network, mesh, settingsOf(kind));
    EXPECT_LT(largestError(applyWeights(skin, moved(mesh.points, wobble)), moved(mesh.points, wobble)), 1e-9);
  }
}

TEST(Skin, sparseKeepsToItsNeighbours) {
  const TriangleMesh box = small_meshes::cube(16);  // whose nearest neighbours are in a plane
  const WeldedMesh mesh = *weld(box);
  const SpringNetwork network = coarseNetwork(box, 200);
  for (const std::uint32_t neighbours : {4u, 32u}) {
    SkinSettings settings = settingsOf(SkinKind::Sparse);
    settings.neighbours = neighbours;
    const SkinWeights skin = *skinWeights(network, mesh, settings);
    double largest = 0.0;
    for (const double w : skin.weights) largest = std::max(largest, std::abs(w));
    EXPECT_LT(largest, 3.0) << "of weights that sum to 1: no far extrapolation";
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
      EXPECT_EQ(skin.firstWeight[i + 1] - skin.firstWeight[i], neighbours);
    EXPECT_LT(largestError(applyWeights(skin, moved(network.restPoints, affine)), moved(mesh.points, affine)),
              1e-10);
  }
}

TEST(Skin, tetrahedraCarryWhatIsInThem) {
  SpringNetwork network = networkOf(*weld(small_meshes::cube()));
  network.restPoints.emplace_back(0, 0, 0);
  network.massFractions.assign(9, 1.0 / 9.0);
  for (const limber::Triangle& t : network.surface) network.tetrahedra.push_back({8, t[0], t[1], t[2]});
  ASSERT_EQ(validate(network).error(), "");
  TriangleMesh ball = small_meshes::icosphere(2);
  for (Vector3d& p : ball.positions) p = 0.4 * p;
  const SkinWeights skin = *skinWeights(network, *weld(ball), settingsOf(SkinKind::Barycentric));
  EXPECT_EQ(skin.weights.size(), 4u * 162u);
  EXPECT_GE(*std::min_element(skin.weights.begin(), skin.weights.end()), -1e-12);
}

TEST(Skin, networkWithSkin) {
  TriangleMesh mesh = test_shapes::rabbit(0.05);
  mesh.positions.emplace_back(9, 9, 9);  // used by no triangle
  mesh.uvs.resize(mesh.positions.size(), Eigen::Vector2f(0.25f, 0.5f));
  const SpringNetwork network = coarseNetwork(mesh, 60);
  for (const SkinKind kind : kKinds) {
    const auto skinned = withSkin(network, mesh, settingsOf(kind));
    ASSERT_TRUE(skinned) << skinned.error();
    const limber::RenderSurface& render = (*skinned)->render;
    EXPECT_EQ(validate(**skinned).error(), "");
    EXPECT_EQ((*skinned)->restPoints, network.restPoints);
    EXPECT_EQ(render.triangles, mesh.triangles);
    EXPECT_EQ(render.uvs, mesh.uvs);
    EXPECT_EQ(render.vertexToPoint.back(), limber::kNoPoint);

    std::vector<float> points, vertices(3 * render.skin.size());
    for (const Vector3d& p : network.restPoints) {
      for (int axis = 0; axis < 3; ++axis) points.push_back(static_cast<float>(affine(p)[axis]) + 1000.0f);
    }
    applySkin(render.skin, points.data(), vertices.data());
    for (std::size_t i = 0; i + 1 < mesh.positions.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        // floats near 1000 are 6e-5 apart, and the absolute weights sum to ten and more
        EXPECT_NEAR(double(vertices[3 * render.vertexToPoint[i] + std::size_t(axis)]),
                    affine(mesh.positions[i])[axis] + 1000.0, 4e-4);
      }
    }
  }
}

TEST(Skin, roundedWeightsSumToOne) {
  const TriangleMesh mesh = test_shapes::figure();
  const limber::Skin skin = rounded(*skinWeights(coarseNetwork(mesh, 100), *weld(mesh), {}));
  for (std::size_t i = 0; i < skin.size(); ++i) {
    double sum = 0.0;
    for (std::uint32_t w = skin.firstWeight[i]; w < skin.firstWeight[i + 1]; ++w)
      sum += double(skin.weights[w]);
    // half the distance between floats of about 1 / 100, the magnitude of the smallest weights at most
    EXPECT_NEAR(sum, 1.0, 5e-10);
  }
}

TEST(Skin, errors) {
  const TriangleMesh mesh = small_meshes::cube(2);
  const SpringNetwork network = networkOf(*weld(mesh));
  SkinSettings settings;
  settings.neighbours = 3;
  EXPECT_EQ(withSkin(network, mesh, settings).error(),
            "a skin of 3 neighbours per vertex is not possible, it needs 4 or more");
  EXPECT_EQ(withSkin(networkOf(*weld(small_meshes::singleTriangle())), mesh).error(),
            "the points of the network lie in a plane, so they cannot move a skin");
  EXPECT_EQ(withSkin(SpringNetwork{}, mesh).error(), "network: the network has no points");
  EXPECT_EQ(withSkin(**limber::buildRope(), mesh).error(), "a network without a surface has no skin");
  EXPECT_EQ(withSkin(network, TriangleMesh{}).error(), "the mesh has no vertices");
}

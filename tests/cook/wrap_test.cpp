// SPDX-License-Identifier: Zlib
// wrap(): a closed surface around meshes that are none.

#include "mesh/surface.h"
#include "support/small_meshes.h"

#include <limber/mesh.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>

namespace limber {
namespace {

using small_meshes::joined;

/// A box of 12 triangles.
TriangleMesh box(const Eigen::Vector3d& middle, const Eigen::Vector3d& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
    mesh.positions.push_back(middle + corner.cwiseProduct(size));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A square sheet of side 1 in the plane z = 0.
TriangleMesh sheet() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

const Eigen::Vector3d kOrigin = Eigen::Vector3d::Zero(), kOnes = Eigen::Vector3d::Ones();

WrappedMesh wrappedOrFail(const TriangleMesh& mesh, const WrapSettings& settings = {}) {
  Result<WrappedMesh> wrapped = wrap(mesh, settings);
  if (!wrapped) {
    ADD_FAILURE() << wrapped.error();
    return {};
  }
  const Result<WeldedMesh> welded = weld(wrapped->mesh);
  EXPECT_TRUE(welded && welded->report.watertight());
  EXPECT_NEAR(signedVolume(wrapped->mesh.positions, wrapped->mesh.triangles), wrapped->volume,
              1e-9 * std::abs(wrapped->volume));
  return std::move(*wrapped);
}

/// A box whose face towards z has a square hole.
TriangleMesh boxWithHole(double size, double hole) {
  TriangleMesh mesh = box(kOrigin, size * kOnes);
  mesh.triangles.erase(mesh.triangles.begin() + 2, mesh.triangles.begin() + 4);
  for (int i = 0; i < 4; ++i)
    mesh.positions.push_back(
        {i & 1 ? 0.5 * hole : -0.5 * hole, i & 2 ? 0.5 * hole : -0.5 * hole, 0.5 * size});
  for (const auto& [a, b] : {std::pair(0u, 1u), std::pair(1u, 3u), std::pair(3u, 2u), std::pair(2u, 0u)}) {
    mesh.triangles.push_back({4 + a, 4 + b, 8 + b});
    mesh.triangles.push_back({4 + a, 8 + b, 8 + a});
  }
  return mesh;
}

/// A closed box-shaped bottle with walls of 0.1 and a neck of 0.2.
TriangleMesh bottle() {
  TriangleMesh mesh = joined(boxWithHole(1.0, 0.2), small_meshes::inverted(boxWithHole(0.8, 0.2)));
  for (const auto& [a, b] : {std::pair(0u, 1u), std::pair(1u, 3u), std::pair(3u, 2u), std::pair(2u, 0u)}) {
    mesh.triangles.push_back({8 + a, 8 + b, 20 + b});
    mesh.triangles.push_back({8 + a, 20 + b, 20 + a});
  }
  return mesh;
}

/// Thick walls close the hole. The hollow behind is a piece of the surface, but none that needs a rod: one
/// grew out of the grid and left holes.
TEST(Wrap, hollowsGetNoRods) {
  ASSERT_TRUE(weld(bottle())->report.watertight());
  WrapSettings settings;
  settings.connect = true;
  settings.resolution = 0.02;
  for (const double thickness : {0.1, 0.3, 0.4}) {
    settings.thickness = thickness;
    const WrappedMesh w = wrappedOrFail(bottle(), settings);
    EXPECT_EQ(w.pieces, thickness > 0.2 ? 2u : 1u) << thickness;
    EXPECT_EQ(w.rods, 0u) << thickness;
  }
}

// a surface within half a cell of the mesh: its volume is within area / 2 cells of the box's
TEST(Wrap, aClosedBoxKeepsItsVolume) {
  const WrappedMesh w = wrappedOrFail(box(kOrigin, kOnes));
  EXPECT_EQ(w.pieces, 1u);
  EXPECT_NEAR(w.volume, 1.0, 0.5 * 6.0 * w.resolution);
  EXPECT_LT(w.thinFraction, 0.05);
}

TEST(Wrap, aBoxWithoutLidIsClosed) {
  TriangleMesh open = box(kOrigin, kOnes);
  open.triangles.resize(10);
  const WrappedMesh w = wrappedOrFail(open);
  EXPECT_EQ(w.pieces, 1u);
  EXPECT_NEAR(w.volume, 1.0, 0.25);  // the cap over the hole bends inward
}

TEST(Wrap, orientationDoesNotMatter) {
  const TriangleMesh outward = box(kOrigin, kOnes);
  const TriangleMesh inward = small_meshes::inverted(outward);
  TriangleMesh mixed = outward;
  for (std::size_t i = 0; i < mixed.triangles.size(); i += 3)
    std::swap(mixed.triangles[i][1], mixed.triangles[i][2]);
  const double volume = wrappedOrFail(outward).volume;
  EXPECT_NEAR(wrappedOrFail(inward).volume, volume, 1e-9);
  EXPECT_NEAR(wrappedOrFail(mixed).volume, volume, 1e-9);
}

TEST(Wrap, aSheetGetsAThickness) {
  WrapSettings settings;
  settings.resolution = 0.01;
  settings.thickness = 0.06;
  const WrappedMesh w = wrappedOrFail(sheet(), settings);
  // a slab with a rounded rim: t + pi (t/2)^2 / 2 along each of four sides
  const double t = 0.06, expected = t + 4.0 * 0.125 * 3.14159265 * t * t;
  EXPECT_NEAR(w.volume, expected, 0.05 * expected);
  EXPECT_EQ(w.thinFraction, 1.0);
}

TEST(Wrap, thinPartsGetTheThicknessAboutTheirMiddle) {
  WrapSettings settings;
  settings.resolution = 0.01;
  settings.thickness = 0.1;
  const WrappedMesh w = wrappedOrFail(box(kOrigin, {1.0, 1.0, 0.06}), settings);
  Eigen::AlignedBox3d around;
  for (const Eigen::Vector3d& p : w.mesh.positions) around.extend(p);
  EXPECT_NEAR(around.sizes().z(), 0.1, 0.02);
  EXPECT_NEAR(around.center().z(), 0.0, 0.01);
}

TEST(Wrap, piecesAreJoinedAcrossNarrowGapsOnly) {
  const TriangleMesh near = joined(box(kOrigin, kOnes), box({1.02, 0, 0}, kOnes));
  const TriangleMesh far = joined(box(kOrigin, kOnes), box({1.3, 0, 0}, kOnes));
  EXPECT_EQ(wrappedOrFail(near).pieces, 1u);
  EXPECT_EQ(wrappedOrFail(far).pieces, 2u);
}

TEST(Wrap, rodsConnectFarPieces) {
  TriangleMesh mesh = joined(box(kOrigin, kOnes), box({1.4, 0, 0}, kOnes));
  mesh = joined(mesh, box({0, 1.5, 0}, kOnes));
  WrapSettings settings;
  settings.connect = true;
  const WrappedMesh w = wrappedOrFail(mesh, settings);
  EXPECT_EQ(w.pieces, 1u);
  EXPECT_EQ(w.rods, 2u);
  EXPECT_NEAR(w.volume, 3.0, 0.3);
}

TEST(Wrap, overlappingPiecesAreUnited) {
  const WrappedMesh w = wrappedOrFail(joined(box(kOrigin, kOnes), box({0.5, 0, 0}, kOnes)));
  EXPECT_EQ(w.pieces, 1u);
  EXPECT_NEAR(w.volume, 1.5, 0.5 * 8.0 * w.resolution);
}

// two walls across the inside: edges of three and four triangles have no side that is outside
TEST(Wrap, aBoxWithInnerWallsIsClosed) {
  TriangleMesh mesh = box(kOrigin, kOnes);
  mesh.triangles.push_back({0, 1, 7});
  mesh.triangles.push_back({0, 7, 6});
  const WrappedMesh w = wrappedOrFail(mesh);
  Eigen::AlignedBox3d around;
  for (const Eigen::Vector3d& p : w.mesh.positions) around.extend(p);
  EXPECT_NEAR(around.sizes().maxCoeff(), 1.0, 2.5 * w.thickness);
}

// finer than the limit, a box would need 8e9 cells
TEST(Wrap, refusesWhatItCannotDo) {
  WrapSettings settings;
  settings.resolution = 5e-4;
  EXPECT_EQ(wrap(box(kOrigin, kOnes), settings).error().rfind("resolution is 0.0005 m, must be larger", 0),
            0u);
  settings.resolution = -1.0;
  EXPECT_EQ(wrap(box(kOrigin, kOnes), settings).error(), "resolution is -1, must be 0 or more");
  EXPECT_FALSE(wrap(TriangleMesh{}));
}

TEST(Wrap, isDeterministic) {
  const TriangleMesh mesh = joined(box(kOrigin, kOnes), box({1.3, 0.2, 0.1}, {0.4, 0.5, 0.6}));
  const WrappedMesh a = wrappedOrFail(mesh), b = wrappedOrFail(mesh);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
}

}  // namespace
}  // namespace limber

// SPDX-License-Identifier: Zlib
// Surfaces that intersect themselves are reported, and still give bodies.
#include "analysis/analysis.h"
#include "support/network_shapes.h"
#include "support/small_meshes.h"

#include <limber/network_analysis.h>
#include <limber/network_builder.h>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace limber {
namespace {

/// Two balls of radius 1, `apart` metres from each other along x, and a little displaced along y and z: exact
/// mirror images would touch edge to edge.
TriangleMesh twoBalls(double apart) {
  const TriangleMesh ball = small_meshes::icosphere(2);
  return small_meshes::joined(ball, small_meshes::moved(ball, {apart, 0.1, 0.05}));
}

std::size_t piercingEdges(const TriangleMesh& mesh) {
  return countPiercingEdges(mesh.positions, mesh.triangles);
}

TEST(SelfIntersections, areNoneInSoundShapes) {
  for (const auto& mesh : {network_shapes::cube98(), network_shapes::lshape90(), network_shapes::torus128(),
                           network_shapes::rabbit302(), network_shapes::cloth100(), twoBalls(2.1)})
    EXPECT_EQ(piercingEdges(mesh), 0u);
  EXPECT_EQ(countPiercingEdges({}, {}), 0u);
}

TEST(SelfIntersections, areFoundWhereABallIsInAnother) {
  EXPECT_GT(piercingEdges(twoBalls(1.0)), 20u);
  // a spike through a triangle: its two edges at the tip pierce it
  TriangleMesh spike = small_meshes::singleTriangle();
  const Eigen::Vector3d middle = (spike.positions[0] + spike.positions[1] + spike.positions[2]) / 3.0;
  const Eigen::Vector3d normal =
      (spike.positions[1] - spike.positions[0]).cross(spike.positions[2] - spike.positions[0]).normalized();
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(middle + normal), Eigen::Vector3d(middle - 0.9 * normal),
                                   Eigen::Vector3d(middle + normal + 0.01 * normal.unitOrthogonal())})
    spike.positions.push_back(p);
  spike.triangles.push_back({3, 4, 5});
  EXPECT_EQ(piercingEdges(spike), 2u);
}

TEST(SelfIntersections, areReportedAndTheBodyMadeAllTheSame) {
  const Result<SharedNetwork> network = buildNetwork(twoBalls(1.0));
  ASSERT_TRUE(network) << network.error();
  AnalysisSettings settings;
  settings.runs = 0;
  const NetworkAnalysis analysis = analyse(**network, settings);
  EXPECT_GT(analysis.piercingEdges, 20u);
  EXPECT_NE(describe(analysis).find("through a triangle"), std::string::npos) << describe(analysis);
}

}  // namespace
}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "fuzz/networks.h"

#include "support/networks.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <limber/network_builder.h>

#include <map>
#include <stdexcept>

namespace limber::fuzz {
namespace {

SharedNetwork built(const TriangleMesh& mesh, BraceRule rule, double size = 1.0) {
  TriangleMesh sized = mesh;
  for (Eigen::Vector3d& p : sized.positions) p *= size;
  NetworkSettings settings;
  settings.braces = rule;
  return *buildNetwork(sized, settings);
}

SharedNetwork rope(std::uint32_t segments, double bending) {
  RopeSettings settings;
  settings.segments = segments;
  settings.bendingScale = bending;
  return *buildRope(settings);
}

SharedNetwork material() {
  MaterialMesh settings;
  settings.points = 30;
  return *buildMaterialNetwork(small_meshes::cube(2), settings);
}

/// Returns four points without springs.
SharedNetwork points() {
  auto made = std::make_shared<SpringNetwork>();
  for (int i = 0; i < 4; ++i) made->restPoints.emplace_back(0.3 * i, 0.2 * (i % 2), 0.1 * i);
  made->massFractions.assign(4, 0.25);
  return made;
}

SharedNetwork cook(const std::string& name) {
  if (name == "cube") return test::closedCubeNetwork();
  if (name == "full-cube") return test::fullCubeNetwork();
  if (name == "cube-mesh") return built(small_meshes::cube(1), BraceRule::Pipeline);
  if (name == "cube-fine") return built(small_meshes::cube(3), BraceRule::TwoRing);
  if (name == "ball") return built(small_meshes::icosphere(1), BraceRule::TwoRing, 0.5);
  if (name == "ball-fine") return built(small_meshes::icosphere(2), BraceRule::TwoRing, 0.5);
  if (name == "torus") return built(test_shapes::torus(), BraceRule::TwoRing);
  if (name == "l-shape") return built(test_shapes::lShape(), BraceRule::TwoRing);
  if (name == "rope") return rope(8, 0.1);
  if (name == "rod") return rope(1, 0.0);
  if (name == "chain") return test::chainNetwork(12);
  if (name == "pair") return test::pairNetwork();
  if (name == "cloth") return test::clothNetwork(4, 4);
  if (name == "cloth-fine") return test::clothNetwork(9, 7);
  if (name == "material") return material();
  if (name == "triangle") return built(small_meshes::singleTriangle(), BraceRule::None);
  if (name == "islands") return built(small_meshes::twoIslands(), BraceRule::TwoRing);
  if (name == "tetrahedron") return test::tetrahedronNetwork();
  if (name == "points") return points();
  throw std::runtime_error("no network is called " + name);
}

}  // namespace

SharedNetwork networkNamed(const std::string& name) {
  static std::map<std::string, SharedNetwork> cooked;
  SharedNetwork& network = cooked[name];
  if (!network) network = cook(name);
  return network;
}

}  // namespace limber::fuzz

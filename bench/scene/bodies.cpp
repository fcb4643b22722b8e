// SPDX-License-Identifier: Zlib
#include "scene/bodies.h"

#include "scene/scene.h"
#include "scene/spring_system.h"

#include <limber/network_builder.h>

#include <cmath>
#include <utility>

namespace limber::bench {
namespace {

std::shared_ptr<SpringNetwork> withPoints(NetworkKind kind, std::vector<Eigen::Vector3d> points) {
  auto network = std::make_shared<SpringNetwork>();
  network->kind = kind;
  network->massFractions.assign(points.size(), 1.0 / static_cast<double>(points.size()));
  network->restPoints = std::move(points);
  return network;
}

std::shared_ptr<SpringNetwork> line(int links, const Eigen::Vector3d& direction) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= links; ++i) points.push_back(direction * i / links);
  auto network = withPoints(NetworkKind::Rope, std::move(points));
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(links); ++i)
    network->springs.push_back({i, i + 1, SpringKind::Structural, 1.0});
  return network;
}

/// Adds springs between all points nearer than `maxLength`.
void connect(SpringNetwork& network, double maxLength) {
  const auto count = static_cast<std::uint32_t>(network.restPoints.size());
  for (std::uint32_t a = 0; a < count; ++a)
    for (std::uint32_t b = a + 1; b < count; ++b)
      if ((network.restPoints[a] - network.restPoints[b]).norm() < maxLength)
        network.springs.push_back({a, b, SpringKind::Structural, 1.0});
}

std::shared_ptr<SpringNetwork> cube() {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 8; ++i) points.emplace_back((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2 & 1) - 0.5);
  auto network = withPoints(NetworkKind::Solid, std::move(points));
  connect(*network, 2.0);
  return network;
}

}  // namespace

SharedNetwork pairNetwork() { return line(1, Eigen::Vector3d::UnitX()); }
SharedNetwork chainNetwork(int links) { return line(links, -Eigen::Vector3d::UnitY()); }
SharedNetwork barNetwork(int links) { return line(links, Eigen::Vector3d::UnitX()); }

SharedNetwork loadedChainNetwork(int links, double ratio) {
  auto network = line(links, -Eigen::Vector3d::UnitY());
  const double sum = links + ratio;
  for (double& share : network->massFractions) share = 1.0 / sum;
  network->massFractions.back() = ratio / sum;
  return network;
}

SharedNetwork cubeNetwork() { return cube(); }

SharedNetwork closedCubeNetwork() {
  auto network = cube();
  // two triangles per face, oriented outward
  network->surface = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return network;
}

SharedNetwork latticeNetwork(int nx, int ny, int nz, double spacing) {
  std::vector<Eigen::Vector3d> points;
  for (int x = 0; x < nx; ++x)
    for (int y = 0; y < ny; ++y)
      for (int z = 0; z < nz; ++z) points.push_back(spacing * Eigen::Vector3d(x, y, z));
  auto network = withPoints(NetworkKind::Solid, std::move(points));
  connect(*network, 1.8 * spacing);  // the diagonal of a cell is 1.73, the next neighbour 2
  return network;
}

SharedNetwork clothNetwork(int side) {
  ClothSettings settings;
  settings.columns = settings.rows = static_cast<std::uint32_t>(side - 1);
  settings.shearScale = settings.bendingScale = 1.0;
  return *buildCloth(settings);
}

BodySetup bodyOf(SharedNetwork network, double mass, double stiffness, double damping) {
  BodySetup body;
  body.network = std::move(network);
  body.settings.totalMass = mass;
  body.settings.extensionStiffness = body.settings.compressionStiffness = stiffness;
  body.settings.damping = damping;
  return body;
}

// --- a cube at rest --------------------------------------------------------------------------------

namespace {

bool isUpper(Eigen::Index point) { return (point & 2) != 0; }  // in the order of cubeNetwork()

}  // namespace

BodySetup restingCube(double stiffness) {
  BodySetup body = bodyOf(closedCubeNetwork(), 1.0, stiffness, 0.2 * std::sqrt(stiffness / 8));
  body.settings.pointRadius = kCubeRadius;
  body.settings.position = {0.1, 0.5 + kCubeRadius, 0.05};
  body.drag = 2.0;
  return body;
}

double topOf(const Eigen::Matrix3Xd& cube) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < 8; ++i)
    if (isUpper(i)) sum += cube(1, i);
  return sum / 4;
}

double restHeight(const BodySetup& cube, double load) {
  SpringSystem system = systemOf(cube, {0, -kGravity, 0});
  for (Eigen::Index i = 0; i < 8; ++i) {
    if (isUpper(i)) {
      system.load(1, i) -= load / 4;
    } else {
      system.free(1, i) = 0.0;
      system.start.positions(1, i) = kCubeRadius;
    }
  }
  return topOf(equilibrium(system));
}

}  // namespace limber::bench

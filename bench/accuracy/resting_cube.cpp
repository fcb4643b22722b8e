// SPDX-License-Identifier: Zlib
#include "accuracy/resting_cube.h"

#include "accuracy/networks.h"
#include "accuracy/scene.h"
#include "accuracy/scene_list.h"
#include "accuracy/spring_system.h"

#include <cmath>

namespace limber::bench {
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

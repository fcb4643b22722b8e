// SPDX-License-Identifier: Zlib
#include "puppet.h"

#include "sheets.h"

namespace shapes {
namespace {

using Eigen::Vector3d;

// All lengths are metres. Parts off the plane x = 0 exist twice, left and right.

Field puppetOutline() {
  return mirrorX(unite({ellipsoid({0.0, 0.825, 0.0}, {0.165, 0.170, 0.165}),               // head
                        limb({{{0.0, 0.58, 0.0}, 0.125}, {{0.0, 0.36, 0.0}, 0.150}}),      // body
                        limb({{{0.05, 0.585, 0.0}, 0.075}, {{0.31, 0.565, 0.0}, 0.080}}),  // arm
                        limb({{{0.07, 0.33, 0.0}, 0.095}, {{0.165, 0.09, 0.0}, 0.090}})},  // leg
                       0.06));
}

Field puppetHoles() {
  const auto round = [](double x, double y, double radius) {
    return ellipsoid({x, y, 0.0}, Vector3d::Constant(radius));
  };
  const Field mouth =
      limb({{{0.0, 0.755, 0.0}, 0.015}, {{0.045, 0.762, 0.0}, 0.015}, {{0.080, 0.785, 0.0}, 0.015}});
  const Field eye = round(0.060, 0.867, 0.024), button = round(0.0, 0.520, 0.026),
              lowerButton = round(0.0, 0.400, 0.026);
  return mirrorX(unite({mouth, eye, button, lowerButton}, 0.001));
}

}  // namespace

TriangleSoup makePuppet() {
  constexpr int kAcross = 38, kDown = 48;
  constexpr double kCell = 0.022, kSnap = 0.3 * kCell;
  const Field plane = halfSpace(Vector3d::Zero(), Vector3d::UnitZ());
  TriangleSoup soup;
  addSheet(soup, kAcross, kDown, [](double u, double v) {
    return Vector3d(kAcross * kCell * (u - 0.5), kDown * kCell * v - kCell, 0.0);
  });
  soup = clip(soup, plane, puppetOutline(), kSnap);
  return clip(soup, plane, outside(puppetHoles()), kSnap);
}

}  // namespace shapes

// SPDX-License-Identifier: Zlib
#include "shapes.h"

#include "sheets.h"
#include "surface_net.h"

#include <cmath>

namespace shapes {
namespace {

using Eigen::Vector3d;

// All lengths are metres.

constexpr double kCarCell = 0.11, kCarSnap = 0.3 * kCarCell;

/// Half of the gap between two sheets.
constexpr double kGap = 0.004;

constexpr double kFrontAxle = 1.20, kRearAxle = -1.22, kWheelRadius = 0.33;

Field carBody() {
  return unite({ellipsoid({0.0, 0.50, 0.0}, {0.66, 0.36, 1.80}),     // lower body
                ellipsoid({0.0, 0.60, 1.00}, {0.40, 0.34, 0.92}),    // nose
                ellipsoid({0.0, 0.84, -0.16}, {0.66, 0.62, 0.98}),   // cabin
                ellipsoid({0.0, 0.60, -0.83}, {0.56, 0.63, 1.12})},  // tail
               0.12);
}

Field bigger(const Field& body, double distance) {
  return [=](const Vector3d& p) { return body(p) - distance; };
}

/// What lies in all of the half spaces, with rounded corners.
Field windowFrame(const std::vector<Field>& sides) {
  Field frame = sides[0];
  for (std::size_t i = 1; i < sides.size(); ++i) frame = intersect(frame, sides[i], 0.08);
  return frame;
}

/// Above the plane y = height; slope: how much it rises along z.
Field above(double height, double slope = 0.0) {
  return halfSpace({0.0, height, 0.0}, Vector3d(0.0, -1.0, slope).normalized());
}

Field below(double height, double slope = 0.0) { return outside(above(height, slope)); }

/// In front of the plane through z at y = 0.9; lean: how much it moves back for each metre of height.
Field before(double z, double lean = 0.0) {
  return halfSpace({0.0, 0.9, z}, Vector3d(0.0, -lean, -1.0).normalized());
}

Field behind(double z, double lean = 0.0) { return outside(before(z, lean)); }

Field sideOf(double x) { return halfSpace({x, 0.0, 0.0}, {-1.0, 0.0, 0.0}); }

Field windows() {
  const Field screen = windowFrame({above(0.96), below(1.23), before(0.20), outside(sideOf(0.43))});
  const Field front = windowFrame({above(0.95), below(1.20), before(-0.27), behind(0.34, 0.6), sideOf(0.3)});
  const Field rear = windowFrame({above(0.95), below(1.19), before(-0.88, -0.5), behind(-0.40), sideOf(0.3)});
  const Field back = intersect(ellipsoid({0.0, 1.225, -1.0}, {0.34, 0.075, 1.0}), behind(-0.6), 0.02);
  return mirrorX(unite({screen, front, rear, back}, 0.001));
}

Field door() {
  return mirrorX(windowFrame({above(0.36), below(1.25), before(-0.34), behind(0.45, 0.5), sideOf(0.3)}));
}

Field roof() { return windowFrame({above(1.30), before(-0.66)}); }

Field bonnet() { return intersect(ellipsoid({0.0, 0.9, 1.13}, {0.34, 1.2, 0.60}), above(0.5), 0.05); }

Field engineLid() {
  return windowFrame({ellipsoid({0.0, 0.6, -1.6}, {0.36, 0.36, 1.0}), behind(-1.1), above(0.42)});
}

/// Where the wheels turn.
Field wheelArches() {
  const auto arch = [](double z) {
    return limb({{{0.45, kWheelRadius, z}, 0.39}, {{1.2, kWheelRadius, z}, 0.39}});
  };
  return mirrorX(unite({arch(kFrontAxle), arch(kRearAxle)}, 0.001));
}

/// The shell, cut along the edges of the panels, with the panels beside it.
void addPanels(TriangleSoup& soup) {
  const Field body = carBody();
  TriangleSoup shell = makeBody(body, {-0.8, 0.0, -2.1}, {0.8, 1.6, 2.1}, kCarCell);
  for (const Field& hole : {below(0.28), windows(), wheelArches()})
    shell = clip(shell, body, outside(hole), kCarSnap);
  for (const Field& panel : {door(), roof(), bonnet(), engineLid()}) {
    append(soup, clip(shell, body, bigger(panel, -kGap), kCarSnap));
    shell = clip(shell, body, outside(bigger(panel, kGap)), kCarSnap);
  }
  append(soup, shell);
}

/// An ellipsoid around a wheel, as far as it stands out of the body.
TriangleSoup makeFender(const Vector3d& centre, const Vector3d& radii) {
  TriangleSoup fender;
  addSheet(fender, 24, 12, ball(centre, radii));
  const Field surface = ellipsoid(centre, radii);
  const Field lower = below(0.26), inner = bigger(carBody(), -0.015);
  for (const Field& hole : {lower, inner, wheelArches()}) fender = clip(fender, surface, outside(hole), 0.02);
  return fender;
}

/// A closed cylinder with a cap on its outer side.
TriangleSoup makeWheel(double axle) {
  TriangleSoup wheel;
  std::vector<Joint> joints;
  for (const auto& [x, radius] : std::vector<std::pair<double, double>>{{0.56, 0.0},
                                                                        {0.57, 0.22},
                                                                        {0.58, 0.30},
                                                                        {0.61, kWheelRadius},
                                                                        {0.70, kWheelRadius},
                                                                        {0.73, 0.30},
                                                                        {0.725, 0.22},
                                                                        {0.74, 0.16},
                                                                        {0.755, 0.0}})
    joints.push_back({{x, kWheelRadius, axle}, radius});
  addSheet(wheel, 20, 8, [&](double u, double v) { return tube(joints, Vector3d::UnitZ())(u, v); });
  return wheel;
}

TriangleSoup makeLamp() {
  TriangleSoup lamp;
  addSheet(lamp, 12, 6, ball({0.60, 0.68, 1.60}, {0.10, 0.10, 0.07}));
  return lamp;
}

/// A strip across the car, bent around its end; it stands `ahead` of the middle axis.
Sheet bumper(double ahead, double height) {
  return [=](double u, double v) -> Vector3d {
    const double x = 0.74 * (2.0 * u - 1.0), along = (v - 0.5) * 0.10;
    const double bulge = 0.03 - 12.0 * along * along;
    const double z = std::abs(ahead) + bulge - 0.22 * x * x - 0.25 * x * x * x * x;
    return ahead > 0.0 ? Vector3d(x, height + along, z) : Vector3d(-x, height + along, -z);
  };
}

Sheet floor() {
  return [](double u, double v) -> Vector3d {
    const double z = 1.62 * (1.0 - 2.0 * v);
    return {0.50 * (2.0 * u - 1.0), 0.30, z};
  };
}

}  // namespace

TriangleSoup makeCar() {
  TriangleSoup soup, right;
  addPanels(soup);
  append(right, makeFender({0.60, 0.42, kFrontAxle + 0.02}, {0.22, 0.42, 0.56}));
  append(right, makeFender({0.60, 0.40, kRearAxle - 0.02}, {0.22, 0.42, 0.58}));
  append(right, makeLamp());
  append(right, makeWheel(kFrontAxle));
  append(right, makeWheel(kRearAxle));
  append(soup, right);
  append(soup, mirroredX(right));
  addSheet(soup, 6, 12, floor());
  addSheet(soup, 14, 3, bumper(1.96, 0.42));
  addSheet(soup, 14, 3, bumper(-1.98, 0.42));
  return soup;
}

}  // namespace shapes

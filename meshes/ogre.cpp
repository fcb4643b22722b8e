// SPDX-License-Identifier: Zlib
#include "shapes.h"

#include "sheets.h"
#include "surface_net.h"

#include <cmath>

namespace shapes {
namespace {

using Eigen::Vector3d;

// All lengths are metres. Parts off the plane x = 0 exist twice, left and right; the club is in the hand at
// +x.

void addBoth(TriangleSoup& soup, const TriangleSoup& part) {
  append(soup, part);
  append(soup, mirroredX(part));
}

TriangleSoup makeTube(int sides, int rows, const std::vector<Joint>& joints,
                      const Vector3d& side = Vector3d::UnitZ()) {
  TriangleSoup soup;
  addSheet(soup, sides, rows, tube(joints, side));
  return soup;
}

// --- flesh -------------------------------------------------------------------------------------------------

TriangleSoup makeTorso() {
  const Field body = unite({ellipsoid({0.0, 0.92, 0.05}, {0.335, 0.30, 0.31}),                 // belly
                            ellipsoid({0.0, 1.25, -0.01}, {0.34, 0.23, 0.23}),                 // chest
                            ellipsoid({0.13, 1.26, 0.13}, {0.16, 0.11, 0.12}),                 // breast
                            limb({{{0.0, 1.40, -0.05}, 0.15}, {{0.33, 1.38, -0.03}, 0.145}}),  // shoulder
                            ellipsoid({0.0, 0.70, 0.0}, {0.28, 0.17, 0.22})},                  // hips
                           0.09);
  return makeBody(mirrorX(body), {-0.55, 0.45, -0.35}, {0.55, 1.65, 0.45}, 0.058);
}

TriangleSoup makeOgreHead() {
  const Field solid = unite({ellipsoid({0.0, 1.635, 0.085}, {0.135, 0.135, 0.145}),                // skull
                             ellipsoid({0.0, 1.535, 0.145}, {0.158, 0.090, 0.125}),                // jaw
                             limb({{{0.0, 1.50, 0.02}, 0.125}, {{0.0, 1.40, -0.02}, 0.15}}),       // neck
                             limb({{{0.0, 1.672, 0.205}, 0.030}, {{0.11, 1.675, 0.165}, 0.030}}),  // brow
                             limb({{{0.0, 1.66, 0.215}, 0.020}, {{0.0, 1.598, 0.265}, 0.036}}),    // nose
                             ellipsoid({0.032, 1.592, 0.25}, {0.026, 0.022, 0.026})},              // nostril
                            0.03);
  const Field mouth = ellipsoid({0.0, 1.535, 0.28}, {0.105, 0.022, 0.07});
  return makeBody(mirrorX(intersect(solid, outside(mouth), 0.02)), {-0.2, 1.2, -0.2}, {0.2, 1.8, 0.35},
                  0.029);
}

/// A fist around the y axis at x = 0.74, z = 0.24.
TriangleSoup makeHand() {
  std::vector<Field> parts{ellipsoid({0.745, 0.625, 0.200}, {0.062, 0.085, 0.055}),
                           limb({{{0.70, 0.69, 0.20}, 0.034}, {{0.70, 0.715, 0.27}, 0.030}})};  // thumb
  for (int i = 0; i < 4; ++i) {
    const double y = 0.685 - 0.042 * i;
    parts.push_back(limb({{{0.795, y, 0.215}, 0.027},
                          {{0.800, y, 0.275}, 0.026},
                          {{0.750, y, 0.300}, 0.024},
                          {{0.715, y, 0.285}, 0.022}}));
  }
  return makeBody(unite(parts, 0.012), {0.6, 0.45, 0.1}, {0.9, 0.8, 0.4}, 0.0255);
}

TriangleSoup makeFoot() {
  std::vector<Field> parts{ellipsoid({0.225, 0.065, 0.04}, {0.095, 0.075, 0.15}),
                           ellipsoid({0.220, 0.10, -0.03}, {0.085, 0.10, 0.085})};
  for (int i = -1; i <= 1; ++i)
    parts.push_back(
        limb({{{0.23 + 0.058 * i, 0.045, 0.12}, 0.042}, {{0.24 + 0.072 * i, 0.038, 0.20}, 0.038}}));
  const Field floor = halfSpace({0.0, 0.0, 0.0}, {0.0, -1.0, 0.0});
  return makeBody(intersect(unite(parts, 0.02), floor, 0.01), {0.05, 0.0, -0.2}, {0.4, 0.3, 0.3}, 0.033);
}

void addLimbs(TriangleSoup& soup) {
  addBoth(soup, makeTube(16, 14,
                         {{{0.36, 1.42, -0.03}, 0.0},
                          {{0.40, 1.36, -0.03}, 0.125},
                          {{0.49, 1.23, -0.03}, 0.135},
                          {{0.56, 1.10, -0.01}, 0.110},
                          {{0.60, 1.01, 0.01}, 0.095},
                          {{0.62, 0.94, 0.02}, 0.0}}));
  addBoth(soup, makeTube(16, 14,
                         {{{0.60, 1.04, -0.01}, 0.0},
                          {{0.62, 0.98, 0.02}, 0.095},
                          {{0.67, 0.88, 0.07}, 0.110},
                          {{0.71, 0.79, 0.12}, 0.085},
                          {{0.735, 0.71, 0.165}, 0.062},
                          {{0.745, 0.67, 0.19}, 0.0}}));
  addBoth(soup, makeTube(18, 14,
                         {{{0.16, 0.76, 0.0}, 0.0},
                          {{0.17, 0.68, 0.0}, 0.165},
                          {{0.195, 0.56, 0.01}, 0.160},
                          {{0.21, 0.46, 0.02}, 0.125},
                          {{0.215, 0.38, 0.02}, 0.0}}));
  addBoth(soup, makeTube(16, 14,
                         {{{0.213, 0.49, 0.02}, 0.0},
                          {{0.215, 0.43, 0.02}, 0.110},
                          {{0.218, 0.33, -0.01}, 0.125},
                          {{0.22, 0.20, -0.02}, 0.090},
                          {{0.22, 0.12, -0.02}, 0.080},
                          {{0.22, 0.07, -0.02}, 0.0}}));
  addBoth(soup, makeHand());
  addBoth(soup, makeFoot());
}

// --- horn, teeth, eyes -------------------------------------------------------------------------------------

void addFeatures(TriangleSoup& soup) {
  TriangleSoup eye;
  addSheet(eye, 12, 8, ball({0.058, 1.637, 0.205}, Vector3d::Constant(0.030)));
  addBoth(soup, eye);
  addBoth(soup, makeTube(12, 8,
                         {{{0.115, 1.61, 0.07}, 0.040},  // ear
                          {{0.20, 1.645, 0.055}, 0.048},
                          {{0.27, 1.69, 0.03}, 0.028},
                          {{0.33, 1.74, 0.0}, 0.0}}));
  addBoth(soup, makeTube(10, 8,
                         {{{0.075, 1.73, 0.12}, 0.034},  // horn
                          {{0.115, 1.77, 0.14}, 0.028},
                          {{0.135, 1.82, 0.15}, 0.018},
                          {{0.130, 1.87, 0.145}, 0.0}}));
  addBoth(soup, makeTube(8, 6,
                         {{{0.075, 1.515, 0.245}, 0.0},  // tusk
                          {{0.078, 1.525, 0.257}, 0.020},
                          {{0.092, 1.57, 0.272}, 0.015},
                          {{0.090, 1.61, 0.272}, 0.0}}));
  addBoth(soup, makeTube(8, 4,
                         {{{0.028, 1.57, 0.255}, 0.0},  // tooth
                          {{0.028, 1.56, 0.256}, 0.014},
                          {{0.028, 1.525, 0.262}, 0.0}}));
  append(soup, makeTube(10, 10,
                        {{{0.0, 1.75, 0.04}, 0.022},  // hair
                         {{0.0, 1.80, 0.0}, 0.030},
                         {{0.0, 1.80, -0.08}, 0.036},
                         {{0.0, 1.70, -0.14}, 0.030},
                         {{0.0, 1.60, -0.15}, 0.0}},
                        Vector3d::UnitX()));
  for (int i = -1; i <= 1; ++i) {
    const double x = 0.243 + 0.074 * i;
    addBoth(soup, makeTube(8, 4,
                           {{{x, 0.046, 0.212}, 0.030},  // toenail
                            {{x, 0.045, 0.245}, 0.024},
                            {{x, 0.030, 0.275}, 0.0}},
                           Vector3d::UnitX()));
  }
}

// --- clothes and arms --------------------------------------------------------------------------------------

/// A band around the y axis, wider in x than in z.
Sheet belt() {
  return [](double u, double v) -> Vector3d {
    const double angle = 2.0 * kPi * u;
    return {0.330 * std::sin(angle), 0.71 + 0.085 * v, 0.035 + 0.305 * std::cos(angle)};
  };
}

/// The upper part of an ellipsoid, tilted outward over a shoulder.
Sheet shoulderPlate() {
  const Sheet dome = ball(Vector3d::Zero(), {0.205, 0.165, 0.210});
  return [dome](double u, double v) -> Vector3d {
    const Vector3d p = dome(u, 0.52 + 0.48 * v);
    return {0.415 + 0.82 * p.x() + 0.57 * p.y(), 1.375 - 0.57 * p.x() + 0.82 * p.y(), -0.03 + p.z()};
  };
}

/// It hangs from the belt in two folds.
Sheet apron() {
  return [](double u, double v) -> Vector3d {
    const double x = (u - 0.5) * (0.34 - 0.06 * (1.0 - v)), fold = std::cos(4.0 * kPi * u);
    return {x, 0.40 + 0.33 * v - 0.03 * std::cos(2.0 * kPi * u) * (1.0 - v),
            0.345 - 1.1 * x * x - 0.05 * (1.0 - v) + 0.015 * fold * (1.0 - v)};
  };
}

void addGear(TriangleSoup& soup) {
  TriangleSoup plate, buckle;
  addSheet(plate, 20, 7, shoulderPlate());
  addBoth(soup, plate);
  addBoth(soup, makeTube(16, 4, {{{0.645, 0.93, 0.045}, 0.122}, {{0.72, 0.76, 0.135}, 0.098}}));  // bracer
  addSheet(soup, 36, 2, belt());
  addSheet(buckle, 12, 6, ball({0.0, 0.752, 0.347}, {0.060, 0.055, 0.018}));
  append(soup, buckle);
  addSheet(soup, 12, 9, apron());
  append(soup, makeTube(10, 10,
                        {{{0.742, 0.42, 0.245}, 0.0},  // handle
                         {{0.742, 0.43, 0.245}, 0.028},
                         {{0.742, 0.62, 0.245}, 0.024},
                         {{0.742, 0.85, 0.245}, 0.028},
                         {{0.742, 0.95, 0.245}, 0.0}}));
  append(soup, makeTube(14, 14,
                        {{{0.742, 0.88, 0.245}, 0.0},  // club
                         {{0.742, 0.92, 0.245}, 0.040},
                         {{0.742, 1.08, 0.245}, 0.075},
                         {{0.742, 1.25, 0.245}, 0.105},
                         {{0.742, 1.36, 0.245}, 0.090},
                         {{0.742, 1.40, 0.245}, 0.0}}));
}

}  // namespace

TriangleSoup makeOgre() {
  TriangleSoup soup = makeTorso();
  append(soup, makeOgreHead());
  addLimbs(soup);
  addFeatures(soup);
  addGear(soup);
  return soup;
}

}  // namespace shapes

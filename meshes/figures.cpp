// SPDX-License-Identifier: Zlib
#include "shapes.h"

#include "sheets.h"
#include "surface_net.h"

namespace shapes {

// --- figure
// -------------------------------------------------------------------------------------------------

namespace {

/// Distance over which parts melt into each other, metres.
constexpr double kBlend = 0.05;

/// Parts off the plane x = 0 exist twice, left and right.
Field figureField() {
  return mirrorX(unite({limb({{{0.0, -0.14, 0.0}, 0.145}, {{0.0, 0.02, 0.0}, 0.145}}),        // body
                        limb({{{0.0, 0.235, 0.01}, 0.135}, {{0.0, 0.255, 0.01}, 0.135}}),     // head
                        limb({{{0.1, 0.06, 0.0}, 0.058}, {{0.4, 0.12, 0.0}, 0.058}}),         // arm
                        limb({{{0.075, -0.22, 0.0}, 0.065}, {{0.15, -0.435, 0.02}, 0.065}}),  // leg
                        limb({{{0.06, 0.33, 0.0}, 0.05}, {{0.125, 0.45, 0.0}, 0.05}})},       // ear
                       kBlend));
}

}  // namespace

TriangleSoup makeFigure() {
  constexpr double kCell = 0.06;
  const CellGrid grid{{-9 * kCell, -10 * kCell, -4 * kCell}, kCell, {18, 20, 8}};
  const Field field = figureField();
  QuadMesh mesh = buildSurfaceNet(field, grid);
  relaxOnSurface(mesh, field, 3);
  TriangleSoup soup = toSoup(mesh, 0.0);  // tests know the networks of exactly this figure
  for (auto& triangle : soup) {
    for (Corner& corner : triangle) corner.uv = {corner.position.x() + 0.5, corner.position.y() + 0.5};
  }
  return soup;
}

// --- animal
// -------------------------------------------------------------------------------------------------

namespace {

// All lengths are metres. Parts off the plane x = 0 exist twice, left and right.

Field animalTrunk() {
  return unite({ellipsoid({0.0, 0.405, -0.10}, {0.128, 0.140, 0.27}),             // barrel
                ellipsoid({0.0, 0.395, 0.12}, {0.100, 0.150, 0.13}),              // chest
                ellipsoid({0.0, 0.44, -0.29}, {0.112, 0.115, 0.12}),              // rump
                ellipsoid({0.0, 0.50, 0.08}, {0.055, 0.075, 0.12}),               // withers
                limb({{{0.0, 0.45, 0.16}, 0.095}, {{0.0, 0.58, 0.31}, 0.068}}),   // neck
                limb({{{0.0, 0.37, 0.21}, 0.035}, {{0.0, 0.49, 0.30}, 0.030}})},  // dewlap
               0.06);
}

Field animalHead() {
  return unite({limb({{{0.0, 0.625, 0.345}, 0.062}, {{0.0, 0.545, 0.46}, 0.044}}),
                ellipsoid({0.0, 0.530, 0.478}, {0.051, 0.042, 0.044}),                   // muzzle
                ellipsoid({0.0, 0.575, 0.375}, {0.048, 0.045, 0.07}, {35.0, 0.0, 0.0}),  // jaw
                ellipsoid({0.047, 0.632, 0.392}, {0.017, 0.020, 0.022})},                // eye
               0.02);
}

Field horn() {
  return limb({{{0.035, 0.670, 0.335}, 0.022},
               {{0.085, 0.690, 0.335}, 0.021},
               {{0.118, 0.725, 0.345}, 0.018},
               {{0.122, 0.783, 0.368}, 0.011}});
}

Field animalEar() { return ellipsoid({0.100, 0.622, 0.325}, {0.062, 0.030, 0.019}, {0.0, 12.0, -14.0}); }

Field frontLeg() {
  return unite({limb({{{0.066, 0.36, 0.13}, 0.060}, {{0.068, 0.20, 0.145}, 0.030}}),
                limb({{{0.068, 0.20, 0.145}, 0.032}, {{0.068, 0.05, 0.135}, 0.023}}),
                limb({{{0.068, 0.04, 0.138}, 0.026}, {{0.068, 0.0, 0.148}, 0.035}})},  // hoof
               0.015);
}

Field hindLeg() {
  return unite({ellipsoid({0.068, 0.37, -0.29}, {0.056, 0.125, 0.085}, {-12.0, 0.0, 0.0}),  // thigh
                limb({{{0.074, 0.30, -0.275}, 0.052}, {{0.074, 0.195, -0.335}, 0.030}}),
                limb({{{0.074, 0.195, -0.335}, 0.030}, {{0.074, 0.05, -0.318}, 0.023}}),
                limb({{{0.074, 0.04, -0.314}, 0.026}, {{0.074, 0.0, -0.304}, 0.035}})},  // hoof
               0.02);
}

Field udder() {
  return unite({ellipsoid({0.0, 0.285, -0.20}, {0.065, 0.055, 0.075}),
                limb({{{0.028, 0.25, -0.165}, 0.022}, {{0.032, 0.225, -0.165}, 0.018}}),
                limb({{{0.028, 0.25, -0.230}, 0.022}, {{0.032, 0.225, -0.230}, 0.018}})},
               0.012);
}

/// It hangs along a line of the grid, so that it stays in one piece although it is thinner than a cell.
Field animalTail(double cell) {
  const double z = -21.0 * cell;
  return unite({limb({{{0.0, 0.520, -0.36}, 0.030}, {{0.0, 0.505, z}, 0.023}, {{0.0, 0.44, z}, 0.015}}),
                limb({{{0.0, 0.44, z}, 0.015}, {{0.0, 0.27, z}, 0.011}}),
                ellipsoid({0.0, 0.21, z}, {0.027, 0.072, 0.027})},  // tuft
               0.015);
}

Field animalField(double cell) {
  const Field body = unite({animalTrunk(), frontLeg(), hindLeg(), udder()}, 0.03);
  const Field front = unite({animalHead(), animalEar(), horn()}, 0.014);
  return mirrorX(intersect(unite({body, front, animalTail(cell)}, 0.02),
                           halfSpace({0.0, 0.0, 0.0}, {0.0, -1.0, 0.0}), 0.005));
}

}  // namespace

TriangleSoup makeAnimal() {
  constexpr double kCell = 0.0205;
  return makeBody(animalField(kCell), {-0.2, 0.0, -0.5}, {0.2, 0.8, 0.55}, kCell);
}

// --- puppet
// -------------------------------------------------------------------------------------------------

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

// SPDX-License-Identifier: Zlib
#include "figure.h"

#include "surface_net.h"

namespace shapes {
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

}  // namespace shapes

// SPDX-License-Identifier: Zlib
#include "shapes.h"

#include "sheets.h"
#include "surface_net.h"

#include <cmath>

namespace shapes {
namespace {

using Eigen::Vector3d;

// All lengths are decimetres. Parts off the plane x = 0 exist twice, left and right.

constexpr double kBunnyCell = 0.030;

Field bunnyTrunk() {
  return unite({ellipsoid({0.0, 0.47, -0.30}, {0.37, 0.44, 0.42}),              // rump
                ellipsoid({0.0, 0.47, 0.08}, {0.29, 0.36, 0.36}),               // ribs
                ellipsoid({0.0, 0.40, 0.29}, {0.235, 0.31, 0.22}),              // chest
                limb({{{0.0, 0.58, 0.22}, 0.21}, {{0.0, 0.88, 0.36}, 0.175}}),  // neck
                ellipsoid({0.0, 0.24, -0.74}, {0.12, 0.13, 0.12})},             // tail
               0.08);
}

Field bunnyLegs() {
  return unite({ellipsoid({0.285, 0.31, -0.22}, {0.155, 0.275, 0.285}, {-12.0, 0.0, 8.0}),  // thigh
                limb({{{0.30, 0.075, -0.26}, 0.085}, {{0.315, 0.06, 0.14}, 0.075}}),        // hind foot
                limb({{{0.13, 0.32, 0.33}, 0.105},
                      {{0.135, 0.09, 0.41}, 0.075},
                      {{0.135, 0.05, 0.52}, 0.065}})},  // foreleg
               0.04);
}

Field bunnyHead() {
  return unite({ellipsoid({0.0, 0.985, 0.46}, {0.185, 0.185, 0.235}, {22.0, 0.0, 0.0}),  // skull
                ellipsoid({0.085, 0.90, 0.53}, {0.115, 0.110, 0.125}),                   // cheek
                ellipsoid({0.0, 0.905, 0.65}, {0.095, 0.085, 0.105}),                    // snout
                ellipsoid({0.158, 1.01, 0.545}, {0.026, 0.040, 0.040})},                 // eye
               0.05);
}

/// A long leaf with a groove in front, laid back.
Field bunnyEar() {
  const Vector3d tilt(-28.0, 25.0, -13.0);
  const Field leaf = ellipsoid({0.150, 1.350, 0.240}, {0.100, 0.330, 0.062}, tilt);
  const Field groove = ellipsoid({0.168, 1.355, 0.312}, {0.058, 0.250, 0.055}, tilt);
  return intersect(leaf, outside(groove), 0.03);
}

/// Locks of fur, about 5 cells wide.
double fur(const Vector3d& p) {
  constexpr double kHeight = 0.006;
  return kHeight * (std::sin(31.0 * p.x() + 3.0 * std::sin(9.0 * p.y())) *
                        std::sin(27.0 * p.y() + 2.0 * std::sin(11.0 * p.z())) +
                    std::sin(29.0 * p.z() + 3.0 * std::sin(13.0 * p.x())));
}

Field bunnyField() {
  const Field smooth = mirrorX(unite({bunnyTrunk(), bunnyLegs(), bunnyHead(), bunnyEar()}, 0.05));
  const Field furry = [=](const Vector3d& p) { return smooth(p) + fur(p); };
  return intersect(furry, halfSpace({0.0, 0.0, 0.0}, {0.0, -1.0, 0.0}), 0.02);
}

/// A number in -1..1 that looks random (T. Wang's integer hash).
double noise(std::uint32_t seed) {
  seed = (seed ^ 61u) ^ (seed >> 16u);
  seed *= 9u;
  seed ^= seed >> 4u;
  seed *= 0x27d4eb2du;
  seed ^= seed >> 15u;
  return static_cast<double>(seed) / 2147483647.5 - 1.0;
}

Vector3d noiseVector(std::size_t index) {
  const auto seed = static_cast<std::uint32_t>(3 * index);
  return {noise(seed), noise(seed + 1), noise(seed + 2)};
}

/// Points wander along the surface, which makes the triangles irregular, and a little off it.
void addScannerNoise(QuadMesh& mesh, const Field& field) {
  constexpr double kAlong = 0.3 * kBunnyCell, kOff = 0.02 * kBunnyCell;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d wandered = mesh.vertices[i] + kAlong * noiseVector(i);
    mesh.vertices[i] =
        towardsSurface(field, towardsSurface(field, wandered)) + kOff * noiseVector(i + mesh.vertices.size());
  }
}

Field blindSpots() {
  return unite({ellipsoid({-0.02, 0.0, -0.33}, {0.19, 0.06, 0.21}),    // base
                ellipsoid({0.03, 0.11, 0.06}, {0.14, 0.08, 0.11}),     // base
                ellipsoid({0.01, 0.72, 0.46}, {0.10, 0.09, 0.12}),     // chin
                ellipsoid({0.0, 1.13, 0.30}, {0.06, 0.10, 0.10}),      // between the ears
                ellipsoid({0.215, 0.16, 0.12}, {0.05, 0.10, 0.10}),    // hind leg
                ellipsoid({-0.220, 0.16, 0.10}, {0.05, 0.08, 0.12})},  // hind leg
               0.01);
}

/// Without the triangles whose middle lies in the region: the edge stays ragged.
TriangleSoup without(const Field& region, const TriangleSoup& soup) {
  TriangleSoup result;
  for (const auto& t : soup) {
    if (region((t[0].position + t[1].position + t[2].position) / 3.0) >= 0.0) result.push_back(t);
  }
  return result;
}

}  // namespace

TriangleSoup makeBunny() {
  const Field field = bunnyField();
  QuadMesh mesh = buildSurfaceNet(field, gridAround({-0.6, 0.0, -1.0}, {0.6, 1.75, 0.85}, kBunnyCell));
  relaxOnSurface(mesh, field, 3);
  addScannerNoise(mesh, field);
  return without(blindSpots(), toSoup(mesh));
}

}  // namespace shapes

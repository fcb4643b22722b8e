// SPDX-License-Identifier: Zlib
#include "shapes.h"

#include "sheets.h"
#include "surface_net.h"

namespace shapes {
namespace {

using Eigen::Vector3d;

// All lengths are metres. Parts off the plane x = 0 exist twice, left and right.

const Vector3d kEye(0.110, 0.075, 0.222);
constexpr double kEyeRadius = 0.072;

Field skull() {
  return unite({ellipsoid({0.0, 0.11, -0.03}, {0.270, 0.235, 0.275}),                 // brain
                ellipsoid({0.0, 0.02, 0.08}, {0.245, 0.150, 0.165}),                  // cheeks
                ellipsoid({0.0, -0.135, 0.215}, {0.175, 0.120, 0.135}),               // muzzle
                ellipsoid({0.0, -0.220, 0.16}, {0.125, 0.075, 0.115}),                // chin
                limb({{{0.0, -0.10, -0.08}, 0.145}, {{0.0, -0.45, -0.13}, 0.150}})},  // neck
               0.07);
}

Field face() {
  return unite({limb({{{0.0, 0.165, 0.235}, 0.030},
                      {{0.11, 0.185, 0.225}, 0.040},
                      {{0.20, 0.135, 0.150}, 0.040}}),                              // brow
                limb({{{0.0, 0.12, 0.240}, 0.030}, {{0.0, -0.03, 0.330}, 0.040}}),  // nose
                ellipsoid({0.040, -0.045, 0.325}, {0.038, 0.030, 0.032}),           // nostril
                limb({{{0.0, -0.118, 0.345}, 0.024},
                      {{0.075, -0.125, 0.322}, 0.024},
                      {{0.140, -0.150, 0.255}, 0.024}}),  // upper lip
                limb({{{0.0, -0.225, 0.295}, 0.026},
                      {{0.065, -0.218, 0.282}, 0.026},
                      {{0.130, -0.180, 0.250}, 0.024}})},  // lower lip
               0.03);
}

/// A dish, open to the front and the side.
Field headEar() {
  const Field shell = ellipsoid({0.365, 0.085, -0.035}, {0.135, 0.150, 0.062}, {0.0, 25.0, -12.0});
  const Field hollow = ellipsoid({0.385, 0.088, 0.040}, {0.085, 0.100, 0.058}, {0.0, 25.0, -12.0});
  return intersect(shell, outside(hollow), 0.03);
}

/// The lids lie closely around the eyeballs.
Field headField() {
  const Field lid = ellipsoid(kEye, Vector3d::Constant(kEyeRadius + 0.016));
  return mirrorX(unite({skull(), face(), headEar(), lid}, 0.03));
}

/// A column along z, which cuts the skin at the front only.
Field mouthHole() {
  return intersect(ellipsoid({0.0, -0.172, 0.30}, {0.100, 0.030, 0.3}),
                   halfSpace({0.0, 0.0, 0.15}, {0.0, 0.0, -1.0}), 0.01);
}

Field eyeHole() {
  const Vector3d front = kEye + Vector3d(0.006, 0.0, kEyeRadius);
  return mirrorX(ellipsoid(front, {0.056, 0.046, kEyeRadius}, {0.0, 0.0, 8.0}));
}

/// Its poles are at the front and the back; the pupil is a dent at the front.
Sheet eyeBall() {
  const Sheet upright = ball(Vector3d::Zero(), Vector3d::Constant(kEyeRadius));
  return [upright](double u, double v) -> Vector3d {
    const Vector3d p = upright(u, v);
    return kEye + Vector3d(p.z(), p.x(), v < 1.0 ? p.y() : 0.7 * kEyeRadius);
  };
}

}  // namespace

TriangleSoup makeHead() {
  constexpr double kCell = 0.041, kSnap = 0.3 * kCell;
  const Field field = headField();
  TriangleSoup soup = makeBody(field, {-0.55, -0.5, -0.35}, {0.55, 0.45, 0.45}, kCell);
  const Field neck = halfSpace({0.0, -0.40, 0.0}, {0.0, 1.0, 0.0});
  for (const Field& hole : {neck, mouthHole(), eyeHole()}) soup = clip(soup, field, outside(hole), kSnap);
  TriangleSoup eye;
  addSheet(eye, 16, 9, eyeBall());
  append(soup, eye);
  append(soup, mirroredX(eye));
  return soup;
}

}  // namespace shapes

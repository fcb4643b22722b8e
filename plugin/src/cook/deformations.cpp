// SPDX-License-Identifier: Zlib
#include "cook/deformations.h"

#include "core/random.h"
#include "mesh/surface.h"

#include <Eigen/Geometry>

namespace limber {
namespace {

// Lengths as shares of the size.
constexpr double kSquashed = 0.1, kNoise = 0.5, kPushedBeyond = 0.2, kSlab = 0.3, kUnevenness = 1e-4;

using Direction = Eigen::Vector3d;

/// How far the points reach along a direction (m).
struct Reach {
  double low, high;
};

Reach reachAlong(const Points& x, const Direction& d) {
  const Eigen::RowVectorXd along = d.transpose() * x;
  return {along.minCoeff(), along.maxCoeff()};
}

void squash(Points& x, const Direction& d, double share) {
  const Eigen::Vector3d centre = x.rowwise().mean();
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    x.col(i) -= (1.0 - share) * d.dot(Eigen::Vector3d(x.col(i)) - centre) * d;
}

/// Turns by the angle  2 atan(u), u from 0 at one end to 1 at the other:  from nothing to a quarter turn,
/// nearly evenly, and without a sine, which differs in its last bits from one C library to the next.
void twist(Points& x, const Direction& axis) {
  const Eigen::Vector3d centre = x.rowwise().mean();
  const Reach reach = reachAlong(x, axis);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double u = reach.high > reach.low ? (axis.dot(x.col(i)) - reach.low) / (reach.high - reach.low) : 0;
    const double sine = 2.0 * u / (1.0 + u * u), cosine = (1.0 - u * u) / (1.0 + u * u);
    const Eigen::Vector3d r = Eigen::Vector3d(x.col(i)) - centre;
    const Eigen::Vector3d along = axis.dot(r) * axis, across = r - along;
    x.col(i) = centre + along + cosine * across + sine * axis.cross(across);
  }
}

void moveAll(Points& x, double distance, Random& random) {
  for (Eigen::Index i = 0; i < x.cols(); ++i) x.col(i) += distance * random.inBall();
}

/// The direction is turned to the side that the body lies on, seen from the point.
void push(Points& x, Eigen::Index point, Direction d, double size) {
  if (d.dot(Eigen::Vector3d(x.rowwise().mean()) - x.col(point)) < 0.0) d = -d;
  x.col(point) += (reachAlong(x, d).high + kPushedBeyond * size - d.dot(x.col(point))) * d;
}

void mirrorSlab(Points& x, const Direction& d) {
  const Reach reach = reachAlong(x, d);
  const double cut = reach.high - kSlab * (reach.high - reach.low);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double beyond = d.dot(x.col(i)) - cut;
    if (beyond > 0.0) x.col(i) -= 2.0 * beyond * d;
  }
}

void invert(Points& x) {
  const Eigen::Vector3d centre = x.rowwise().mean();
  for (Eigen::Index i = 0; i < x.cols(); ++i) x.col(i) = 2.0 * centre - x.col(i);
}

Random randomOf(Deformation kind, std::uint64_t seed, std::uint64_t run) {
  Random mixed(seed);
  Random perKind(mixed.next() ^ (static_cast<std::uint64_t>(kind) + 1));
  return Random(perKind.next() ^ run);
}

}  // namespace

Points deform(const Points& rest, Deformation kind, std::uint64_t seed, std::uint64_t run) {
  Random random = randomOf(kind, seed, run);
  const double size = extent(rest);
  const Direction d = random.direction();
  Points x = rest;
  switch (kind) {
    case Deformation::Squash:
      squash(x, d, kSquashed);
      break;
    case Deformation::Twist:
      twist(x, d);
      break;
    case Deformation::Noise:
      moveAll(x, kNoise * size, random);
      break;
    case Deformation::Push:
      push(x, random.below(static_cast<std::size_t>(x.cols())), d, size);
      break;
    case Deformation::Mirror:
      mirrorSlab(x, d);
      break;
    case Deformation::Flatten:
      squash(x, d, 0.0);
      break;
    case Deformation::Inversion:
      invert(x);
      break;
  }
  moveAll(x, kUnevenness * size, random);
  return x;
}

}  // namespace limber

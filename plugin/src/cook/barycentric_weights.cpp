// SPDX-License-Identifier: Zlib
#include "cook/skin_weights.h"
#include "cook/triangle_bvh.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr std::uint32_t kNone = 0xffffffffu;

Vector4d barycentric(const std::vector<Vector3d>& points, const Tetrahedron& t, const Vector3d& place) {
  Eigen::Matrix3d edges;
  for (int i = 0; i < 3; ++i) edges.col(i) = points[t[std::size_t(i) + 1]] - points[t[0]];
  const Vector3d rest = edges.partialPivLu().solve(place - points[t[0]]);
  return {1.0 - rest.sum(), rest[0], rest[1], rest[2]};
}

void addPlace(SkinWeights& skin, const std::vector<Vector3d>& points, const Tetrahedron& t,
              const Vector3d& place) {
  const Vector4d weights = barycentric(points, t, place);
  skin.points.insert(skin.points.end(), t.begin(), t.end());
  skin.weights.insert(skin.weights.end(), weights.data(), weights.data() + 4);
  skin.firstWeight.push_back(static_cast<std::uint32_t>(skin.points.size()));
}

/// The side of a tetrahedron across from corner `corner`.
struct Side {
  Triangle points;   ///< ascending
  Triangle outward;  ///< counter-clockwise seen from outside the tetrahedron
  std::uint32_t tetrahedron, corner;
};

/// Of a tetrahedron of positive volume.
Triangle outwardSide(const Tetrahedron& t, std::uint32_t corner) {
  switch (corner) {
    case 0:
      return {t[1], t[2], t[3]};
    case 1:
      return {t[0], t[3], t[2]};
    case 2:
      return {t[0], t[1], t[3]};
    default:
      return {t[0], t[2], t[1]};
  }
}

std::vector<Side> sortedSides(const std::vector<Tetrahedron>& tetrahedra) {
  std::vector<Side> sides;
  for (std::uint32_t i = 0; i < tetrahedra.size(); ++i) {
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      const Tetrahedron& t = tetrahedra[i];
      const Triangle outward = outwardSide(t, corner);
      Triangle points = outward;
      std::sort(points.begin(), points.end());
      sides.push_back({points, outward, i, corner});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) {
    return s.points != t.points ? s.points < t.points : s.tetrahedron < t.tetrahedron;
  });
  return sides;
}

/// Which tetrahedra meet at which sides, and the sides that only one has.
struct Neighbourhood {
  std::vector<std::array<std::uint32_t, 4>> across;  ///< #tetrahedra, beyond the side across from a corner
  std::vector<Triangle> border;
  std::vector<std::uint32_t> borderOf;  ///< #border, its tetrahedron
};

Neighbourhood neighbourhood(const std::vector<Tetrahedron>& tetrahedra) {
  const std::vector<Side> sides = sortedSides(tetrahedra);
  Neighbourhood result;
  result.across.assign(tetrahedra.size(), {kNone, kNone, kNone, kNone});
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Side& side = sides[i];
    if (i + 1 < sides.size() && sides[i + 1].points == side.points) {
      const Side& other = sides[++i];
      result.across[side.tetrahedron][side.corner] = other.tetrahedron;
      result.across[other.tetrahedron][other.corner] = side.tetrahedron;
    } else {
      result.border.push_back(side.outward);
      result.borderOf.push_back(side.tetrahedron);
    }
  }
  return result;
}

/// From tetrahedron to tetrahedron through the side that the place lies farthest beyond, until none is, or
/// the border is reached, or as many steps are taken as there are tetrahedra.
std::uint32_t walkTo(const Vector3d& place, std::uint32_t start, const std::vector<Vector3d>& points,
                     const std::vector<Tetrahedron>& tetrahedra, const Neighbourhood& neighbours) {
  std::uint32_t here = start;
  for (std::size_t step = 0; step < tetrahedra.size(); ++step) {
    Eigen::Index corner = 0;
    const double least = barycentric(points, tetrahedra[here], place).minCoeff(&corner);
    const std::uint32_t next = neighbours.across[here][static_cast<std::size_t>(corner)];
    if (least >= 0.0 || next == kNone) return here;
    here = next;
  }
  return here;
}

/// The nearest triangle that faces as the place does: that of a part that only nearly touches faces the other
/// way.
std::uint32_t nearestOutside(const TriangleBvh& bvh, const SkinProblem& problem, std::size_t place) {
  const SurfaceHit hit = bvh.nearestFacing(problem.places[place], problem.normals[place]);
  return hit ? hit.triangle : bvh.nearest(problem.places[place]).triangle;
}

Vector3d unitNormal(const std::vector<Vector3d>& points, const Triangle& t) {
  return (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).normalized();
}

/// Height over the plane of the triangle against the distance from its middle: how steep a fourth corner is.
double steepness(const std::vector<Vector3d>& points, const Triangle& t, std::uint32_t point) {
  const Vector3d away = points[point] - (points[t[0]] + points[t[1]] + points[t[2]]) / 3.0;
  const double distance = away.norm();
  return distance > 0.0 ? std::abs(away.dot(unitNormal(points, t))) / distance : 0.0;
}

/// Steep enough for a fourth corner; else the steepest of all points is taken.
constexpr double kSteep = 0.3;

/// A point across the body from the triangle, with which it makes a tetrahedron.
std::uint32_t fourthCorner(const std::vector<Vector3d>& points, const std::vector<Triangle>& surface,
                           const TriangleBvh& bvh, const Triangle& t) {
  const Vector3d middle = (points[t[0]] + points[t[1]] + points[t[2]]) / 3.0;
  const double size = (points[t[1]] - points[t[0]]).norm();
  const auto hit = bvh.firstHit(middle, -unitNormal(points, t), 1e-3 * size, HUGE_VAL);
  std::uint32_t best = kNone;
  double steepest = kSteep;
  if (hit) {
    for (const std::uint32_t point : surface[hit.triangle]) {
      if (steepness(points, t, point) <= steepest) continue;
      steepest = steepness(points, t, point);
      best = point;
    }
  }
  if (best != kNone) return best;
  steepest = 0.0;
  for (std::uint32_t point = 0; point < points.size(); ++point) {
    if (steepness(points, t, point) <= steepest) continue;
    steepest = steepness(points, t, point);
    best = point;
  }
  return best;
}

}  // namespace

SkinWeights tetrahedronWeights(const SkinProblem& problem, const std::vector<Tetrahedron>& tetrahedra) {
  const Neighbourhood neighbours = neighbourhood(tetrahedra);
  const TriangleBvh border(problem.points, neighbours.border);
  SkinWeights result;
  for (std::size_t p = 0; p < problem.places.size(); ++p) {
    const Vector3d& place = problem.places[p];
    const std::uint32_t start = neighbours.borderOf[nearestOutside(border, problem, p)];
    const std::uint32_t found = walkTo(place, start, problem.points, tetrahedra, neighbours);
    addPlace(result, problem.points, tetrahedra[found], place);
  }
  return result;
}

SkinWeights triangleWeights(const SkinProblem& problem, const std::vector<Triangle>& surface) {
  const TriangleBvh bvh(problem.points, surface);
  std::vector<std::uint32_t> fourth(surface.size(), kNone);
  SkinWeights result;
  for (std::size_t p = 0; p < problem.places.size(); ++p) {
    const std::uint32_t i = nearestOutside(bvh, problem, p);
    const Triangle& t = surface[i];
    if (fourth[i] == kNone) fourth[i] = fourthCorner(problem.points, surface, bvh, t);
    addPlace(result, problem.points, {t[0], t[1], t[2], fourth[i]}, problem.places[p]);
  }
  return result;
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "cook/skin_weights.h"
#include "cook/tetrahedron_faces.h"
#include "mesh/triangle_bvh.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr std::uint32_t kNoTriangle = 0xffffffffu;

Vector4d barycentric(const std::vector<Vector3d>& points, const Tetrahedron& t, const Vector3d& place) {
  const Vector3d &origin = points[t[0]], x = place - origin;
  const Vector3d b = points[t[1]] - origin, c = points[t[2]] - origin, d = points[t[3]] - origin;
  const Vector3d area = c.cross(d);
  const double volume = b.dot(area);
  const Vector3d rest = Vector3d(x.dot(area), b.dot(x.cross(d)), b.dot(c.cross(x))) / volume;
  return {1.0 - rest.sum(), rest[0], rest[1], rest[2]};
}

void addPlace(SkinWeights& skin, const std::vector<Vector3d>& points, const Tetrahedron& t,
              const Vector3d& place) {
  const Vector4d weights = barycentric(points, t, place);
  skin.points.insert(skin.points.end(), t.begin(), t.end());
  skin.weights.insert(skin.weights.end(), weights.data(), weights.data() + 4);
  skin.firstWeight.push_back(static_cast<std::uint32_t>(skin.points.size()));
}

/// The faces that only one tetrahedron has, and whose they are.
struct Border {
  std::vector<Triangle> faces;
  std::vector<std::uint32_t> owner;  ///< #faces
};

Border borderOf(const std::vector<Tetrahedron>& tetrahedra, const FaceNeighbours& neighbours) {
  Border border;
  border.faces = surfaceOf(tetrahedra, neighbours);
  for (std::uint32_t t = 0; t < tetrahedra.size(); ++t)
    for (const std::uint32_t neighbour : neighbours[t])
      if (neighbour == kOutside) border.owner.push_back(t);
  return border;
}

/// From tetrahedron to tetrahedron through the side that the place lies farthest beyond, until none is, or
/// the border is reached, or as many steps are taken as there are tetrahedra.
std::uint32_t walkTo(const Vector3d& place, std::uint32_t start, const std::vector<Vector3d>& points,
                     const std::vector<Tetrahedron>& tetrahedra, const FaceNeighbours& neighbours) {
  std::uint32_t here = start;
  for (std::size_t step = 0; step < tetrahedra.size(); ++step) {
    Eigen::Index corner = 0;
    const double least = barycentric(points, tetrahedra[here], place).minCoeff(&corner);
    const std::uint32_t next = neighbours[here][static_cast<std::size_t>(corner)];
    if (least >= 0.0 || next == kOutside) return here;
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
  std::uint32_t best = kNoTriangle;
  double steepest = kSteep;
  if (hit) {
    for (const std::uint32_t point : surface[hit.triangle]) {
      if (steepness(points, t, point) <= steepest) continue;
      steepest = steepness(points, t, point);
      best = point;
    }
  }
  if (best != kNoTriangle) return best;
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
  const FaceNeighbours neighbours = findFaceNeighbours(tetrahedra);
  const Border border = borderOf(tetrahedra, neighbours);
  const TriangleBvh bvh(problem.points, border.faces);
  SkinWeights result;
  for (std::size_t p = 0; p < problem.places.size(); ++p) {
    const Vector3d& place = problem.places[p];
    const std::uint32_t start = border.owner[nearestOutside(bvh, problem, p)];
    const std::uint32_t found = walkTo(place, start, problem.points, tetrahedra, neighbours);
    addPlace(result, problem.points, tetrahedra[found], place);
  }
  return result;
}

SkinWeights triangleWeights(const SkinProblem& problem, const std::vector<Triangle>& surface) {
  const TriangleBvh bvh(problem.points, surface);
  std::vector<std::uint32_t> fourth(surface.size(), kNoTriangle);
  SkinWeights result;
  for (std::size_t p = 0; p < problem.places.size(); ++p) {
    const std::uint32_t i = nearestOutside(bvh, problem, p);
    const Triangle& t = surface[i];
    if (fourth[i] == kNoTriangle) fourth[i] = fourthCorner(problem.points, surface, bvh, t);
    addPlace(result, problem.points, {t[0], t[1], t[2], fourth[i]}, problem.places[p]);
  }
  return result;
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "sheets.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace shapes {
namespace {

using Eigen::Vector3d;

/// Corners nearer to each other than this are the same, metres.
constexpr double kSame = 1e-7;

/// Half the distance in v over which the direction of a line is measured.
constexpr double kDirectionStep = 1e-4;

bool hasArea(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return (a - b).norm() > kSame && (b - c).norm() > kSame && (c - a).norm() > kSame;
}

void addTriangle(TriangleSoup& soup, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  if (hasArea(a, b, c)) soup.push_back({Corner{a, {0.0, 0.0}}, Corner{b, {0.0, 0.0}}, Corner{c, {0.0, 0.0}}});
}

/// The cubic of Catmull and Rom between b and c, at t in 0..1.
template <class Value>
Value catmullRom(const Value& a, const Value& b, const Value& c, const Value& d, double t) {
  return b + 0.5 * t * ((c - a) + t * ((2.0 * a - 5.0 * b + 4.0 * c - d) + t * (3.0 * (b - c) + d - a)));
}

/// A corner of a triangle and its signed distance from the edge of a region.
struct ClipCorner {
  Vector3d position;
  double distance;
};

/// How the point has to move along the surface to reach the edge of the region, to first order.
Vector3d stepToEdge(const Vector3d& p, const Field& surface, const Field& region) {
  const Vector3d normal = gradient(surface, p).normalized(), slope = gradient(region, p);
  const Vector3d along = slope - slope.dot(normal) * normal;
  return -region(p) / along.squaredNorm() * along;
}

ClipCorner snapped(const Vector3d& p, const Field& surface, const Field& region, double snap) {
  const Vector3d step = stepToEdge(p, surface, region);
  if (!(step.norm() < snap)) return {p, region(p)};
  const Vector3d nearer = towardsSurface(surface, p + step);
  return {nearer + stepToEdge(nearer, surface, region), 0.0};
}

/// The same point for both triangles at the edge a, b, whichever comes first.
Vector3d cutPoint(const ClipCorner& a, const ClipCorner& b, const Field& region) {
  const ClipCorner &in = a.distance < 0.0 ? a : b, &out = a.distance < 0.0 ? b : a;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2.0;
    (region(in.position + middle * (out.position - in.position)) < 0.0 ? low : high) = middle;
  }
  return in.position + low * (out.position - in.position);
}

/// The corners of what is left of a triangle.
std::vector<Vector3d> clipTriangle(const std::array<ClipCorner, 3>& corners, const Field& region) {
  std::vector<Vector3d> polygon;
  for (std::size_t i = 0; i < 3; ++i) {
    const ClipCorner &a = corners[i], &b = corners[(i + 1) % 3];
    if (a.distance <= 0.0) polygon.push_back(a.position);
    if (a.distance * b.distance < 0.0) polygon.push_back(cutPoint(a, b, region));
  }
  return polygon;
}

bool isInside(const std::array<ClipCorner, 3>& corners, const Field& region) {
  const auto [low, high] = std::minmax({corners[0].distance, corners[1].distance, corners[2].distance});
  if (low < 0.0) return true;
  const Vector3d middle = (corners[0].position + corners[1].position + corners[2].position) / 3.0;
  return high == 0.0 && region(middle) < 0.0;
}

}  // namespace

void addSheet(TriangleSoup& soup, int uCells, int vCells, const Sheet& sheet) {
  addSheet(soup, uCells, vCells, sheet, [](int, int) { return false; });
}

void addSheet(TriangleSoup& soup, int uCells, int vCells, const Sheet& sheet,
              const std::function<bool(int, int)>& isHole) {
  const auto point = [&](int i, int j) {
    return sheet(static_cast<double>(i) / uCells, static_cast<double>(j) / vCells);
  };
  for (int j = 0; j < vCells; ++j) {
    for (int i = 0; i < uCells; ++i) {
      if (isHole(i, j)) continue;
      const Vector3d a = point(i, j), b = point(i + 1, j), c = point(i + 1, j + 1), d = point(i, j + 1);
      addTriangle(soup, a, b, c);
      addTriangle(soup, a, c, d);
    }
  }
}

Joint onLine(const std::vector<Joint>& joints, double v) {
  const int last = static_cast<int>(joints.size()) - 1;
  const int first = std::clamp(static_cast<int>(std::floor(v * last)), 0, last - 1);
  const auto at = [&](int i) { return joints[static_cast<std::size_t>(std::clamp(i, 0, last))]; };
  const Joint a = at(first - 1), b = at(first), c = at(first + 1), d = at(first + 2);
  const double t = v * last - first;
  const Vector3d centre = catmullRom(a.centre, b.centre, c.centre, d.centre, t);
  return {centre, std::max(catmullRom(a.radius, b.radius, c.radius, d.radius, t), 0.0)};
}

Sheet tube(const std::vector<Joint>& joints, const Vector3d& side) {
  return [=](double u, double v) -> Vector3d {
    const Joint joint = onLine(joints, v);
    const Vector3d ahead = onLine(joints, std::min(v + kDirectionStep, 1.0)).centre,
                   behind = onLine(joints, std::max(v - kDirectionStep, 0.0)).centre;
    const Vector3d other = (ahead - behind).normalized().cross(side);
    const double angle = 2.0 * kPi * u;
    return joint.centre + joint.radius * (std::cos(angle) * side + std::sin(angle) * other);
  };
}

Sheet ball(const Vector3d& centre, const Vector3d& radii) {
  return [=](double u, double v) -> Vector3d {
    const double around = 2.0 * kPi * u, up = kPi * (v - 0.5);
    const Vector3d direction(std::sin(around) * std::cos(up), std::sin(up), std::cos(around) * std::cos(up));
    return centre + radii.cwiseProduct(direction);
  };
}

TriangleSoup clip(const TriangleSoup& soup, const Field& surface, const Field& region, double snap) {
  TriangleSoup result;
  for (const auto& triangle : soup) {
    std::array<ClipCorner, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = snapped(triangle[i].position, surface, region, snap);
    if (!isInside(corners, region)) continue;
    const std::vector<Vector3d> polygon = clipTriangle(corners, region);
    for (std::size_t i = 2; i < polygon.size(); ++i)
      addTriangle(result, polygon[0], polygon[i - 1], polygon[i]);
  }
  return result;
}

void append(TriangleSoup& soup, const TriangleSoup& other) {
  soup.insert(soup.end(), other.begin(), other.end());
}

TriangleSoup flipped(const TriangleSoup& soup) {
  TriangleSoup result = soup;
  for (auto& triangle : result) std::swap(triangle[1], triangle[2]);
  return result;
}

TriangleSoup mirroredX(const TriangleSoup& soup) {
  return flipped(moved(soup, [](const Vector3d& p) { return Vector3d(-p.x(), p.y(), p.z()); }));
}

TriangleSoup moved(const TriangleSoup& soup, const std::function<Vector3d(const Vector3d&)>& move) {
  TriangleSoup result = soup;
  for (auto& triangle : result) {
    for (Corner& corner : triangle) corner.position = move(corner.position);
  }
  return result;
}

}  // namespace shapes

// SPDX-License-Identifier: Zlib
#include "shapes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace shapes {

// --- cubes and an L of cells
// --------------------------------------------------------------------------------

namespace {

using Cell = Eigen::Vector3i;

/// Which cells are full; the surface lies between full and empty ones.
using CellTest = bool (*)(const Cell& cell);

Eigen::Vector3i axisVector(int axis) { return Eigen::Vector3i::Unit(axis); }

/// The face of a cell towards +axis or -axis: u and v complete the outward normal to a right-handed frame,
/// and run over the whole box from 0 to 1.
void addFace(TriangleSoup& soup, const Cell& cell, int cellsPerSide, int axis, bool positive) {
  const int uAxis = (axis + 1) % 3, vAxis = (axis + 2) % 3;
  const auto corner = [&](int u, int v) {
    const Eigen::Vector3i lattice =
        cell + (positive ? axisVector(axis) : Cell(0, 0, 0)) + u * axisVector(uAxis) + v * axisVector(vAxis);
    const Eigen::Vector3d unit = lattice.cast<double>() / cellsPerSide;
    const double uFromOutside = positive ? unit[uAxis] : 1.0 - unit[uAxis];
    return Corner{unit - Eigen::Vector3d::Constant(0.5), {uFromOutside, unit[vAxis]}};
  };
  if (positive) {
    addQuad(soup, corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
  } else {
    addQuad(soup, corner(1, 0), corner(0, 0), corner(0, 1), corner(1, 1));
  }
}

bool isInside(const Cell& cell, int cellsPerSide) {
  return cell.minCoeff() >= 0 && cell.maxCoeff() < cellsPerSide;
}

void addCell(TriangleSoup& soup, const Cell& cell, int cellsPerSide, CellTest isFull) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool positive : {false, true}) {
      const Cell neighbour = cell + (positive ? 1 : -1) * axisVector(axis);
      const bool covered = isInside(neighbour, cellsPerSide) && isFull(neighbour);
      if (!covered) addFace(soup, cell, cellsPerSide, axis, positive);
    }
  }
}

TriangleSoup makeFromCells(int cellsPerSide, CellTest isFull) {
  TriangleSoup soup;
  for (int z = 0; z < cellsPerSide; ++z) {
    for (int y = 0; y < cellsPerSide; ++y) {
      for (int x = 0; x < cellsPerSide; ++x) {
        if (isFull({x, y, z})) addCell(soup, {x, y, z}, cellsPerSide, isFull);
      }
    }
  }
  return soup;
}

}  // namespace

TriangleSoup makeCube() {
  return makeFromCells(1, [](const Cell&) { return true; });
}

TriangleSoup makeLShape() {
  return makeFromCells(4, [](const Cell& cell) { return cell.x() < 2 || cell.y() < 2; });
}

// --- round shapes
// -------------------------------------------------------------------------------------------

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Directions = std::array<Vector3d, 3>;

/// A point at 0.5 m below this distance from the y axis lies on it.
constexpr double kOnAxis = 1e-6;

/// The corners of an icosahedron: golden rectangles in the three coordinate planes.
std::array<Vector3d, 12> icosahedronCorners() {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  std::array<Vector3d, 12> corners{Vector3d(-1, g, 0),  Vector3d(1, g, 0),   Vector3d(-1, -g, 0),
                                   Vector3d(1, -g, 0),  Vector3d(0, -1, g),  Vector3d(0, 1, g),
                                   Vector3d(0, -1, -g), Vector3d(0, 1, -g),  Vector3d(g, 0, -1),
                                   Vector3d(g, 0, 1),   Vector3d(-g, 0, -1), Vector3d(-g, 0, 1)};
  for (Vector3d& corner : corners) corner.normalize();
  return corners;
}

constexpr std::array<std::array<std::size_t, 3>, 20> kIcosahedronFaces{
    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};

void addSplitTriangle(std::vector<Directions>& triangles, const Directions& t, int splits) {
  if (splits == 0) {
    triangles.push_back(t);
    return;
  }
  const Vector3d ab = (t[0] + t[1]).normalized(), bc = (t[1] + t[2]).normalized(),
                 ca = (t[2] + t[0]).normalized();
  addSplitTriangle(triangles, {t[0], ab, ca}, splits - 1);
  addSplitTriangle(triangles, {t[1], bc, ab}, splits - 1);
  addSplitTriangle(triangles, {t[2], ca, bc}, splits - 1);
  addSplitTriangle(triangles, {ab, bc, ca}, splits - 1);
}

std::vector<Directions> splitIcosahedron(int splits) {
  const std::array<Vector3d, 12> corners = icosahedronCorners();
  std::vector<Directions> triangles;
  for (const auto& face : kIcosahedronFaces) {
    addSplitTriangle(triangles, {corners[face[0]], corners[face[1]], corners[face[2]]}, splits);
  }
  return triangles;
}

bool isPole(const Vector3d& direction) { return std::hypot(direction.x(), direction.z()) < kOnAxis; }

/// Longitude and latitude of three directions as u and v. Across the seam u goes on beyond 1 instead of back
/// to 0; a pole has no longitude and takes the mean of the other two.
std::array<Vector2d, 3> mapUvs(const Directions& directions) {
  std::array<Vector2d, 3> uvs;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d& d = directions[i];
    const double longitude = isPole(d) ? 0.0 : std::atan2(d.x(), d.z() + 0.0) / (2.0 * kPi) + 0.5;
    uvs[i] = {longitude, std::asin(std::clamp(d.y(), -1.0, 1.0)) / kPi + 0.5};
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const double others = std::max(uvs[(i + 1) % 3].x(), uvs[(i + 2) % 3].x());
    if (!isPole(directions[i]) && others - uvs[i].x() > 0.5) uvs[i].x() += 1.0;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (isPole(directions[i])) uvs[i].x() = (uvs[(i + 1) % 3].x() + uvs[(i + 2) % 3].x()) / 2.0;
  }
  return uvs;
}

/// The split icosahedron with each direction moved out to its radius.
template <class Radius>
TriangleSoup makeBall(Radius radius) {
  TriangleSoup soup;
  for (const Directions& d : splitIcosahedron(2)) {
    const std::array<Vector2d, 3> uvs = mapUvs(d);
    soup.push_back({Corner{radius(d[0]) * d[0], uvs[0]}, Corner{radius(d[1]) * d[1], uvs[1]},
                    Corner{radius(d[2]) * d[2], uvs[2]}});
  }
  return soup;
}

Vector3d aroundY(double radius, double y, double turn) {
  return {radius * std::sin(2.0 * kPi * turn), y, radius * std::cos(2.0 * kPi * turn)};
}

}  // namespace

TriangleSoup makeIcosphere() {
  return makeBall([](const Vector3d&) { return 0.5; });
}

TriangleSoup makeStar() {
  constexpr double kTip = 0.588, kValley = 0.22, kHalfWidth = 0.5;  // metres, metres, radians
  return makeBall([tips = icosahedronCorners()](const Vector3d& direction) {
    double nearest = -1.0;
    for (const Vector3d& tip : tips) nearest = std::max(nearest, tip.dot(direction));
    const double rise = std::max(0.0, 1.0 - std::acos(std::min(nearest, 1.0)) / kHalfWidth);
    return kValley + (kTip - kValley) * rise;
  });
}

TriangleSoup makeTorus() {
  constexpr int kSegments = 16, kSides = 8;
  constexpr double kRing = 0.35, kTube = 0.15;  // metres
  const auto corner = [](int segment, int side) {
    const double turn = static_cast<double>(segment) / kSegments, tilt = static_cast<double>(side) / kSides;
    const double radius = kRing + kTube * std::cos(2.0 * kPi * tilt);
    return Corner{aroundY(radius, kTube * std::sin(2.0 * kPi * tilt), turn), {turn, tilt}};
  };
  TriangleSoup soup;
  for (int i = 0; i < kSegments; ++i) {
    for (int j = 0; j < kSides; ++j) {
      addQuad(soup, corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
    }
  }
  return soup;
}

TriangleSoup makeCylinder() {
  constexpr int kSegments = 12, kRows = 5;
  constexpr double kRadius = 0.35;  // metres
  const auto side = [](int segment, int row) {
    const double turn = static_cast<double>(segment) / kSegments, rise = static_cast<double>(row) / kRows;
    return Corner{aroundY(kRadius, rise - 0.5, turn), {turn, rise}};
  };
  const auto cap = [](double radius, double y, int segment) {
    const Vector3d p = aroundY(radius * kRadius, y, static_cast<double>(segment) / kSegments);
    const double toRight = y > 0.0 ? p.x() : -p.x();
    return Corner{p, {0.5 + toRight / (2.0 * kRadius), 0.5 - p.z() / (2.0 * kRadius)}};
  };
  TriangleSoup soup;
  for (int i = 0; i < kSegments; ++i) {
    for (int row = 0; row < kRows; ++row) {
      addQuad(soup, side(i, row), side(i + 1, row), side(i + 1, row + 1), side(i, row + 1));
    }
    soup.push_back({cap(0.0, 0.5, 0), cap(1.0, 0.5, i), cap(1.0, 0.5, i + 1)});
    soup.push_back({cap(0.0, -0.5, 0), cap(1.0, -0.5, i + 1), cap(1.0, -0.5, i)});
  }
  return soup;
}

}  // namespace shapes

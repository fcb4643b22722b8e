// SPDX-License-Identifier: Zlib
#include "box_shapes.h"

namespace shapes {
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

}  // namespace shapes

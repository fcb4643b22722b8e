// SPDX-License-Identifier: Zlib
#include "shapes.h"

#include "sheets.h"

#include <algorithm>
#include <cmath>

namespace shapes {
namespace {

using Eigen::Vector3d;

// All lengths are metres.

constexpr int kColumns = 64, kBodyRows = 22, kLidRows = 16, kLidBowlRows = 8;

/// The handle grows out of two holes in the wall of the body, each of 3 x 3 cells, at these rows.
constexpr int kHoleCells = 3, kHoleColumn = 31, kLowerHole = 8, kUpperHole = 15;

/// A profile of radii and heights around the y axis. u runs from +x to -z, so that the outside is out; the
/// middle of the holes' columns is at -x.
Sheet lathe(const std::vector<Eigen::Vector2d>& profile) {
  std::vector<Joint> joints;
  for (const Eigen::Vector2d& p : profile) joints.push_back({{0.0, p.y(), 0.0}, p.x()});
  return [=](double u, double v) -> Vector3d {
    const Joint joint = onLine(joints, v);
    const double angle = 2.0 * kPi * (u - 0.5 / kColumns);
    return {joint.radius * std::cos(angle), joint.centre.y(), -joint.radius * std::sin(angle)};
  };
}

/// From the middle of the bottom to the rim, which turns inward.
Sheet bodySheet() {
  return lathe({{0.0, 0.012},
                {0.10, 0.012},
                {0.165, 0.0},
                {0.185, 0.012},
                {0.225, 0.055},
                {0.265, 0.115},
                {0.285, 0.175},
                {0.283, 0.235},
                {0.262, 0.29},
                {0.232, 0.335},
                {0.208, 0.365},
                {0.200, 0.380},
                {0.192, 0.384},
                {0.184, 0.374}});
}

/// From the lower edge over the bowl to the top of the knob.
Sheet lidSheet() {
  return lathe({{0.175, 0.368},
                {0.179, 0.388},
                {0.145, 0.412},
                {0.095, 0.430},
                {0.030, 0.441},
                {0.023, 0.458},
                {0.042, 0.482},
                {0.037, 0.506},
                {0.0, 0.518}});
}

bool isHandleHole(int column, int row) {
  const auto isIn = [](int value, int low) { return value >= low && value < low + kHoleCells; };
  return isIn(column, kHoleColumn) && (isIn(row, kLowerHole) || isIn(row, kUpperHole));
}

/// The corners around a hole, in the order of the handle's sides: first those at +z, upward where the handle
/// begins and downward where it ends.
std::vector<Vector3d> holeRim(int firstRow, bool upward) {
  std::vector<Vector3d> rim;
  const auto add = [&](int i, int j) {
    const int row = firstRow + (upward ? j : kHoleCells - j);
    rim.push_back(
        bodySheet()(static_cast<double>(kHoleColumn + i) / kColumns, static_cast<double>(row) / kBodyRows));
  };
  for (int j = 0; j < kHoleCells; ++j) add(kHoleCells, j);
  for (int i = kHoleCells; i > 0; --i) add(i, kHoleCells);
  for (int j = kHoleCells; j > 0; --j) add(0, j);
  for (int i = 0; i < kHoleCells; ++i) add(i, 0);
  return rim;
}

/// A tube from the lower to the upper hole, whose ends have the shape of the holes.
void addHandle(TriangleSoup& soup) {
  constexpr int kSides = 4 * kHoleCells, kRows = 26;
  constexpr double kFirstSide = -0.5 * kHoleCells / kSides, kFlare = 0.2;
  const Sheet middle = tube({{{-0.262, 0.135, 0.0}, 0.032},
                             {{-0.330, 0.128, 0.0}, 0.023},
                             {{-0.425, 0.170, 0.0}, 0.021},
                             {{-0.478, 0.260, 0.0}, 0.021},
                             {{-0.450, 0.325, 0.0}, 0.021},
                             {{-0.345, 0.342, 0.0}, 0.022},
                             {{-0.226, 0.337, 0.0}, 0.032}},
                            {0.0, 0.0, 1.0});
  const std::vector<Vector3d> lower = holeRim(kLowerHole, true), upper = holeRim(kUpperHole, false);
  addSheet(soup, kSides, kRows, [&](double u, double v) -> Vector3d {
    const std::size_t side = static_cast<std::size_t>(std::lround(u * kSides)) % kSides;
    const double share = std::max(1.0 - std::min(v, 1.0 - v) / kFlare, 0.0);
    const Vector3d rim = v < 0.5 ? lower[side] : upper[side];
    return middle(u + kFirstSide, v) + share * share * (rim - middle(u + kFirstSide, v));
  });
}

void addSpout(TriangleSoup& soup) {
  addSheet(soup, 18, 20,
           tube({{{0.195, 0.150, 0.0}, 0.070},
                 {{0.295, 0.158, 0.0}, 0.060},
                 {{0.365, 0.212, 0.0}, 0.043},
                 {{0.405, 0.290, 0.0}, 0.032},
                 {{0.445, 0.350, 0.0}, 0.028},
                 {{0.500, 0.380, 0.0}, 0.030}},
                {0.0, 0.0, 1.0}));
}

void addLid(TriangleSoup& soup) {
  TriangleSoup knob;
  addSheet(soup, kColumns / 2, kLidRows, lidSheet(), [](int, int row) { return row >= kLidBowlRows; });
  addSheet(knob, kColumns / 2, kLidRows, lidSheet(), [](int, int row) { return row < kLidBowlRows; });
  append(soup, flipped(knob));
}

}  // namespace

TriangleSoup makeTeapot() {
  TriangleSoup soup;
  addSheet(soup, kColumns, kBodyRows, bodySheet(), isHandleHole);
  addHandle(soup);
  addSpout(soup);
  addLid(soup);
  return soup;
}

}  // namespace shapes

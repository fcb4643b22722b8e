// SPDX-License-Identifier: Zlib
#include "core/merge_positions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <unordered_map>

namespace limber {
namespace {

using Cell = std::array<std::int64_t, 3>;

constexpr std::uint32_t kEndOfChain = 0xffffffffu;

/// Cells this many tolerances wide: a position then has to look into 3 or 4 cells on average.
constexpr double kTolerancesPerCell = 4.0;

/// Cells narrower than this part of the largest coordinate would have numbers that a double cannot count.
constexpr double kFinestCell = 0x1p-40;

/// How much further than the tolerance we look: more than rounding can shift a border.
constexpr double kReachMargin = 1.001;

struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    std::uint64_t hash = 0;
    for (const std::int64_t index : cell) {
      hash = (hash ^ static_cast<std::uint64_t>(index)) * 0x9e3779b97f4a7c15u;  // 2^64 / golden ratio
      hash ^= hash >> 32;
    }
    return static_cast<std::size_t>(hash);
  }
};

/// The positions kept so far, by the cell they lie in. A cell holds few of them, since they lie apart by more
/// than the tolerance. Only looked up, never iterated: the order of the hash table does not show.
struct KeptPositions {
  double largest;  ///< no coordinate of any position is further from 0
  double cellWidth;
  std::unordered_map<Cell, std::uint32_t, CellHash> lastInCell;
  std::vector<std::uint32_t> previousInCell;  ///< #positions; kEndOfChain ends the chain
};

double largestCoordinate(const std::vector<Eigen::Vector3d>& positions) {
  double largest = 0.0;
  for (const Eigen::Vector3d& p : positions) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return largest;
}

Cell cellOf(const Eigen::Vector3d& position, const KeptPositions& kept) {
  const Eigen::Vector3d inside = position.cwiseMax(-kept.largest).cwiseMin(kept.largest);
  const Eigen::Vector3d cell = (inside / kept.cellWidth).array().floor();
  return {static_cast<std::int64_t>(cell.x()), static_cast<std::int64_t>(cell.y()),
          static_cast<std::int64_t>(cell.z())};
}

void keep(KeptPositions& kept, const Cell& cell, std::uint32_t index) {
  const auto [entry, isNew] = kept.lastInCell.try_emplace(cell, index);
  if (isNew) return;
  kept.previousInCell[index] = entry->second;
  entry->second = index;
}

struct Nearest {
  std::uint32_t index = kEndOfChain;
  double distance = std::numeric_limits<double>::infinity();
};

void lookInCell(const KeptPositions& kept, const std::vector<Eigen::Vector3d>& positions, const Cell& cell,
                const Eigen::Vector3d& position, Nearest& nearest) {
  const auto entry = kept.lastInCell.find(cell);
  if (entry == kept.lastInCell.end()) return;
  for (std::uint32_t other = entry->second; other != kEndOfChain; other = kept.previousInCell[other]) {
    const double distance = (positions[other] - position).stableNorm();
    const bool earlierAndAsNear = distance == nearest.distance && other < nearest.index;
    if (distance < nearest.distance || earlierAndAsNear) nearest = {other, distance};
  }
}

/// The nearest kept position, if one lies within the tolerance; further ones may be missed.
Nearest findNearest(const KeptPositions& kept, const std::vector<Eigen::Vector3d>& positions,
                    const Eigen::Vector3d& position, double tolerance) {
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(tolerance * kReachMargin);
  const Cell low = cellOf(position - reach, kept), high = cellOf(position + reach, kept);
  Nearest nearest;
  for (std::int64_t x = low[0]; x <= high[0]; ++x) {
    for (std::int64_t y = low[1]; y <= high[1]; ++y) {
      for (std::int64_t z = low[2]; z <= high[2]; ++z)
        lookInCell(kept, positions, {x, y, z}, position, nearest);
    }
  }
  return nearest;
}

}  // namespace

std::vector<std::uint32_t> mergeEqual(const std::vector<Eigen::Vector3d>& positions) {
  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    const Eigen::Vector3d &p = positions[i], &q = positions[j];
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (p[axis] != q[axis]) return p[axis] < q[axis];
    }
    return i < j;
  });

  std::vector<std::uint32_t> joined(positions.size());
  std::uint32_t first = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k == 0 || positions[order[k]] != positions[first]) first = order[k];
    joined[order[k]] = first;
  }
  return joined;
}

std::vector<std::uint32_t> mergeNearby(const std::vector<Eigen::Vector3d>& positions, double tolerance) {
  const double largest = largestCoordinate(positions);
  const double cellWidth = std::max(tolerance * kTolerancesPerCell, largest * kFinestCell);
  KeptPositions kept{largest, cellWidth, {}, std::vector<std::uint32_t>(positions.size(), kEndOfChain)};
  std::vector<std::uint32_t> joined(positions.size());
  for (std::uint32_t i = 0; i < joined.size(); ++i) {
    const Nearest nearest = findNearest(kept, positions, positions[i], tolerance);
    const bool joins = nearest.distance <= tolerance;
    joined[i] = joins ? nearest.index : i;
    if (!joins) keep(kept, cellOf(positions[i], kept), i);
  }
  return joined;
}

}  // namespace limber

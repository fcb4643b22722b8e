// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <limits>
#include <vector>

namespace limber {

/// Where something is at any time of the tick (m). The fourth coordinate is 0: whole registers.
struct SweptBox {
  Eigen::Array4d low = {kEmpty, kEmpty, kEmpty, 0.0};
  Eigen::Array4d high = {-kEmpty, -kEmpty, -kEmpty, 0.0};

  static constexpr double kEmpty = std::numeric_limits<double>::infinity();
};

inline SweptBox merged(const SweptBox& a, const SweptBox& b) {
  return {a.low.min(b.low), a.high.max(b.high)};
}

/// m: no two points of the boxes are nearer to each other; 0 if they overlap.
inline double separation(const SweptBox& a, const SweptBox& b) {
  return (a.low - b.high).max(b.low - a.high).maxCoeff();
}

/// The boxes of a surface, its radius included.
struct SurfaceBoxes {
  std::vector<SweptBox> points;  ///< #points
  std::vector<SweptBox> nodes;   ///< #nodes of its tree
};

}  // namespace limber

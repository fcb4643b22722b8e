// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace limber::bench {

/// Errors of a detailed mesh that rides on a coarse one.
struct SkinRow {
  std::string mesh, kind;
  std::size_t vertices = 0, points = 0;
  double weightsPerVertex = 0.0;
  double affine = 0.0;  ///< of the size: largest error of an affine motion
  double smooth = 0.0;  ///< of the size: root mean square over the worst of bend, twist, squash, wobble
  double seconds = 0.0;
};

std::vector<SkinRow> measureSkins(bool quick);
std::string skinTable(const std::vector<SkinRow>& rows);

}  // namespace limber::bench

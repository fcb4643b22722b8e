// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber::bench {

/// What cooking a mesh with the default rule takes, and a few runs to see that the body is as good as others.
struct LargeRow {
  std::string mesh;
  std::size_t points = 0, braces = 0;
  double seconds = 0.0;    ///< of this thread
  double megabytes = 0.0;  ///< most that the process has held so far
  std::uint32_t runs = 0, returned = 0;
};

/// About 300 and 5 000 points. Minutes.
std::vector<LargeRow> measureLarge();
std::string largeTable(const std::vector<LargeRow>& rows);
std::string largeTargets(const std::vector<LargeRow>& rows);

}  // namespace limber::bench

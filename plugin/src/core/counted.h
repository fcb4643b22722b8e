// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <string>

namespace limber {

/// "1 vertex", "2 vertices"
inline std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <vector>

namespace limber {

/// 64 bytes, so that a register of any instruction set can be read from an array of these.
struct alignas(64) CacheLine {
  double value[8];
};

using AlignedNumbers = std::vector<CacheLine>;

inline double* numbers(AlignedNumbers& array) { return array.front().value; }

/// Makes room for `count` numbers; never shrinks. What is new is 0.
inline void reserveNumbers(AlignedNumbers& array, std::size_t count) {
  if (array.size() * 8 < count) array.resize((count + 7) / 8, CacheLine{});
}

}  // namespace limber

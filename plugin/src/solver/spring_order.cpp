// SPDX-License-Identifier: Zlib
#include "solver/spring_order.h"

#include <algorithm>

namespace limber {
namespace {

/// Springs that are looked at for one that fits: enough for any network, and linear in its size.
constexpr std::size_t kWindow = 256;

bool shares(const NetworkSpring& s, const NetworkSpring& t) {
  return s.a == t.a || s.a == t.b || s.b == t.a || s.b == t.b;
}

}  // namespace

std::vector<std::uint32_t> orderApart(const SpringNetwork& network) {
  const std::vector<NetworkSpring>& springs = network.springs;
  std::vector<std::uint32_t> left(springs.size()), order;
  for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
  order.reserve(springs.size());
  std::size_t first = 0;  // left[0..first) are taken
  while (first < left.size()) {
    const std::size_t begin = order.size(), end = std::min(left.size(), first + kWindow);
    const auto fits = [&](std::uint32_t i) {
      return std::none_of(order.begin() + static_cast<std::ptrdiff_t>(begin), order.end(),
                          [&](std::uint32_t j) { return shares(springs[i], springs[j]); });
    };
    while (order.size() < begin + 4 && first < left.size()) {
      std::size_t k = first;
      while (k < end && !fits(left[k])) ++k;
      if (k == end) k = first;  // none fits: the four will be taken in turn
      order.push_back(left[k]);
      // those passed over move up and keep their order
      std::rotate(left.begin() + static_cast<std::ptrdiff_t>(first),
                  left.begin() + static_cast<std::ptrdiff_t>(k),
                  left.begin() + static_cast<std::ptrdiff_t>(k) + 1);
      ++first;
    }
  }
  return order;
}

}  // namespace limber

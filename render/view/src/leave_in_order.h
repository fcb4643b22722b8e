// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <iterator>
#include <unordered_map>
#include <vector>

namespace limber::view {

/// Takes what is `gone` out of the map and calls `hide` for it, in the order of the instances: that of
/// addresses differs from run to run, and with it would the places that new instances get.
template <class Key, class Shown, class Gone, class Hide>
void leaveInOrder(std::unordered_map<Key, Shown>& shown, Gone gone, Hide hide) {
  std::vector<Shown> leaving;
  for (auto it = shown.begin(); it != shown.end();) {
    if (gone(it->second)) leaving.push_back(it->second);
    it = gone(it->second) ? shown.erase(it) : std::next(it);
  }
  std::sort(leaving.begin(), leaving.end(),
            [](const Shown& a, const Shown& b) { return a.instance.index < b.instance.index; });
  for (const Shown& one : leaving) hide(one);
}

}  // namespace limber::view

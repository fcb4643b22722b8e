// SPDX-License-Identifier: Zlib
// How much a test does: more with tests/run --long, less under sanitizers.
#pragma once

#include <cstdlib>
#include <initializer_list>
#include <vector>

namespace limber::test {

/// Whether the long tests run, too: CTest sets the environment variable if LIMBER_LONG_TESTS is on.
inline const bool kLongTests = std::getenv("LIMBER_LONG_TESTS") != nullptr;

/// Whether sanitizers watch. They make worlds five times as slow, and look for what one variant of a scene
/// shows as well as several.
#ifdef __SANITIZE_ADDRESS__
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

/// Returns the variants of a test that belong to every run, and with the long tests also `more` of the same.
template <class T>
std::vector<T> variants(std::initializer_list<T> few, std::initializer_list<T> more) {
  std::vector<T> all(few);
  if (kLongTests) all.insert(all.end(), more);
  return all;
}

}  // namespace limber::test

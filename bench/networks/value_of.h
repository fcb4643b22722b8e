// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>

#include <stdexcept>
#include <utility>

namespace limber::bench {

/// Throws std::runtime_error with the reason if there is no value.
template <class T>
T valueOf(Result<T> result) {
  if (!result) throw std::runtime_error(result.error());
  return std::move(*result);
}

}  // namespace limber::bench

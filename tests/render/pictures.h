// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <exception>
#include <string>

#include "limber/render/image.h"

namespace limber::render::test {

/// Returns what the exception of the call says.
template <typename Call>
std::string errorOf(Call call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no error";
}

/// Returns a picture of seeded bytes, transparency included.
inline Image noise(int width, int height, std::uint32_t seed = 1) {
  Image image;
  image.resize(width, height);
  std::uint32_t state = seed;
  for (std::uint8_t& value : image.rgba) {
    state = state * 1664525u + 1013904223u;
    value = static_cast<std::uint8_t>(state >> 24);
  }
  return image;
}

}  // namespace limber::render::test

// SPDX-License-Identifier: Zlib
#include "overlay_lines.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace limber::render {
namespace {

float colourBits(Vec3 colour) {
  const auto byte = [](float share) {
    return static_cast<std::uint32_t>(std::lround(255.0f * std::clamp(share, 0.0f, 1.0f)));
  };
  // The highest byte stays below 255: with all its bits set the word would be a NaN, which may not survive
  // being moved as a float.
  const std::uint32_t word = byte(colour.x) | byte(colour.y) << 8u | byte(colour.z) << 16u;
  float bits = 0.0f;
  std::memcpy(&bits, &word, sizeof bits);
  return bits;
}

}  // namespace

void OverlayLines::upload(const Overlay& overlay) {
  count_ = static_cast<GLsizei>(overlay.size());
  if (overlay.empty()) {
    return;
  }
  staging_.clear();
  for (const OverlayLine& line : overlay) {
    staging_.push_back({line.from.x, line.from.y, line.from.z, colourBits(line.colour), line.to.x, line.to.y,
                        line.to.z, line.width});
  }
  const std::size_t bytes = staging_.size() * sizeof(Packed);
  if (buffer_.bytes() < bytes) {
    buffer_ = makeBuffer(gl_, bytes + bytes / 2, nullptr, GL_DYNAMIC_STORAGE_BIT);
  }
  gl_.NamedBufferSubData(buffer_.name(), 0, static_cast<GLsizeiptr>(bytes), staging_.data());
}

}  // namespace limber::render

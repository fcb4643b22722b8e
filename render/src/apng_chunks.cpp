// SPDX-License-Identifier: Zlib
#include "apng_chunks.h"

#include <zlib.h>

#include <cstddef>
#include <cstring>

namespace limber::render {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kSignatureBytes = 8;
constexpr std::size_t kTypeBytes = 4;
constexpr std::size_t kChunkFrame = 12;  // Length, type and CRC.
constexpr std::uint32_t kForEver = 0;
constexpr std::uint8_t kKeep = 0;  // dispose_op: the frame stays under the next one.
constexpr std::uint8_t kOver = 1;  // blend_op: what is transparent shows the frame before.

void put16(Bytes& bytes, std::uint32_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8 & 255));
  bytes.push_back(static_cast<std::uint8_t>(value & 255));
}

void put32(Bytes& bytes, std::uint32_t value) {
  put16(bytes, value >> 16);
  put16(bytes, value & 65535);
}

std::uint32_t get32(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 |
         std::uint32_t{bytes[3]};
}

Bytes chunk(const char* type, const Bytes& data) {
  Bytes bytes;
  bytes.reserve(data.size() + kChunkFrame);
  put32(bytes, static_cast<std::uint32_t>(data.size()));
  bytes.insert(bytes.end(), type, type + kTypeBytes);
  bytes.insert(bytes.end(), data.begin(), data.end());
  // The CRC covers the type and the data.
  const uLong crc = crc32(0, &bytes[4], static_cast<uInt>(bytes.size() - 4));
  put32(bytes, static_cast<std::uint32_t>(crc));
  return bytes;
}

}  // namespace

PngParts splitPng(const std::vector<std::uint8_t>& png) {
  PngParts parts;
  parts.head.assign(png.begin(), png.begin() + kSignatureBytes);
  std::size_t size = 0;
  for (std::size_t at = kSignatureBytes; at < png.size(); at += size) {
    const std::uint8_t* begin = &png[at];
    size = get32(begin) + kChunkFrame;
    if (std::memcmp(begin + 4, "IDAT", kTypeBytes) == 0) {
      parts.pixels.insert(parts.pixels.end(), begin + 8, begin + size - 4);
    } else if (std::memcmp(begin + 4, "IEND", kTypeBytes) != 0) {
      parts.head.insert(parts.head.end(), begin, begin + size);
    }
  }
  return parts;
}

std::vector<std::uint8_t> animationControl(std::uint32_t frames) {
  Bytes data;
  put32(data, frames);
  put32(data, kForEver);
  return chunk("acTL", data);
}

std::vector<std::uint8_t> frameControl(std::uint32_t sequence, const PixelArea& area,
                                       std::uint16_t delayNumerator, std::uint16_t delayDenominator) {
  Bytes data;
  put32(data, sequence);
  for (const int value : {area.width, area.height, area.x, area.y}) {
    put32(data, static_cast<std::uint32_t>(value));
  }
  put16(data, delayNumerator);
  put16(data, delayDenominator);
  data.push_back(kKeep);
  data.push_back(kOver);
  return chunk("fcTL", data);
}

std::vector<std::uint8_t> firstFrame(const std::vector<std::uint8_t>& pixels) {
  return chunk("IDAT", pixels);
}

std::vector<std::uint8_t> laterFrame(std::uint32_t sequence, const std::vector<std::uint8_t>& pixels) {
  Bytes data;
  data.reserve(4 + pixels.size());
  put32(data, sequence);
  data.insert(data.end(), pixels.begin(), pixels.end());
  return chunk("fdAT", data);
}

std::vector<std::uint8_t> imageEnd() { return chunk("IEND", {}); }

}  // namespace limber::render

// SPDX-License-Identifier: Zlib
#include "cook/payload_hash.h"

#include "cook/little_endian.h"

namespace limber {
namespace {

// FNV-1a's offset basis (Fowler, Noll, Vo), and an odd factor with many bits set (that of splitmix64)
constexpr std::uint64_t kBasis = 0xcbf29ce484222325u;
constexpr std::uint64_t kFactor = 0xbf58476d1ce4e5b9u;

// FNV-1a over words instead of bytes, eight times as fast. Both steps can be undone (the factor is odd), so
// different words lead from one state to different states, and different states stay different.
std::uint64_t mix(std::uint64_t hash, std::uint64_t word) {
  hash = (hash ^ word) * kFactor;
  return hash ^ hash >> 32;
}

}  // namespace

std::uint64_t hashPayload(const std::uint8_t* bytes, std::size_t size) {
  std::uint64_t hash = mix(kBasis, size);
  const std::size_t whole = size / 8 * 8;
  for (std::size_t at = 0; at < whole; at += 8) hash = mix(hash, readLittleEndian<std::uint64_t>(bytes + at));
  std::uint64_t rest = 0;  // the last bytes, filled up with zeros
  for (std::size_t at = whole; at < size; ++at) rest |= std::uint64_t{bytes[at]} << 8 * (at - whole);
  return mix(hash, rest);
}

}  // namespace limber

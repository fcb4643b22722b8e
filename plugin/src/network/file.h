// SPDX-License-Identifier: Zlib
// Declares the number format and the hash of network files. Tests of damaged files use them too.
#pragma once

#include <cstddef>
#include <cstdint>

namespace limber {

/// Reads an unsigned number from its bytes, the lowest first, on machines of any byte order. (Where the
/// orders agree, compilers make it one load.)
template <class Unsigned>
Unsigned readLittleEndian(const std::uint8_t* bytes) {
  Unsigned value = 0;
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) {
    value = static_cast<Unsigned>(value | static_cast<Unsigned>(bytes[i]) << 8 * i);
  }
  return value;
}

template <class Unsigned>
void writeLittleEndian(Unsigned value, std::uint8_t* bytes) {
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) bytes[i] = static_cast<std::uint8_t>(value >> 8 * i);
}

/// Computes a 64-bit hash against accidental damage, not against malice. It detects every change within one
/// of the 8-byte words that it reads, and any other change except for one in 2^64. It is the same on every
/// machine.
std::uint64_t hashPayload(const std::uint8_t* bytes, std::size_t size);

}  // namespace limber

// SPDX-License-Identifier: Zlib
// Declares the numbers and the hash of network files, which tests of damaged files need, too.
#pragma once

#include <cstddef>
#include <cstdint>

namespace limber {

/// An unsigned number from its bytes, lowest first, whatever the machine's own order. (Compilers make this
/// one load where the orders agree.)
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

/// A 64-bit hash against accidental damage, not against malice. Any change within one of the 8-byte words
/// that it reads is found for certain, any other but for one in 2^64. The same on every machine.
std::uint64_t hashPayload(const std::uint8_t* bytes, std::size_t size);

}  // namespace limber

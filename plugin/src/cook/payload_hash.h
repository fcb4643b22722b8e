// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>

namespace limber {

/// A 64-bit hash against accidental damage, not against malice. Any change within one of the 8-byte words
/// that it reads is found for certain, any other but for one in 2^64. The same on every machine.
std::uint64_t hashPayload(const std::uint8_t* bytes, std::size_t size);

}  // namespace limber

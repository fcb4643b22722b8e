// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include "cook/network_layout.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

// Numbers as a `.limber` file has them: little-endian, enumerations in one byte.

namespace limber {

template <std::size_t bytes>
struct UnsignedOf;
template <>
struct UnsignedOf<1> {
  using Type = std::uint8_t;
};
template <>
struct UnsignedOf<4> {
  using Type = std::uint32_t;
};
template <>
struct UnsignedOf<8> {
  using Type = std::uint64_t;
};

/// The unsigned number with the same bits as a T.
template <class T>
using Bits = typename UnsignedOf<sizeof(T)>::Type;

template <class T>
Bits<T> toBits(const T& value) {
  Bits<T> bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

template <class T>
T fromBits(Bits<T> bits) {
  T value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

/// Bytes of one element of an array, in the file.
template <class Element>
std::size_t bytesInFile() {
  std::size_t bytes = 0;
  const Element element{};
  forEachScalar(element, [&](const auto& scalar) { bytes += sizeof scalar; });
  return bytes;
}

/// The highest value of an enumeration.
constexpr NetworkKind lastOf(NetworkKind) { return NetworkKind::Solid; }
constexpr SpringKind lastOf(SpringKind) { return SpringKind::Brace; }

}  // namespace limber

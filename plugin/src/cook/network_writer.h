// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/file_numbers.h"
#include "cook/little_endian.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber {

/// The Stream of network_layout.h that appends to `bytes`.
class NetworkWriter {
 public:
  explicit NetworkWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  template <class T>
  void value(const char*, const T& value) {
    writeLittleEndian(toBits(value), grow(sizeof(T)));
  }

  void count(const char*, std::size_t count) { writeLittleEndian(std::uint64_t{count}, grow(8)); }

  template <class T>
  void array(const char* name, const std::vector<T>& elements) {
    count(name, elements.size());
    std::uint8_t* at = grow(elements.size() * bytesInFile<T>());
    for (const T& element : elements) {
      forEachScalar(element, [&](const auto& scalar) {
        writeLittleEndian(toBits(scalar), at);
        at += sizeof scalar;
      });
    }
  }

 private:
  std::uint8_t* grow(std::size_t size) {
    bytes_.resize(bytes_.size() + size);
    return bytes_.data() + bytes_.size() - size;
  }

  std::vector<std::uint8_t>& bytes_;
};

}  // namespace limber

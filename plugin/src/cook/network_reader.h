// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/file_numbers.h"
#include "cook/little_endian.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace limber {

/// The Stream of network_layout.h that reads `size` bytes and never beyond. After the first problem it reads
/// nothing more.
class NetworkReader {
 public:
  NetworkReader(const std::uint8_t* bytes, std::size_t size) : at_(bytes), left_(size) {}

  /// What is wrong, or empty.
  const std::string& problem() const { return problem_; }
  std::size_t bytesLeft() const { return left_; }

  template <class T>
  void value(const char* name, T& value) {
    if (!has(name, 1, sizeof(T))) return;
    if (!take(value)) problem_ = "the " + std::string(name) + outOfRange(value);
  }

  void count(const char* name, std::size_t& count) {
    if (!has(name, 1, 8)) return;
    std::uint64_t number = 0;
    take(number);
    if (number > std::numeric_limits<std::size_t>::max())
      problem_ = "more " + std::string(name) + " than fit this machine";
    else
      count = static_cast<std::size_t>(number);
  }

  template <class T>
  void array(const char* name, std::vector<T>& elements) {
    std::size_t size = 0;
    count(name, size);
    if (!has(name, size, bytesInFile<T>())) return;
    elements.resize(size);
    for (std::size_t i = 0; i < size && problem_.empty(); ++i) {
      forEachScalar(elements[i], [&](auto& scalar) {
        if (!take(scalar)) problem_ = "element " + std::to_string(i) + " of the " + name + outOfRange(scalar);
      });
    }
  }

 private:
  /// Before anything is allocated: no count can be higher than what the bytes still hold.
  bool has(const char* name, std::size_t count, std::size_t bytesEach) {
    if (!problem_.empty()) return false;
    if (count <= left_ / bytesEach) return true;
    problem_ = "the bytes end before its " + std::to_string(count) + " " + name;
    return false;
  }

  /// False if the value is none of its enumeration.
  template <class T>
  bool take(T& value) {
    value = fromBits<T>(readLittleEndian<Bits<T>>(at_));
    at_ += sizeof(T);
    left_ -= sizeof(T);
    if constexpr (std::is_enum_v<T>) return value <= lastOf(T{});
    return true;
  }

  template <class T>
  static std::string outOfRange(const T& value) {
    return " has the unknown kind " + std::to_string(+toBits(value));
  }

  const std::uint8_t* at_;
  std::size_t left_;
  std::string problem_;
};

}  // namespace limber

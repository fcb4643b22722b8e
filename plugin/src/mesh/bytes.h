// SPDX-License-Identifier: Zlib
// Numbers and arrays as bytes, and the header of files and saved states: a magic number, the version, the
// size and a hash. All numbers are little-endian, on machines of any byte order; enumerations take one byte.
#pragma once

#include <limber/result.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace limber {

// --- numbers -----------------------------------------------------------------------------------------------

/// Reads an unsigned number from its bytes, the lowest first. (Where the orders agree, compilers make it one
/// load.)
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

/// The unsigned number with the same bits as a T, which has 1, 4 or 8 bytes.
template <class T>
using Bits = std::conditional_t<sizeof(T) == 1, std::uint8_t,
                                std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>;

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

// --- arrays ------------------------------------------------------------------------------------------------

/// Calls scalar(x) for every number in an element of an array: a number, a std::array or a vector of Eigen's.
/// Other types have an overload in their namespace.
template <class Number, class F>
std::enable_if_t<std::is_arithmetic_v<Number>> forEachScalar(Number& number, F scalar) {
  scalar(number);
}

template <class Array, class F, class = decltype(std::declval<Array>().size())>
void forEachScalar(Array& array, F scalar) {
  for (decltype(array.size()) i = 0; i < array.size(); ++i) scalar(array[i]);
}

/// Returns the size of one element of an array in the file, in bytes.
template <class Element>
std::size_t bytesInFile() {
  std::size_t bytes = 0;
  const Element element{};
  forEachScalar(element, [&](const auto& scalar) { bytes += sizeof scalar; });
  return bytes;
}

/// Reads `size` bytes and never beyond. After the first problem it reads nothing more. Enumerations need a
/// function lastOf(), which returns their highest value.
class ByteReader {
 public:
  ByteReader(const std::uint8_t* bytes, std::size_t size) : next_(bytes), left_(size) {}

  /// Describes the first problem; empty if there is none.
  const std::string& problem() const { return problem_; }
  std::size_t bytesLeft() const { return left_; }

  template <class T>
  void value(const char* name, T& value) {
    if (!hasBytes(name, 1, sizeof(T))) return;
    if (!readNumber(value)) problem_ = "the " + std::string(name) + outOfRange(value);
  }

  void count(const char* name, std::size_t& count) {
    if (!hasBytes(name, 1, 8)) return;
    std::uint64_t number = 0;
    readNumber(number);
    if (number > std::numeric_limits<std::size_t>::max())
      problem_ = "more " + std::string(name) + " than fit this machine";
    else
      count = static_cast<std::size_t>(number);
  }

  /// Resizes `elements` to a count, unless fewer than `bytesEach` bytes are left for each.
  template <class Array>
  void resize(const char* name, Array& elements, std::size_t bytesEach) {
    std::size_t size = 0;
    count(name, size);
    elements.clear();
    if (hasBytes(name, size, bytesEach)) elements.resize(size);
  }

  template <class Array>
  void array(const char* name, Array& elements) {
    resize(name, elements, bytesInFile<typename Array::value_type>());
    for (std::size_t i = 0; i < elements.size() && problem_.empty(); ++i) {
      forEachScalar(elements[i], [&](auto& scalar) {
        if (!readNumber(scalar))
          problem_ = "element " + std::to_string(i) + " of the " + name + outOfRange(scalar);
      });
    }
  }

 private:
  /// Checks, before memory is allocated, that the remaining bytes can hold `count` elements.
  bool hasBytes(const char* name, std::size_t count, std::size_t bytesEach) {
    if (!problem_.empty()) return false;
    if (count <= left_ / bytesEach) return true;
    problem_ = "the bytes end before its " + std::to_string(count) + " " + name;
    return false;
  }

  /// Returns false if the value is not in its enumeration.
  template <class T>
  bool readNumber(T& value) {
    value = fromBits<T>(readLittleEndian<Bits<T>>(next_));
    next_ += sizeof(T);
    left_ -= sizeof(T);
    if constexpr (std::is_enum_v<T>) return value <= lastOf(T{});
    return true;
  }

  template <class T>
  static std::string outOfRange(const T& value) {
    return " has the unknown kind " + std::to_string(+toBits(value));
  }

  const std::uint8_t* next_;
  std::size_t left_;
  std::string problem_;
};

/// Appends to `bytes` what ByteReader reads: value() for a number, count() for a std::size_t (always 8
/// bytes), resize() for the size of an array, and array() for its size and its elements.
class ByteWriter {
 public:
  explicit ByteWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  template <class T>
  void value(const char*, const T& value) {
    writeLittleEndian(toBits(value), grow(sizeof(T)));
  }

  void count(const char*, std::size_t count) { writeLittleEndian(std::uint64_t{count}, grow(8)); }

  template <class Array>
  void resize(const char* name, const Array& elements, std::size_t) {
    count(name, elements.size());
  }

  template <class Array>
  void array(const char* name, const Array& elements) {
    using T = typename Array::value_type;
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

// --- headers -----------------------------------------------------------------------------------------------

/// A kind of file or saved state. Its header has the magic number, the version (4 bytes), then the size and
/// the hash of the rest (8 bytes each).
struct SealedFormat {
  std::array<std::uint8_t, 8> magic;
  const char* name;          ///< "a .limber file"
  const char* container;     ///< "the file"
  std::uint32_t version;     ///< the newest
  std::uint32_t oldest = 1;  ///< that can be read, and all from it on
};

constexpr std::size_t kHeaderBytes = 28;

/// Computes a 64-bit hash against accidental damage, not against malice. It detects every change within one
/// of the 8-byte words that it reads, and any other change except for one in 2^64. It is the same on every
/// machine.
std::uint64_t hashPayload(const std::uint8_t* bytes, std::size_t size);

/// Writes the header over the first kHeaderBytes.
void seal(const SealedFormat& format, std::uint32_t version, std::vector<std::uint8_t>& bytes);

/// Returns why the header is not valid, or an empty string. Does not check the hash. `header` has the first
/// kHeaderBytes of `fileSize` bytes, or all if there are fewer.
std::string checkHeader(const SealedFormat& format, const std::uint8_t* header, std::uint64_t fileSize);

/// Returns why the bytes are not valid, or an empty string. Also checks the hash.
std::string checkSealed(const SealedFormat& format, const std::uint8_t* bytes, std::size_t size);

/// Returns sealed bytes of a version, 0: the newest. write(ByteWriter&) appends the contents.
template <class Write>
std::vector<std::uint8_t> sealedBytes(const SealedFormat& format, const Write& write,
                                      std::uint32_t version = 0) {
  std::vector<std::uint8_t> bytes;
  bytes.resize(kHeaderBytes);
  ByteWriter writer(bytes);
  write(writer);
  seal(format, version > 0 ? version : format.version, bytes);
  return bytes;
}

/// Return the version, and the size of header and contents, that a header states.
std::uint32_t versionOf(const std::uint8_t* header);
std::size_t sealedSize(const std::uint8_t* header);

/// Reads what transfer(ByteReader&, State&) declares from sealed bytes. Returns why it cannot, or an empty
/// string.
template <class State, class Transfer>
std::string readSealed(const SealedFormat& format, const std::uint8_t* bytes, std::size_t size, State& state,
                       Transfer transfer) {
  if (std::string reason = checkSealed(format, bytes, size); !reason.empty()) return reason;
  ByteReader reader(bytes + kHeaderBytes, size - kHeaderBytes);
  transfer(reader, state);
  if (!reader.problem().empty() || reader.bytesLeft() == 0) return reader.problem();
  return std::to_string(reader.bytesLeft()) + " bytes follow the end of its contents";
}

// --- files -------------------------------------------------------------------------------------------------

/// Reads all bytes of a file. Its header must pass checkHeader() before the rest is read, so that no large
/// foreign file is read. Errors name the file: it cannot be read, or it is not of this format.
Result<std::vector<std::uint8_t>> readWholeFile(const SealedFormat& format, const std::string& file);

/// Writes a temporary file in the same folder and renames it to `file`, so that always either the old or the
/// new file is complete. Errors name the file; the temporary file is removed then.
Result<void> writeWholeFile(const std::string& file, const std::vector<std::uint8_t>& bytes);

}  // namespace limber

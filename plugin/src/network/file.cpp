// SPDX-License-Identifier: Zlib
// Writes networks to .limber files and reads them. All numbers are little-endian, a hash detects damage, and
// the reader checks every value before use.

#include <limber/spring_network.h>

#include "network/file.h"

#include <limber/result.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

namespace limber {
namespace {

// The contents of a `.limber` file of version 1 after its header, declared once for the writer and the
// reader. A Stream has value() for a number, count() for a std::size_t (always 8 bytes) and array() for a
// count and that many elements. A change of the layout needs a new version.

/// Calls scalar(x) for every number in an element of an array, in the order of the file.
template <class Element, class F>
void forEachScalar(Element& element, F scalar) {
  using T = std::remove_const_t<Element>;
  if constexpr (std::is_arithmetic_v<T>) {
    scalar(element);
  } else if constexpr (std::is_same_v<T, NetworkSpring>) {
    scalar(element.a);
    scalar(element.b);
    scalar(element.kind);
    scalar(element.stiffnessScale);
  } else {  // std::array or a vector of Eigen's
    for (decltype(element.size()) i = 0; i < element.size(); ++i) scalar(element[i]);
  }
}

template <class Stream, class Report>
void transferReport(Stream& stream, Report& report) {
  stream.count("vertices", report.vertices);
  stream.count("points", report.points);
  stream.count("triangles", report.triangles);
  stream.count("degenerate triangles", report.degenerateTriangles);
  stream.count("duplicate triangles", report.duplicateTriangles);
  stream.count("isolated vertices", report.isolatedVertices);
  stream.count("components", report.components);
  stream.count("open edges", report.openEdges);
  stream.count("non-manifold edges", report.nonManifoldEdges);
  stream.count("inconsistent edges", report.inconsistentEdges);
}

template <class Stream, class Network>
void transferNetwork(Stream& stream, Network& network) {
  stream.value("network kind", network.kind);
  stream.value("stiffness per modulus", network.stiffnessPerModulus);
  transferReport(stream, network.report);
  stream.array("rest points", network.restPoints);
  stream.array("mass fractions", network.massFractions);
  stream.array("springs", network.springs);
  stream.array("surface triangles", network.surface);
  stream.array("tetrahedra", network.tetrahedra);
  stream.array("skin offsets", network.render.skin.firstWeight);
  stream.array("skin points", network.render.skin.points);
  stream.array("skin weights", network.render.skin.weights);
  stream.array("render vertices", network.render.vertexToPoint);
  stream.array("texture coordinates", network.render.uvs);
  stream.array("render triangles", network.render.triangles);
}

// Numbers in a `.limber` file are little-endian; enumerations take one byte.

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

/// Returns the size of one element of an array in the file, in bytes.
template <class Element>
std::size_t bytesInFile() {
  std::size_t bytes = 0;
  const Element element{};
  forEachScalar(element, [&](const auto& scalar) { bytes += sizeof scalar; });
  return bytes;
}

/// Returns the highest value of an enumeration.
constexpr NetworkKind lastOf(NetworkKind) { return NetworkKind::Solid; }
constexpr SpringKind lastOf(SpringKind) { return SpringKind::Brace; }

/// The Stream of transferNetwork() that reads `size` bytes and never beyond. After the first problem it reads
/// nothing more.
class NetworkReader {
 public:
  NetworkReader(const std::uint8_t* bytes, std::size_t size) : next_(bytes), left_(size) {}

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

  template <class T>
  void array(const char* name, std::vector<T>& elements) {
    std::size_t size = 0;
    count(name, size);
    if (!hasBytes(name, size, bytesInFile<T>())) return;
    elements.resize(size);
    for (std::size_t i = 0; i < size && problem_.empty(); ++i) {
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

/// The Stream of transferNetwork() that appends to `bytes`.
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

// FNV-1a's offset basis (Fowler, Noll, Vo), and an odd factor with many bits set (that of splitmix64)
constexpr std::uint64_t kBasis = 0xcbf29ce484222325u;
constexpr std::uint64_t kFactor = 0xbf58476d1ce4e5b9u;

// FNV-1a over words instead of bytes, eight times as fast. Both steps are invertible (the factor is odd). So
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

namespace {

// The header: 8 bytes that begin every .limber file (like PNG's: not text, and damaged by a transfer as
// text), the version (4 bytes), then the size and the hash of the rest (8 bytes each).
constexpr std::array<std::uint8_t, 8> kMagic = {0x89, 'L', 'I', 'M', 'B', 'R', '\r', '\n'};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kVersionAt = 8, kSizeAt = 12, kHashAt = 20, kHeaderBytes = 28;

std::string checkSize(std::uint64_t expected, std::uint64_t actual) {
  if (expected == actual) return {};
  const std::string contents = std::to_string(expected) + " bytes after its header";
  if (expected > actual) return "the file is too short: of " + contents + " it has " + std::to_string(actual);
  return "the file is too long: " + std::to_string(actual - expected) + " bytes follow the " + contents;
}

/// Checks all except the hash. `header` holds the first kHeaderBytes of `fileSize` bytes, or all if there are
/// fewer.
std::string checkHeader(const std::uint8_t* header, std::uint64_t fileSize) {
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(fileSize, kHeaderBytes));
  const std::size_t start = std::min(size, kMagic.size());
  if (size == 0) return "not a .limber file: it is empty";
  if (!std::equal(header, header + start, kMagic.begin()))
    return "not a .limber file: it does not begin with the bytes of one";
  if (size < kHeaderBytes) return "the file is too short: it ends within its header";
  const auto version = readLittleEndian<std::uint32_t>(header + kVersionAt);
  if (version != kVersion) {
    return "a .limber file of version " + std::to_string(version) + ", this library reads version " +
           std::to_string(kVersion);
  }
  return checkSize(readLittleEndian<std::uint64_t>(header + kSizeAt), fileSize - kHeaderBytes);
}

namespace fs = std::filesystem;

constexpr int kMaxNames = 1000;  // of temporary files that other writers use, or that were left over

struct Close {
  void operator()(std::FILE* stream) const { std::fclose(stream); }
};
using Stream = std::unique_ptr<std::FILE, Close>;

std::string errorMessage(const char* what, const std::string& file, const std::string& reason) {
  return std::string(what) + " " + file + ": " + reason;
}

bool readMore(std::FILE* stream, std::vector<std::uint8_t>& bytes, std::size_t count) {
  const std::size_t before = bytes.size();
  bytes.resize(before + count);
  return std::fread(bytes.data() + before, 1, count, stream) == count;
}

/// Creates a file `<file>.<number>.part`. Mode "x": fails if the name exists.
Stream createPartFile(const std::string& file, std::string& name) {
  for (int i = 0; i < kMaxNames; ++i) {
    name = file + "." + std::to_string(i) + ".part";
    Stream stream(std::fopen(name.c_str(), "wbx"));
    if (stream || errno != EEXIST) return stream;
  }
  return nullptr;
}

bool writeAndClose(Stream stream, const std::vector<std::uint8_t>& bytes) {
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), stream.get()) == bytes.size();
  return std::fclose(stream.release()) == 0 && written;
}

/// Reads all bytes of a file. Its header must pass checkHeader() before the rest is read, so that no large
/// foreign file is read. Errors name the file: it cannot be read, or it is not a .limber file.
Result<std::vector<std::uint8_t>> readWholeFile(const std::string& file) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(file, error);
  if (error) return Error{errorMessage("cannot read", file, error.message())};
  const Stream stream(std::fopen(file.c_str(), "rb"));
  if (!stream) return Error{errorMessage("cannot read", file, std::strerror(errno))};
  const std::size_t first = static_cast<std::size_t>(std::min<std::uint64_t>(size, kHeaderBytes));
  std::vector<std::uint8_t> bytes;
  if (!readMore(stream.get(), bytes, first))
    return Error{errorMessage("cannot read", file, std::strerror(errno))};
  const std::string reason = checkHeader(bytes.data(), size);
  if (!reason.empty()) return Error{file + ": " + reason};
  if (!readMore(stream.get(), bytes, static_cast<std::size_t>(size) - first)) {
    return Error{errorMessage("cannot read", file, "it ended while it was read")};
  }
  return bytes;
}

/// Writes a temporary file in the same folder and renames it to `file`, so that always either the old or the
/// new file is complete. Returns an empty string, or the reason with the file's name; the temporary file is
/// removed then.
std::string writeWholeFile(const std::string& file, const std::vector<std::uint8_t>& bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  // renaming would replace a device by a plain file
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    return errorMessage("cannot write", file, "it is not a regular file");
  }
  std::string part;
  Stream stream = createPartFile(file, part);
  if (!stream) return errorMessage("cannot write", file, std::strerror(errno));
  errno = 0;
  if (!writeAndClose(std::move(stream), bytes)) {
    error = std::error_code(errno != 0 ? errno : EIO, std::generic_category());
  } else {
    error.clear();
    fs::rename(part, file, error);
  }
  if (!error) return {};
  std::error_code ignored;
  fs::remove(part, ignored);
  return errorMessage("cannot write", file, error.message());
}

std::string checkHash(const std::uint8_t* bytes, std::size_t size) {
  const auto expected = readLittleEndian<std::uint64_t>(bytes + kHashAt);
  const std::uint64_t actual = hashPayload(bytes + kHeaderBytes, size - kHeaderBytes);
  return expected == actual ? std::string() : "the file is damaged: its hash is not that of its contents";
}

std::string readContents(const std::uint8_t* bytes, std::size_t size, SpringNetwork& network) {
  NetworkReader reader(bytes, size);
  transferNetwork(reader, network);
  if (!reader.problem().empty()) return reader.problem();
  if (reader.bytesLeft() > 0)
    return std::to_string(reader.bytesLeft()) + " bytes follow the end of its contents";
  return validate(network).error();
}

}  // namespace

std::vector<std::uint8_t> toBytes(const SpringNetwork& network) {
  std::vector<std::uint8_t> bytes(kMagic.begin(), kMagic.end());
  bytes.resize(kHeaderBytes);
  NetworkWriter writer(bytes);
  transferNetwork(writer, network);
  const std::size_t size = bytes.size() - kHeaderBytes;
  writeLittleEndian(kVersion, bytes.data() + kVersionAt);
  writeLittleEndian(std::uint64_t{size}, bytes.data() + kSizeAt);
  writeLittleEndian(hashPayload(bytes.data() + kHeaderBytes, size), bytes.data() + kHashAt);
  return bytes;
}

Result<SharedNetwork> fromBytes(const std::uint8_t* bytes, std::size_t size) {
  std::string reason = checkHeader(bytes, size);
  if (reason.empty()) reason = checkHash(bytes, size);
  auto network = std::make_shared<SpringNetwork>();
  if (reason.empty()) reason = readContents(bytes + kHeaderBytes, size - kHeaderBytes, *network);
  if (!reason.empty()) return Error{std::move(reason)};
  return SharedNetwork(std::move(network));
}

Result<void> saveNetwork(const SpringNetwork& network, const std::string& file) {
  if (Result<void> valid = validate(network); !valid) return Error{file + ": " + valid.error()};
  std::string reason = writeWholeFile(file, toBytes(network));
  return reason.empty() ? Result<void>() : Error{std::move(reason)};
}

Result<SharedNetwork> loadNetwork(const std::string& file) {
  const Result<std::vector<std::uint8_t>> bytes = readWholeFile(file);
  if (!bytes) return Error{bytes.error()};
  Result<SharedNetwork> network = fromBytes(bytes->data(), bytes->size());
  return network ? network : Error{file + ": " + network.error()};
}

}  // namespace limber

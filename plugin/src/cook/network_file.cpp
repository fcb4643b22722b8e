// SPDX-License-Identifier: Zlib
#include <limber/network_file.h>

#include "cook/network_reader.h"
#include "cook/network_writer.h"
#include "cook/payload_hash.h"
#include "cook/whole_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

namespace limber {
namespace {

// The header: 8 bytes that begin every .limber file (as PNG's: no text, and spoilt by a transfer as text),
// the version (4 bytes), then size and hash of the rest (8 bytes each).
constexpr std::array<std::uint8_t, 8> kMagic = {0x89, 'L', 'I', 'M', 'B', 'R', '\r', '\n'};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kVersionAt = 8, kSizeAt = 12, kHashAt = 20, kHeaderBytes = 28;

std::string checkSize(std::uint64_t promised, std::uint64_t present) {
  if (promised == present) return {};
  const std::string contents = std::to_string(promised) + " bytes after its header";
  if (promised > present) return "cut short: of " + contents + " there are " + std::to_string(present);
  return "longer than it says: " + std::to_string(present - promised) + " bytes follow the " + contents;
}

/// Everything but the hash. `header` holds the first bytes of `fileSize`, kHeaderBytes if there are as many.
std::string checkHeader(const std::uint8_t* header, std::uint64_t fileSize) {
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(fileSize, kHeaderBytes));
  const std::size_t start = std::min(size, kMagic.size());
  if (size == 0) return "no .limber file: it is empty";
  if (!std::equal(header, header + start, kMagic.begin())) return "no .limber file: it begins otherwise";
  if (size < kHeaderBytes) return "cut short: it ends within its header";
  const auto version = readLittleEndian<std::uint32_t>(header + kVersionAt);
  if (version != kVersion) {
    return "a .limber file of version " + std::to_string(version) + ", this library reads version " +
           std::to_string(kVersion);
  }
  return checkSize(readLittleEndian<std::uint64_t>(header + kSizeAt), fileSize - kHeaderBytes);
}

std::string checkHash(const std::uint8_t* bytes, std::size_t size) {
  const auto promised = readLittleEndian<std::uint64_t>(bytes + kHashAt);
  const std::uint64_t present = hashPayload(bytes + kHeaderBytes, size - kHeaderBytes);
  return promised == present ? std::string() : "damaged: its hash is not that of its contents";
}

std::string readContents(const std::uint8_t* bytes, std::size_t size, SpringNetwork& network) {
  NetworkReader reader(bytes, size);
  transferNetwork(reader, network);
  if (!reader.problem().empty()) return reader.problem();
  if (reader.bytesLeft() > 0) return std::to_string(reader.bytesLeft()) + " bytes are left over at the end";
  return validate(network);
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

std::string saveNetwork(const SpringNetwork& network, const std::string& file) {
  if (std::string reason = validate(network); !reason.empty()) return file + ": " + reason;
  return writeWholeFile(file, toBytes(network));
}

Result<SharedNetwork> loadNetwork(const std::string& file) {
  const Result<std::vector<std::uint8_t>> bytes = readWholeFile(file, kHeaderBytes, checkHeader);
  if (!bytes) return Error{bytes.error()};
  Result<SharedNetwork> network = fromBytes(bytes->data(), bytes->size());
  return network ? network : Error{file + ": " + network.error()};
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
// Seals bytes with a header and a hash, checks them, and reads and writes whole files.
#include "mesh/bytes.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

namespace limber {
namespace {

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

// --- headers -----------------------------------------------------------------------------------------------

namespace {

constexpr std::size_t kVersionAt = 8, kSizeAt = 12, kHashAt = 20;

std::string checkSize(const std::string& container, std::uint64_t expected, std::uint64_t actual) {
  if (expected == actual) return {};
  const std::string contents = std::to_string(expected) + " bytes after its header";
  if (expected > actual)
    return container + " is too short: of " + contents + " it has " + std::to_string(actual);
  return container + " is too long: " + std::to_string(actual - expected) + " bytes follow the " + contents;
}

}  // namespace

void seal(const SealedFormat& format, std::uint32_t version, std::vector<std::uint8_t>& bytes) {
  const std::size_t size = bytes.size() - kHeaderBytes;
  std::copy(format.magic.begin(), format.magic.end(), bytes.begin());
  writeLittleEndian(version, bytes.data() + kVersionAt);
  writeLittleEndian(std::uint64_t{size}, bytes.data() + kSizeAt);
  writeLittleEndian(hashPayload(bytes.data() + kHeaderBytes, size), bytes.data() + kHashAt);
}

std::uint32_t versionOf(const std::uint8_t* header) {
  return readLittleEndian<std::uint32_t>(header + kVersionAt);
}

std::size_t sealedSize(const std::uint8_t* header) {
  return kHeaderBytes + static_cast<std::size_t>(readLittleEndian<std::uint64_t>(header + kSizeAt));
}

std::string checkHeader(const SealedFormat& format, const std::uint8_t* header, std::uint64_t fileSize) {
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(fileSize, kHeaderBytes));
  const std::size_t start = std::min(size, format.magic.size());
  const std::string name = format.name, container = format.container;
  if (size == 0) return "not " + name + ": it is empty";
  if (!std::equal(header, header + start, format.magic.begin()))
    return "not " + name + ": it does not begin with the bytes of one";
  if (size < kHeaderBytes) return container + " is too short: it ends within its header";
  if (const std::uint32_t version = versionOf(header); version < format.oldest || version > format.version)
    return name + " of version " + std::to_string(version) + ", this library reads " +
           (format.version > format.oldest ? "versions " + std::to_string(format.oldest) + " to "
                                           : "version ") +
           std::to_string(format.version);
  return checkSize(container, readLittleEndian<std::uint64_t>(header + kSizeAt), fileSize - kHeaderBytes);
}

std::string checkSealed(const SealedFormat& format, const std::uint8_t* bytes, std::size_t size) {
  if (std::string reason = checkHeader(format, bytes, size); !reason.empty()) return reason;
  const auto expected = readLittleEndian<std::uint64_t>(bytes + kHashAt);
  if (expected == hashPayload(bytes + kHeaderBytes, size - kHeaderBytes)) return {};
  return std::string(format.container) + " is damaged: its hash is not that of its contents";
}

// --- files -------------------------------------------------------------------------------------------------

namespace {

namespace fs = std::filesystem;

constexpr int kMaxNames = 1000;  // of temporary files that other writers use, or that were left over

struct Close {
  void operator()(std::FILE* stream) const { std::fclose(stream); }
};
using Stream = std::unique_ptr<std::FILE, Close>;

Error fileError(const char* what, const std::string& file, const std::string& reason) {
  return {std::string(what) + " " + file + ": " + reason};
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

}  // namespace

Result<std::vector<std::uint8_t>> readWholeFile(const SealedFormat& format, const std::string& file) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(file, error);
  if (error) return fileError("cannot read", file, error.message());
  const Stream stream(std::fopen(file.c_str(), "rb"));
  if (!stream) return fileError("cannot read", file, std::strerror(errno));
  const std::size_t first = static_cast<std::size_t>(std::min<std::uint64_t>(size, kHeaderBytes));
  std::vector<std::uint8_t> bytes;
  if (!readMore(stream.get(), bytes, first)) return fileError("cannot read", file, std::strerror(errno));
  const std::string reason = checkHeader(format, bytes.data(), size);
  if (!reason.empty()) return Error{file + ": " + reason};
  if (!readMore(stream.get(), bytes, static_cast<std::size_t>(size) - first))
    return fileError("cannot read", file, "it ended while it was read");
  return bytes;
}

Result<void> writeWholeFile(const std::string& file, const std::vector<std::uint8_t>& bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  // renaming would replace a device by a plain file
  if (fs::exists(status) && !fs::is_regular_file(status))
    return fileError("cannot write", file, "it is not a regular file");
  std::string part;
  Stream stream = createPartFile(file, part);
  if (!stream) return fileError("cannot write", file, std::strerror(errno));
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
  return fileError("cannot write", file, error.message());
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "cook/whole_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

namespace limber {
namespace {

namespace fs = std::filesystem;

constexpr int kMostNames = 1000;  // of temporary files that others write at the same time, or have left

struct Close {
  void operator()(std::FILE* stream) const { std::fclose(stream); }
};
using Stream = std::unique_ptr<std::FILE, Close>;

std::string because(const char* what, const std::string& file, const std::string& reason) {
  return std::string(what) + " " + file + ": " + reason;
}

bool readMore(std::FILE* stream, std::vector<std::uint8_t>& bytes, std::size_t count) {
  const std::size_t before = bytes.size();
  bytes.resize(before + count);
  return std::fread(bytes.data() + before, 1, count, stream) == count;
}

/// A new file `<file>.<number>.part`; "x": only if there is none of this name.
Stream openBeside(const std::string& file, std::string& name) {
  for (int i = 0; i < kMostNames; ++i) {
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

Result<std::vector<std::uint8_t>> readWholeFile(const std::string& file, std::size_t headerBytes,
                                                HeaderCheck check) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(file, error);
  if (error) return Error{because("cannot read", file, error.message())};
  const Stream stream(std::fopen(file.c_str(), "rb"));
  if (!stream) return Error{because("cannot read", file, std::strerror(errno))};
  const std::size_t first = static_cast<std::size_t>(std::min<std::uint64_t>(size, headerBytes));
  std::vector<std::uint8_t> bytes;
  if (!readMore(stream.get(), bytes, first)) return Error{because("cannot read", file, std::strerror(errno))};
  const std::string reason = check(bytes.data(), size);
  if (!reason.empty()) return Error{file + ": " + reason};
  if (!readMore(stream.get(), bytes, static_cast<std::size_t>(size) - first)) {
    return Error{because("cannot read", file, "it ended while it was read")};
  }
  return bytes;
}

std::string writeWholeFile(const std::string& file, const std::vector<std::uint8_t>& bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  // renaming would put a plain file in the place of a device
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    return because("cannot write", file, "it is no regular file");
  }
  std::string part;
  Stream stream = openBeside(file, part);
  if (!stream) return because("cannot write", file, std::strerror(errno));
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
  return because("cannot write", file, error.message());
}

}  // namespace limber

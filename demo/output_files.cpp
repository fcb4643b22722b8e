// SPDX-License-Identifier: Zlib
#include "output_files.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace limber::demo {
namespace {

namespace fs = std::filesystem;

std::string cannotWrite(const std::string& file, const std::string& reason) {
  return "cannot write " + file + ": " + reason;
}

/// A terminal, a pipe or the like: written into, not replaced.
bool isSpecial(const std::string& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  return fs::exists(status) && !fs::is_regular_file(status);
}

/// 0 or the error's number.
int writeAll(const std::string& file, const std::string& text) {
  std::FILE* stream = std::fopen(file.c_str(), "wb");
  if (!stream) return errno;
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
  const bool closed = std::fclose(stream) == 0;
  return written && closed ? 0 : (errno != 0 ? errno : EIO);
}

}  // namespace

std::string checkPlace(const std::string& file) {
  std::error_code error;
  if (fs::is_directory(file, error)) return cannotWrite(file, "it is a folder");
  if (isSpecial(file))
    return access(file.c_str(), W_OK) == 0 ? std::string() : cannotWrite(file, std::strerror(errno));
  const fs::path parent = fs::path(file).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  if (!fs::is_directory(folder, error)) return cannotWrite(file, "there is no folder " + folder);
  return access(folder.c_str(), W_OK | X_OK) == 0 ? std::string() : cannotWrite(file, std::strerror(errno));
}

std::string writeText(const std::string& file, const std::string& text) {
  std::error_code error;
  const bool special = isSpecial(file);
  const std::string part = special ? file : file + ".part" + std::to_string(getpid());
  if (const int failure = writeAll(part, text))
    error = std::error_code(failure, std::generic_category());
  else
    error.clear();
  if (!error && !special) fs::rename(part, file, error);
  if (!error) return {};
  std::error_code ignored;
  if (!special) fs::remove(part, ignored);
  return cannotWrite(file, error.message());
}

}  // namespace limber::demo

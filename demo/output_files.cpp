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

/// True for a terminal, a pipe and similar: these are written to, not replaced.
bool isSpecial(const std::string& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  return fs::exists(status) && !fs::is_regular_file(status);
}

/// Returns 0 or the error number.
int writeAll(const std::string& file, const std::string& text) {
  std::FILE* stream = std::fopen(file.c_str(), "wb");
  if (!stream) return errno;
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
  const bool closed = std::fclose(stream) == 0;
  return written && closed ? 0 : (errno != 0 ? errno : EIO);
}

}  // namespace

std::string checkWritable(const std::string& file) {
  std::error_code error;
  if (fs::is_directory(file, error)) return cannotWrite(file, "it is a folder");
  if (isSpecial(file))
    return access(file.c_str(), W_OK) == 0 ? std::string() : cannotWrite(file, std::strerror(errno));
  const fs::path parent = fs::path(file).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  if (!fs::is_directory(folder, error)) return cannotWrite(file, "there is no folder " + folder);
  return access(folder.c_str(), W_OK | X_OK) == 0 ? std::string() : cannotWrite(file, std::strerror(errno));
}

std::string writeText(const std::string& path, const std::string& text) {
  std::error_code error;
  const bool special = isSpecial(path);
  std::string file = path;
  if (!special && fs::is_symlink(path, error)) file = fs::weakly_canonical(path, error).string();
  if (file.empty()) return cannotWrite(path, error.message());
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

namespace {

bool isOurs(const std::string& name) {
  if (name == kContactSheetName || name == kPreviewName || name == kVideoName) return true;
  const std::string head = "frame-", tail = ".png";
  if (name.size() < head.size() + 4 + tail.size()) return false;
  if (name.compare(0, head.size(), head) != 0) return false;
  if (name.compare(name.size() - tail.size(), tail.size(), tail) != 0) return false;
  const std::string digits = name.substr(head.size(), name.size() - head.size() - tail.size());
  return digits.find_first_not_of("0123456789") == std::string::npos;
}

std::error_code removeOldPictures(const std::string& folder) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    if (isOurs(entry->path().filename().string()) && entry->is_regular_file(ignored))
      fs::remove(entry->path(), ignored);
  }
  return error;
}

}  // namespace

std::string hashText(std::uint64_t hash) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

std::string frameName(std::int64_t i) {
  char name[40];
  std::snprintf(name, sizeof name, "frame-%04lld.png", static_cast<long long>(i));
  return name;
}

std::string prepareFolder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) error = removeOldPictures(folder);
  if (error) return "cannot use the folder " + folder + ": " + error.message();
  std::string reason = checkWritable(folder + "/" + kContactSheetName);
  if (reason.empty()) reason = checkWritable(folder + "/" + kPreviewName);
  return reason;
}

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#include "folders.h"

#include "output_files.h"

#include <cstdio>
#include <filesystem>
#include <system_error>

namespace limber::demo {
namespace {

namespace fs = std::filesystem;

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
  std::string reason = checkPlace(folder + "/" + kContactSheetName);
  if (reason.empty()) reason = checkPlace(folder + "/" + kPreviewName);
  return reason;
}

}  // namespace limber::demo

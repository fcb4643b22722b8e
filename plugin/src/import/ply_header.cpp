// SPDX-License-Identifier: Zlib
#include "import/ply_header.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace limber {
namespace {

bool isPly(const std::string& firstLine) {
  const std::string magic = firstLine.substr(0, 3);
  return magic == "ply" || magic == "PLY";
}

/// The first word of a line; empty for a line without words.
std::string firstWord(const std::string& line) {
  std::istringstream words(line);
  std::string word;
  words >> word;
  return word;
}

/// "element vertex 812": each element takes a byte at least.
std::string checkElement(const std::string& line, std::uintmax_t fileSize) {
  std::istringstream words(line);
  std::string keyword, element;
  std::uintmax_t count = 0;
  words >> keyword >> element >> count;
  if (!words) return "the PLY header has no count in '" + line + "'";
  if (count <= fileSize) return {};
  return "the PLY header announces " + std::to_string(count) + " elements '" + element + "' in a file of " +
         std::to_string(fileSize) + " bytes";
}

}  // namespace

std::string checkPlyHeader(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  std::getline(file, line);
  if (!isPly(line)) return {};
  const std::uintmax_t fileSize = std::filesystem::file_size(path);
  while (std::getline(file, line)) {
    const std::string word = firstWord(line);
    if (word == "end_header") return {};
    if (word != "element") continue;
    if (std::string reason = checkElement(line, fileSize); !reason.empty()) return reason;
  }
  return "the PLY header has no end";
}

}  // namespace limber

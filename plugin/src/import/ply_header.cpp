// SPDX-License-Identifier: Zlib
#include "import/ply_header.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

namespace limber {
namespace {

using Words = std::vector<std::string>;

struct ScalarType {
  const char* name;
  std::uintmax_t bytes;
  bool isInteger;
};

constexpr ScalarType kScalarTypes[] = {
    {"char", 1, true},  {"uchar", 1, true},  {"short", 2, true},    {"ushort", 2, true},
    {"int", 4, true},   {"uint", 4, true},   {"float", 4, false},   {"double", 8, false},
    {"int8", 1, true},  {"uint8", 1, true},  {"int16", 2, true},    {"uint16", 2, true},
    {"int32", 4, true}, {"uint32", 4, true}, {"float32", 4, false}, {"float64", 8, false}};

const ScalarType* findType(const std::string& name) {
  const auto found = std::find_if(std::begin(kScalarTypes), std::end(kScalarTypes),
                                  [&](const ScalarType& type) { return name == type.name; });
  return found == std::end(kScalarTypes) ? nullptr : found;
}

/// An element such as "element face 12" with its properties.
struct Element {
  std::string name;
  std::uintmax_t count = 0;
  std::uintmax_t properties = 0;
  std::uintmax_t bytes = 0;  // of one element in a binary file, if its lists are empty
  bool hasVertexIndices = false;
};

struct Header {
  bool isBinary = false;
  std::vector<Element> elements;
};

/// Returns a line of the file for a message: damaged files have characters that terminals obey.
std::string inQuotes(const std::string& line) {
  constexpr std::size_t kMaxLength = 60;
  std::string text = line.substr(0, kMaxLength);
  for (char& c : text)
    if (!std::isprint(static_cast<unsigned char>(c))) c = '?';
  return "'" + text + "'";
}

Words wordsOf(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

std::string addElement(const Words& words, std::uintmax_t fileSize, Header& header) {
  Element element;
  std::istringstream count(words.size() == 3 ? words[2] : std::string());
  if (!(count >> element.count)) return "has no count";
  element.name = words[1];
  if (element.count > fileSize)
    return "announces " + words[2] + " elements " + inQuotes(words[1]) + " in a file of " +
           std::to_string(fileSize) + " bytes";
  header.elements.push_back(std::move(element));
  return {};
}

/// Adds a property such as "property float x" or "property list uchar int vertex_indices".
std::string addProperty(const Words& words, Header& header) {
  const bool isList = words.size() == 5 && words[1] == "list";
  if (!isList && words.size() != 3) return "is not a property with a type and a name";
  const ScalarType* type = findType(words[words.size() - 2]);
  const ScalarType* stored = isList ? findType(words[2]) : type;  // the first value in the file
  if (!type || !stored || (isList && !stored->isInteger)) return "has an unknown type";
  if (header.elements.empty()) return "belongs to no element";
  Element& element = header.elements.back();
  element.properties += 1;
  element.bytes += stored->bytes;
  if (isList && (words.back() == "vertex_index" || words.back() == "vertex_indices"))
    element.hasVertexIndices = true;
  return {};
}

std::string setFormat(const Words& words, Header& header) {
  const std::string format = words.size() == 3 ? words[1] : std::string();
  header.isBinary = format == "binary_little_endian" || format == "binary_big_endian";
  return header.isBinary || format == "ascii" ? std::string() : "names an unknown format";
}

bool hasControlCharacters(const std::string& line) {
  return std::any_of(line.begin(), line.end(),
                     [](unsigned char c) { return c < ' ' && c != '\t' && c != '\r'; });
}

/// Returns what is wrong with a line after the first.
std::string addLine(const std::string& line, std::uintmax_t fileSize, Header& header) {
  const Words words = wordsOf(line);
  if (words.empty() || words[0] == "comment") return {};
  // assimp reads some of them as spaces and some as the end of the line
  if (hasControlCharacters(line)) return "has control characters";
  if (words[0] == "end_header") return words.size() == 1 ? "" : "has more than one word";
  if (words[0] == "format") return setFormat(words, header);
  if (words[0] == "element") return addElement(words, fileSize, header);
  if (words[0] == "property") return addProperty(words, header);
  return {};  // "obj_info", and comments without their word, which some programs write
}

/// `size`: bytes after the header. A value in a text takes a character and a space or line end.
std::string checkContents(const Header& header, std::uintmax_t size) {
  std::uintmax_t left = size;
  for (const Element& element : header.elements) {
    if (element.count > 0 && element.name == "face" && !element.hasVertexIndices)
      return "the PLY header has faces without a list vertex_indices";
    const std::uintmax_t each = header.isBinary ? element.bytes : 2 * element.properties;
    if (each > 0 && element.count > (left + 1) / each)
      return "the PLY header announces " + std::to_string(element.count) + " elements " +
             inQuotes(element.name) + ", for which the file is too short";
    left -= std::min(left, each * element.count);
  }
  return {};
}

/// Returns whether assimp reads a file with this first line as PLY.
bool isPly(const std::string& firstLine) {
  std::string magic = firstLine.substr(0, 3);
  for (char& c : magic) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return magic == "ply";
}

}  // namespace

std::string checkPlyHeader(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  std::getline(file, line);
  if (!isPly(line)) return {};
  const std::uintmax_t fileSize = std::filesystem::file_size(path);
  Header header;
  while (std::getline(file, line) && !file.eof()) {
    if (const std::string reason = addLine(line, fileSize, header); !reason.empty())
      return "the line " + inQuotes(line) + " of the PLY header " + reason;
    if (wordsOf(line) == Words{"end_header"})
      return checkContents(header, fileSize - static_cast<std::uintmax_t>(file.tellg()));
  }
  return "the PLY header has no end";
}

}  // namespace limber

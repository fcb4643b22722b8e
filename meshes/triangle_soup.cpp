// SPDX-License-Identifier: Zlib
#include "triangle_soup.h"

#include <cmath>
#include <cstdio>
#include <map>

namespace shapes {
namespace {

/// Lines of an OBJ file with their numbers, which count from 1.
struct NumberedLines {
  std::map<std::string, std::size_t> numbers;
  std::string text;
};

/// Adding 0 turns -0 into 0.
std::string rounded(double value, double step) {
  char text[32];
  std::snprintf(text, sizeof(text), " %.9g", std::round(value / step) * step + 0.0);
  return text;
}

std::string numberOf(const std::string& line, NumberedLines& lines) {
  const auto [entry, isNew] = lines.numbers.try_emplace(line, lines.numbers.size() + 1);
  if (isNew) lines.text += line + "\n";
  return std::to_string(entry->second);
}

std::string positionLine(const Eigen::Vector3d& p, const ObjFormat& format) {
  std::string line = "v";
  for (const double value : p) line += rounded(value * format.scale, format.step);
  return line;
}

std::string uvLine(const Eigen::Vector2d& uv, const ObjFormat& format) {
  return "vt" + rounded(uv.x(), format.step) + rounded(uv.y(), format.step);
}

}  // namespace

void addQuad(TriangleSoup& soup, const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
  soup.push_back({a, b, c});
  soup.push_back({a, c, d});
}

std::string toObjText(const TriangleSoup& soup, const std::string& name, const ObjFormat& format) {
  NumberedLines positions, uvs;
  std::string faces;
  for (const auto& triangle : soup) {
    faces += "f";
    for (const Corner& corner : triangle) {
      faces += " " + numberOf(positionLine(corner.position, format), positions);
      if (format.uvs) faces += "/" + numberOf(uvLine(corner.uv, format), uvs);
    }
    faces += "\n";
  }
  return "# " + name + ", made by generate_meshes\n" + positions.text + uvs.text + faces;
}

}  // namespace shapes

// SPDX-License-Identifier: Zlib
// Writes meshes and networks as OBJ and PLY text.
#include <limber/spring_network.h>

#include "mesh/bytes.h"
#include "mesh/surface.h"

#include <cctype>
#include <cstdio>
#include <string>
#include <vector>

namespace limber {
namespace {

/// Text of a file under construction.
class Text {
 public:
  /// Appends like printf, at most 200 characters.
  template <class... Values>
  void add(const char* format, Values... values) {
    char line[200];
    const int length = std::snprintf(line, sizeof line, format, values...);
    bytes_.insert(bytes_.end(), line, line + length);
  }
  void add(const char* text) {
    bytes_.insert(bytes_.end(), text, text + std::char_traits<char>::length(text));
  }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

enum class Format : std::uint8_t { Obj, Ply };

Result<Format> formatOf(const std::string& file) {
  std::string ending = file.substr(file.find_last_of('.') + 1);
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == "obj") return Format::Obj;
  if (ending == "ply") return Format::Ply;
  return Error{file + ": the name must end in .obj or .ply"};
}

Result<void> write(const std::string& file, const Text& text) {
  std::string reason = writeWholeFile(file, text.bytes());
  return reason.empty() ? Result<void>() : Error{std::move(reason)};
}

void addObj(const TriangleMesh& mesh, Text& text) {
  text.add("# Limber\n");
  for (const Eigen::Vector3d& p : mesh.positions) text.add("v %.9g %.9g %.9g\n", p.x(), p.y(), p.z());
  for (const Eigen::Vector2f& t : mesh.uvs) text.add("vt %.9g %.9g\n", double(t.x()), double(t.y()));
  for (const Eigen::Vector3f& n : mesh.normals)
    text.add("vn %.6g %.6g %.6g\n", double(n.x()), double(n.y()), double(n.z()));
  const bool uv = !mesh.uvs.empty(), normal = !mesh.normals.empty();
  for (const Triangle& triangle : mesh.triangles) {
    text.add("f");
    for (const std::uint32_t corner : triangle) {
      const unsigned i = corner + 1;
      if (uv && normal)
        text.add(" %u/%u/%u", i, i, i);
      else if (uv)
        text.add(" %u/%u", i, i);
      else if (normal)
        text.add(" %u//%u", i, i);
      else
        text.add(" %u", i);
    }
    text.add("\n");
  }
}

void addPly(const TriangleMesh& mesh, Text& text) {
  text.add("ply\nformat ascii 1.0\ncomment Limber\nelement vertex %zu\n", mesh.positions.size());
  text.add("property double x\nproperty double y\nproperty double z\n");
  if (!mesh.normals.empty()) text.add("property float nx\nproperty float ny\nproperty float nz\n");
  if (!mesh.uvs.empty()) text.add("property float s\nproperty float t\n");
  text.add("element face %zu\nproperty list uchar uint vertex_indices\nend_header\n", mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Eigen::Vector3d& p = mesh.positions[i];
    text.add("%.9g %.9g %.9g", p.x(), p.y(), p.z());
    if (!mesh.normals.empty()) {
      const Eigen::Vector3d n = mesh.normals[i].cast<double>();
      text.add(" %.6g %.6g %.6g", n.x(), n.y(), n.z());
    }
    if (!mesh.uvs.empty()) text.add(" %.9g %.9g", double(mesh.uvs[i].x()), double(mesh.uvs[i].y()));
    text.add("\n");
  }
  for (const Triangle& t : mesh.triangles) text.add("3 %u %u %u\n", t[0], t[1], t[2]);
}

}  // namespace

Result<void> saveMesh(const TriangleMesh& mesh, const std::string& file) {
  const Result<Format> format = formatOf(file);
  if (!format) return Error{format.error()};
  if (Result<void> valid = validate(mesh); !valid) return Error{file + ": " + valid.error()};
  Text text;
  (*format == Format::Obj ? addObj : addPly)(mesh, text);
  return write(file, text);
}

Result<void> saveSprings(const SpringNetwork& network, const std::vector<Eigen::Vector3d>& points,
                         const std::string& file) {
  const Result<Format> format = formatOf(file);
  if (!format) return Error{format.error()};
  if (points.size() != network.restPoints.size())
    return Error{file + ": " + std::to_string(points.size()) + " points for a network of " +
                 std::to_string(network.restPoints.size())};
  const bool ply = *format == Format::Ply;
  Text text;
  if (ply) {
    text.add("ply\nformat ascii 1.0\ncomment Limber\nelement vertex %zu\n", points.size());
    text.add("property double x\nproperty double y\nproperty double z\n");
    text.add("element edge %zu\nproperty uint vertex1\nproperty uint vertex2\n", network.springs.size());
    text.add("property uchar kind\nend_header\n");
  } else {
    text.add("# Limber\n");
  }
  for (const Eigen::Vector3d& p : points)
    text.add(ply ? "%.9g %.9g %.9g\n" : "v %.9g %.9g %.9g\n", p.x(), p.y(), p.z());
  for (const NetworkSpring& s : network.springs) {
    if (ply)
      text.add("%u %u %u\n", s.a, s.b, unsigned(s.kind));
    else
      text.add("l %u %u\n", s.a + 1, s.b + 1);
  }
  return write(file, text);
}

}  // namespace limber

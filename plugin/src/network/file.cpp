// SPDX-License-Identifier: Zlib
// Writes networks to .limber files and reads them: a hash detects damage, and the reader checks every value
// before use. Writes meshes and networks as OBJ and PLY text.

#include <limber/spring_network.h>

#include "mesh/bytes.h"
#include "mesh/surface.h"

#include <cctype>
#include <cstdio>
#include <type_traits>

namespace limber {

// what ByteReader and ByteWriter need to know of the network's types

template <class Spring, class F,
          std::enable_if_t<std::is_same_v<std::remove_const_t<Spring>, NetworkSpring>, int> = 0>
static void forEachScalar(Spring& spring, F scalar) {
  scalar(spring.a);
  scalar(spring.b);
  scalar(spring.kind);
  scalar(spring.stiffnessScale);
}

static constexpr NetworkKind lastOf(NetworkKind) { return NetworkKind::Solid; }
static constexpr SpringKind lastOf(SpringKind) { return SpringKind::Brace; }

namespace {

// The contents of a `.limber` file after its header, declared once for the writer and the reader. A change of
// the layout needs a new version. Version 2 also has groups, version 3 thickness and volume.

/// Begins every .limber file. Like PNG's: not text, and damaged by a transfer as text.
constexpr SealedFormat kFormat = {
    {0x89, 'L', 'I', 'M', 'B', 'R', '\r', '\n'}, "a .limber file", "the file", 3};

template <class Stream, class Report>
void transferReport(Stream& stream, Report& report) {
  stream.count("vertices", report.vertices);
  stream.count("points", report.points);
  stream.count("triangles", report.triangles);
  stream.count("degenerate triangles", report.degenerateTriangles);
  stream.count("duplicate triangles", report.duplicateTriangles);
  stream.count("isolated vertices", report.isolatedVertices);
  stream.count("components", report.components);
  stream.count("open edges", report.openEdges);
  stream.count("non-manifold edges", report.nonManifoldEdges);
  stream.count("inconsistent edges", report.inconsistentEdges);
}

template <class Stream, class Groups>
void transferGroups(Stream& stream, Groups& groups) {
  stream.resize("groups", groups, 3 * sizeof(std::uint64_t));
  for (auto& group : groups) {
    stream.array("letters of a group's name", group.name);
    stream.array("springs of a group", group.springs);
    stream.array("points of a group", group.points);
  }
}

template <class Stream, class Network>
void transferNetwork(Stream& stream, Network& network, std::uint32_t version) {
  stream.value("network kind", network.kind);
  stream.value("stiffness per modulus", network.stiffnessPerModulus);
  transferReport(stream, network.report);
  stream.array("rest points", network.restPoints);
  stream.array("mass fractions", network.massFractions);
  stream.array("springs", network.springs);
  stream.array("surface triangles", network.surface);
  stream.array("tetrahedra", network.tetrahedra);
  stream.array("skin offsets", network.render.skin.firstWeight);
  stream.array("skin points", network.render.skin.points);
  stream.array("skin weights", network.render.skin.weights);
  stream.array("render vertices", network.render.vertexToPoint);
  stream.array("texture coordinates", network.render.uvs);
  stream.array("render triangles", network.render.triangles);
  if (version > 1) transferGroups(stream, network.groups);
  if (version > 2) {
    stream.value("thickness", network.thickness);
    stream.value("volume", network.volume);
  }
}

/// Returns the first version that has all that the network has.
std::uint32_t versionFor(const SpringNetwork& network) {
  if (network.thickness != 0.0 || network.volume != 0.0) return 3;
  return network.groups.empty() ? 1 : 2;
}

}  // namespace

std::vector<std::uint8_t> toBytes(const SpringNetwork& network) {
  const std::uint32_t version = versionFor(network);
  return sealedBytes(
      kFormat, [&](ByteWriter& writer) { transferNetwork(writer, network, version); }, version);
}

Result<SharedNetwork> fromBytes(const std::uint8_t* bytes, std::size_t size) {
  auto network = std::make_shared<SpringNetwork>();
  std::string reason = readSealed(
      kFormat, bytes, size, *network,
      [&](ByteReader& reader, SpringNetwork& read) { transferNetwork(reader, read, versionOf(bytes)); });
  if (reason.empty()) reason = validate(*network).error();
  if (!reason.empty()) return Error{std::move(reason)};
  return SharedNetwork(std::move(network));
}

Result<void> saveNetwork(const SpringNetwork& network, const std::string& file) {
  if (Result<void> valid = validate(network); !valid) return Error{file + ": " + valid.error()};
  return writeWholeFile(file, toBytes(network));
}

Result<SharedNetwork> loadNetwork(const std::string& file) {
  const Result<std::vector<std::uint8_t>> bytes = readWholeFile(kFormat, file);
  if (!bytes) return Error{bytes.error()};
  Result<SharedNetwork> network = fromBytes(bytes->data(), bytes->size());
  return network ? network : Error{file + ": " + network.error()};
}

// --- OBJ and PLY -------------------------------------------------------------------------------------------

namespace {

/// Text of a file under construction.
class Text {
 public:
  /// Appends like printf, at most 200 characters.
  template <class... Values>
  void add(const char* format, Values... values) {
    char line[200];
    const int length = std::snprintf(line, sizeof line, format, values...);
    std::replace(line, line + length, ',', '.');  // of the program's locale; no format has a comma
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

void beginPly(std::size_t vertices, Text& text) {
  text.add("ply\nformat ascii 1.0\ncomment Limber\nelement vertex %zu\n", vertices);
  text.add("property double x\nproperty double y\nproperty double z\n");
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
  beginPly(mesh.positions.size(), text);
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
  return writeWholeFile(file, text.bytes());
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
    beginPly(points.size(), text);
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
  return writeWholeFile(file, text.bytes());
}

}  // namespace limber

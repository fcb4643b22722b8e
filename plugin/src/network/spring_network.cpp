// SPDX-License-Identifier: Zlib

// This file checks that a spring network satisfies the conditions of its members, and adds groups to it. It
// writes networks to .limber files and reads them: a hash detects damage, and the reader checks every value
// before use. It writes meshes and networks as OBJ and PLY text.

#include <limber/spring_network.h>

#include "mesh/bytes.h"
#include "mesh/surface.h"
#include "network/tetrahedra.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <type_traits>

namespace limber {
namespace {

/// Tolerance of the sum of the mass fractions: the rounding of a sum of millions.
constexpr double kFractionRounding = 1e-9;

/// Tolerance of the sum of the weights of a skinned point: the rounding of thousands of floats.
constexpr double kWeightRounding = 1e-4;

/// m, as for meshes: volumes and their squares are far from the limits of a double.
constexpr double kMaxCoordinate = 1e9;

std::string checkPoints(const std::vector<Eigen::Vector3d>& points) {
  if (points.empty()) return "the network has no points";
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) return numbered("point", i) + " is not finite";
    if (points[i].cwiseAbs().maxCoeff() > kMaxCoordinate)
      return numbered("point", i) + " has a coordinate beyond 1e9";
  }
  return {};
}

std::string checkMassFractions(const std::vector<double>& fractions, std::size_t points) {
  if (fractions.size() != points) {
    return std::to_string(fractions.size()) + " mass fractions for " + std::to_string(points) + " points";
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < fractions.size(); ++i) {
    if (!std::isfinite(fractions[i]) || fractions[i] <= 0.0)
      return numbered("mass fraction", i) + " is not above 0";
    sum += fractions[i];
  }
  if (std::abs(sum - 1.0) > kFractionRounding)
    return "the mass fractions sum to " + std::to_string(sum) + ", not to 1";
  return {};
}

std::string checkSpring(const NetworkSpring& spring, std::size_t points) {
  if (spring.a >= spring.b) return " does not go from a lower to a higher point";
  if (spring.b >= points) return " uses point " + std::to_string(spring.b) + " of " + std::to_string(points);
  if (spring.kind > SpringKind::Brace) return " has an unknown kind";
  if (!std::isfinite(spring.stiffnessScale) || spring.stiffnessScale <= 0.0) {
    return " has a stiffness scale that is not above 0";
  }
  return {};
}

std::string checkSprings(const std::vector<NetworkSpring>& springs, std::size_t points) {
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const std::string reason = checkSpring(springs[i], points);
    if (!reason.empty()) return numbered("spring", i) + reason;
    if (i == 0) continue;
    const Edge previous{springs[i - 1].a, springs[i - 1].b}, pair{springs[i].a, springs[i].b};
    if (pair == previous) return numbered("spring", i) + " joins the same points as the one before";
    if (pair < previous) return numbered("spring", i) + " is not in the order of its points";
  }
  return {};
}

std::string checkCornersDiffer(const std::vector<Triangle>& triangles) {
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
      return numbered("surface triangle", i) + " has one corner twice";
  }
  return {};
}

std::string checkNoTetrahedronTwice(std::vector<Tetrahedron> tetrahedra) {
  for (Tetrahedron& t : tetrahedra) std::sort(t.begin(), t.end());
  std::sort(tetrahedra.begin(), tetrahedra.end());
  const auto twice = std::adjacent_find(tetrahedra.begin(), tetrahedra.end());
  if (twice == tetrahedra.end()) return {};
  return "a tetrahedron of " + numbered("point", (*twice)[0]) + ", " + std::to_string((*twice)[1]) + ", " +
         std::to_string((*twice)[2]) + " and " + std::to_string((*twice)[3]) + " occurs twice";
}

std::string checkTetrahedra(const std::vector<Tetrahedron>& tetrahedra,
                            const std::vector<Eigen::Vector3d>& points) {
  for (std::size_t i = 0; i < tetrahedra.size(); ++i) {
    if (!(volumeOf(points, tetrahedra[i]) > 0.0))
      return numbered("tetrahedron", i) + " has a volume that is not above 0";
  }
  return {};
}

std::string checkNotNegative(double value, const char* name) {
  const bool valid = std::isfinite(value) && value >= 0.0;
  return valid ? std::string() : std::string("the ") + name + " is not a finite number of 0 or more";
}

std::string checkSkinSizes(const Skin& skin) {
  if (skin.points.size() != skin.weights.size()) {
    return "the skin has " + std::to_string(skin.weights.size()) + " weights for " +
           std::to_string(skin.points.size()) + " points";
  }
  const std::size_t last = skin.firstWeight.empty() ? 0 : skin.firstWeight.back();
  if (last != skin.weights.size()) {
    return "the skinned points have " + std::to_string(last) + " weights, there are " +
           std::to_string(skin.weights.size());
  }
  if (!skin.firstWeight.empty() && skin.firstWeight.front() != 0)
    return "the first skinned point does not begin at weight 0";
  for (std::size_t i = 0; i < skin.size(); ++i) {
    if (skin.firstWeight[i] >= skin.firstWeight[i + 1])
      return numbered("skinned point", i) + " has no weights";
  }
  return {};
}

std::string checkSkinnedPoint(const Skin& skin, std::size_t index, std::size_t points) {
  double sum = 0.0;
  for (std::uint32_t w = skin.firstWeight[index]; w < skin.firstWeight[index + 1]; ++w) {
    if (skin.points[w] >= points)
      return " follows " + numbered("point", skin.points[w]) + " of " + std::to_string(points);
    if (!std::isfinite(skin.weights[w])) return " has a weight that is not finite";
    sum += static_cast<double>(skin.weights[w]);
  }
  if (std::abs(sum - 1.0) > kWeightRounding) return " has weights that do not sum to 1";
  return {};
}

std::string checkSkin(const Skin& skin, std::size_t points) {
  std::string reason = checkSkinSizes(skin);
  for (std::size_t i = 0; reason.empty() && i < skin.size(); ++i) {
    const std::string problem = checkSkinnedPoint(skin, i, points);
    if (!problem.empty()) reason = numbered("skinned point", i) + problem;
  }
  return reason;
}

/// `target`: what the vertices follow, points or skinned points.
std::string checkVertexToPoint(const std::vector<std::uint32_t>& vertexToPoint, std::size_t count,
                               const char* target) {
  for (std::size_t i = 0; i < vertexToPoint.size(); ++i) {
    if (vertexToPoint[i] < count || vertexToPoint[i] == kNoPoint) continue;
    return numbered("render vertex", i) + " follows " + numbered(target, vertexToPoint[i]) + " of " +
           std::to_string(count);
  }
  return {};
}

std::string checkPointless(const RenderSurface& render) {
  for (std::size_t i = 0; i < render.triangles.size(); ++i) {
    for (const std::uint32_t vertex : render.triangles[i]) {
      if (render.vertexToPoint[vertex] != kNoPoint) continue;
      return numbered("render triangle", i) + " uses " + numbered("vertex", vertex) +
             ", which follows no point";
    }
  }
  return {};
}

std::string checkRender(const RenderSurface& render, std::size_t points) {
  const std::size_t vertices = render.vertexToPoint.size();
  if (!render.uvs.empty() && render.uvs.size() != vertices) {
    return std::to_string(render.uvs.size()) + " texture coordinates for " + std::to_string(vertices) +
           " render vertices";
  }
  const bool noSkin = render.skin.firstWeight.empty();
  std::string reason = checkSkin(render.skin, points);
  if (reason.empty()) {
    reason = checkVertexToPoint(render.vertexToPoint, noSkin ? points : render.skin.size(),
                                noSkin ? "point" : "skinned point");
  }
  if (reason.empty()) reason = checkCorners(render.triangles, vertices, "render triangle", "vertex");
  if (reason.empty()) reason = checkPointless(render);
  return reason;
}

std::string checkRopeHasNoSurface(const SpringNetwork& network) {
  const RenderSurface& render = network.render;
  const bool noSurface = network.surface.empty() && render.triangles.empty() &&
                         render.vertexToPoint.empty() && render.skin.firstWeight.empty() &&
                         network.tetrahedra.empty();
  return network.kind != NetworkKind::Rope || noSurface ? std::string()
                                                        : "a rope has no surface, skin or tetrahedra";
}

/// Checks that indices ascend and are below `count`.
std::string checkMembers(const std::vector<std::uint32_t>& members, std::size_t count, const char* what) {
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (members[i] >= count) return " has " + numbered(what, members[i]) + " of " + std::to_string(count);
    if (i > 0 && members[i] <= members[i - 1])
      return " has " + numbered(what, members[i]) + " after " + std::to_string(members[i - 1]);
  }
  return {};
}

std::string checkGroups(const SpringNetwork& network) {
  for (std::size_t i = 0; i < network.groups.size(); ++i) {
    const NamedGroup& group = network.groups[i];
    const auto same = [&](const NamedGroup& other) { return other.name == group.name; };
    const auto here = network.groups.begin() + static_cast<std::ptrdiff_t>(i);
    std::string reason;
    if (group.name.empty())
      reason = " has no name";
    else if (std::any_of(network.groups.begin(), here, same))
      reason = " has the name of an earlier one";
    if (reason.empty()) reason = checkMembers(group.springs, network.springs.size(), "spring");
    if (reason.empty()) reason = checkMembers(group.points, network.restPoints.size(), "point");
    if (!reason.empty()) return numbered("group", i) + " (" + group.name + ")" + reason;
  }
  return {};
}

}  // namespace

Result<SharedNetwork> withGroup(const SpringNetwork& network, const std::string& name,
                                std::vector<std::uint32_t> points) {
  sortUnique(points);
  const auto isMember = [&](std::uint32_t point) {
    return std::binary_search(points.begin(), points.end(), point);
  };
  auto result = std::make_shared<SpringNetwork>(network);
  NamedGroup group;
  group.name = name;
  for (std::uint32_t i = 0; i < network.springs.size(); ++i)
    if (isMember(network.springs[i].a) && isMember(network.springs[i].b)) group.springs.push_back(i);
  group.points = std::move(points);
  result->groups.push_back(std::move(group));
  if (std::string reason = checkGroups(*result); !reason.empty()) return Error{std::move(reason)};
  return SharedNetwork(std::move(result));
}

Result<void> validate(const SpringNetwork& network) {
  const std::size_t points = network.restPoints.size();
  std::string reason = network.kind > NetworkKind::Solid ? "the network has an unknown kind" : "";
  if (reason.empty()) reason = checkPoints(network.restPoints);
  if (reason.empty()) reason = checkMassFractions(network.massFractions, points);
  if (reason.empty()) reason = checkSprings(network.springs, points);
  if (reason.empty()) reason = checkCorners(network.surface, points, "surface triangle", "point");
  if (reason.empty()) reason = checkCornersDiffer(network.surface);
  if (reason.empty()) reason = checkCorners(network.tetrahedra, points, "tetrahedron", "point");
  if (reason.empty()) reason = checkTetrahedra(network.tetrahedra, network.restPoints);
  if (reason.empty()) reason = checkNoTetrahedronTwice(network.tetrahedra);
  if (reason.empty()) reason = checkNotNegative(network.stiffnessPerModulus, "stiffness per modulus");
  if (reason.empty()) reason = checkNotNegative(network.thickness, "thickness");
  if (reason.empty()) reason = checkNotNegative(network.volume, "volume");
  if (reason.empty()) reason = checkRender(network.render, points);
  if (reason.empty()) reason = checkRopeHasNoSurface(network);
  if (reason.empty()) reason = checkGroups(network);
  return reason.empty() ? Result<void>() : Error{std::move(reason)};
}

// --- .limber files -----------------------------------------------------------------------------------------

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

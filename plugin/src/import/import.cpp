// SPDX-License-Identifier: Zlib
// Reads mesh files through assimp. Checks the file before assimp reads it, checks the scene before using its
// indices, and splits polygons into triangles.

#include <limber/mesh.h>

#include <assimp/scene.h>
#include <assimp/Importer.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <new>
#include <numeric>
#include <sstream>
#include <system_error>

namespace limber {

// --- headers of PLY files ----------------------------------------------------------------------------------

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

/// Checks the header of a PLY file more strictly than assimp, which reads for ever or crashes after some
/// damaged ones (seen in 5.2): a header without an end, counts of elements that the file cannot hold, and
/// faces that have texture coordinates but no vertex indices. Returns the reason why the header is invalid.
/// Returns an empty string for valid headers and for files that are not PLY. Throws the exceptions of
/// std::filesystem.
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

// --- meshes ------------------------------------------------------------------------------------------------

using Eigen::Vector2d;
using Eigen::Vector3d;

std::string checkFile(const std::string& path) {
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(path, failure);
  if (!std::filesystem::exists(status)) return "there is no such file";
  if (std::filesystem::is_directory(status)) return "it is a directory";
  if (!std::filesystem::is_regular_file(status)) return "it is not a regular file";
  const std::uintmax_t size = std::filesystem::file_size(path, failure);
  if (failure) return failure.message();
  if (size == 0) return "the file is empty";
  return checkPlyHeader(path);
}

using Ring = std::vector<std::uint32_t>;  ///< remaining corners, counter-clockwise

/// Clipping takes up to the third power of the number of corners. Larger polygons are treated as convex.
constexpr std::size_t kMaxCornersToClip = 1000;

/// Returns the sum of the area vectors of the fan's triangles, twice the area (Newell's method). It is also
/// correct for concave polygons.
Vector3d areaVector(const std::vector<Vector3d>& corners) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    sum += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  }
  return sum;
}

/// Projects the polygon along the axis nearest to its normal, seen from the side where it is
/// counter-clockwise.
std::vector<Vector2d> project(const std::vector<Vector3d>& corners) {
  const Vector3d normal = areaVector(corners);
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const bool fromAbove = normal[axis] >= 0.0;
  const Eigen::Index u = (axis + (fromAbove ? 1 : 2)) % 3, v = (axis + (fromAbove ? 2 : 1)) % 3;
  std::vector<Vector2d> points;
  points.reserve(corners.size());
  for (const Vector3d& corner : corners) points.emplace_back(corner[u], corner[v]);
  return points;
}

/// Returns a positive value if c lies to the left of the line from a to b.
double side(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  const Vector2d ab = b - a, ac = c - a;
  return ab.x() * ac.y() - ab.y() * ac.x();
}

/// Returns whether p lies in the triangle or on its border, but not in a corner.
bool blocks(const Vector2d& p, const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  if (p == a || p == b || p == c) return false;
  return side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 && side(c, a, p) >= 0.0;
}

Triangle cornerAt(const Ring& ring, std::size_t index) {
  return {ring[(index + ring.size() - 1) % ring.size()], ring[index], ring[(index + 1) % ring.size()]};
}

/// Returns whether a corner is an ear: it points outward, and its triangle contains no other corner.
bool isEar(const Ring& ring, std::size_t index, const std::vector<Vector2d>& points) {
  const Triangle t = cornerAt(ring, index);
  const Vector2d &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
  if (!(side(a, b, c) > 0.0)) return false;
  for (const std::uint32_t other : ring) {
    if (blocks(points[other], a, b, c)) return false;
  }
  return true;
}

/// Returns an ear, or index 1. Index 1 is tested first, so that a convex polygon becomes a fan around corner
/// 0. Simple polygons always have an ear (G. Meisters 1975); of other polygons corner 1 is clipped.
std::size_t findEar(const Ring& ring, const std::vector<Vector2d>& points) {
  for (std::size_t i = 1; i <= ring.size(); ++i) {
    if (isEar(ring, i % ring.size(), points)) return i % ring.size();
  }
  return 1;
}

/// Splits a polygon of n >= 3 corners into n - 2 triangles of its corners, with its orientation. Concave
/// polygons are split by clipping ears; convex ones become a fan around corner 0. Nothing is dropped:
/// polygons that are not a simple plane loop also give triangles, good or bad.
std::vector<Triangle> splitPolygon(const std::vector<Vector3d>& corners) {
  const std::vector<Vector2d> points = project(corners);
  Ring ring(corners.size());
  std::iota(ring.begin(), ring.end(), 0u);
  std::vector<Triangle> triangles;
  if (ring.size() > kMaxCornersToClip) {
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) triangles.push_back({ring[0], ring[i], ring[i + 1]});
    return triangles;
  }
  while (ring.size() > 3) {
    const std::size_t ear = findEar(ring, points);
    triangles.push_back(cornerAt(ring, ear));
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({ring[0], ring[1], ring[2]});
  return triangles;
}

/// A mesh at a node. A mesh that two nodes refer to has two placements.
struct Placement {
  const aiMesh* mesh;
  Eigen::Matrix3d linear;
  Eigen::Vector3d origin;
};

Eigen::Vector3d toEigen(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Eigen::Matrix4d toEigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d matrix;
  matrix << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4;
  return matrix;
}

/// Faces of one or two corners are points and lines.
bool isPolygon(const aiFace& face) { return face.mNumIndices >= 3; }

bool hasPolygons(const aiMesh& mesh) {
  return std::any_of(mesh.mFaces, mesh.mFaces + mesh.mNumFaces, isPolygon);
}

/// Returns the existing children: assimp's RAW reader leaves some out.
std::vector<const aiNode*> childrenOf(const aiNode& node) {
  std::vector<const aiNode*> children;
  for (unsigned i = 0; node.mChildren != nullptr && i < node.mNumChildren; ++i) {
    if (node.mChildren[i] != nullptr) children.push_back(node.mChildren[i]);
  }
  return children;
}

void collectPlacements(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& parent,
                       std::vector<Placement>& placements) {
  const Eigen::Matrix4d toRoot = parent * toEigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh* mesh = scene.mMeshes[node.mMeshes[i]];
    if (hasPolygons(*mesh))
      placements.push_back({mesh, toRoot.topLeftCorner<3, 3>(), toRoot.topRightCorner<3, 1>()});
  }
  for (const aiNode* child : childrenOf(node)) collectPlacements(scene, *child, toRoot, placements);
}

void addPositions(const Placement& placement, std::vector<Eigen::Vector3d>& positions) {
  for (unsigned i = 0; i < placement.mesh->mNumVertices; ++i) {
    positions.push_back(placement.linear * toEigen(placement.mesh->mVertices[i]) + placement.origin);
  }
}

/// Transforms normals by the inverse transpose of the linear part, which is its cofactor matrix /
/// determinant. The cofactors (cross products of the columns) exist even if the determinant is 0. Only the
/// sign of the determinant matters.
void addNormals(const Placement& placement, std::vector<Eigen::Vector3f>& normals) {
  const Eigen::Matrix3d& m = placement.linear;
  Eigen::Matrix3d cofactors;
  cofactors << m.col(1).cross(m.col(2)), m.col(2).cross(m.col(0)), m.col(0).cross(m.col(1));
  if (m.determinant() < 0.0) cofactors = -cofactors;
  for (unsigned i = 0; i < placement.mesh->mNumVertices; ++i) {
    normals.push_back((cofactors * toEigen(placement.mesh->mNormals[i])).normalized().cast<float>());
  }
}

void addUvs(const Placement& placement, std::vector<Eigen::Vector2f>& uvs) {
  for (unsigned i = 0; i < placement.mesh->mNumVertices; ++i) {
    const aiVector3D& uv = placement.mesh->mTextureCoords[0][i];
    uvs.emplace_back(static_cast<float>(uv.x), static_cast<float>(uv.y));
  }
}

std::vector<Triangle> splitFace(const aiMesh& mesh, const aiFace& face) {
  if (face.mNumIndices == 3) return {{0, 1, 2}};
  std::vector<Eigen::Vector3d> corners;
  for (unsigned i = 0; i < face.mNumIndices; ++i)
    corners.push_back(toEigen(mesh.mVertices[face.mIndices[i]]));
  return splitPolygon(corners);
}

/// A mirrored placement reverses the order of the corners.
void addTriangles(const Placement& placement, std::uint32_t firstVertex, std::vector<Triangle>& triangles) {
  const bool mirrored = placement.linear.determinant() < 0.0;
  for (unsigned i = 0; i < placement.mesh->mNumFaces; ++i) {
    const aiFace& face = placement.mesh->mFaces[i];
    if (!isPolygon(face)) continue;
    for (const Triangle& corner : splitFace(*placement.mesh, face)) {
      const auto vertex = [&](std::size_t k) { return firstVertex + face.mIndices[corner[k]]; };
      triangles.push_back({vertex(0), vertex(mirrored ? 2 : 1), vertex(mirrored ? 1 : 2)});
    }
  }
}

std::string checkFaces(const aiMesh& mesh, unsigned meshIndex) {
  for (unsigned face = 0; face < mesh.mNumFaces; ++face) {
    for (unsigned corner = 0; corner < mesh.mFaces[face].mNumIndices; ++corner) {
      const unsigned vertex = mesh.mFaces[face].mIndices[corner];
      if (vertex < mesh.mNumVertices) continue;
      return "face " + std::to_string(face) + " of mesh " + std::to_string(meshIndex) + " uses vertex " +
             std::to_string(vertex) + " of " + std::to_string(mesh.mNumVertices);
    }
  }
  return {};
}

std::string checkNode(const aiScene& scene, const aiNode& node) {
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    if (node.mMeshes[i] < scene.mNumMeshes) continue;
    return "node '" + std::string(node.mName.C_Str()) + "' uses mesh " + std::to_string(node.mMeshes[i]) +
           " of " + std::to_string(scene.mNumMeshes);
  }
  for (const aiNode* child : childrenOf(node)) {
    std::string reason = checkNode(scene, *child);
    if (!reason.empty()) return reason;
  }
  return {};
}

/// Describes the first invalid mesh or index in the scene; empty if there is none.
std::string checkScene(const aiScene& scene) {
  if (scene.mRootNode == nullptr) return "the file has no scene";
  std::string reason = checkNode(scene, *scene.mRootNode);
  for (unsigned i = 0; i < scene.mNumMeshes && reason.empty(); ++i) reason = checkFaces(*scene.mMeshes[i], i);
  return reason;
}

/// Returns the faces of all meshes at all nodes as triangles, in the coordinates of the root, without points
/// and lines. The scene must have passed checkScene().
TriangleMesh joinMeshes(const aiScene& scene) {
  std::vector<Placement> placements;
  collectPlacements(scene, *scene.mRootNode, Eigen::Matrix4d::Identity(), placements);
  const bool withNormals = std::all_of(placements.begin(), placements.end(),
                                       [](const Placement& p) { return p.mesh->HasNormals(); });
  const bool withUvs = std::all_of(placements.begin(), placements.end(),
                                   [](const Placement& p) { return p.mesh->HasTextureCoords(0); });

  TriangleMesh joined;
  for (const Placement& placement : placements) {
    addTriangles(placement, static_cast<std::uint32_t>(joined.positions.size()), joined.triangles);
    addPositions(placement, joined.positions);
    if (withNormals) addNormals(placement, joined.normals);
    if (withUvs) addUvs(placement, joined.uvs);
  }
  return joined;
}

/// The bits of one vertex: three doubles, a normal, texture coordinates. Bits, because NaN has no order.
using VertexBits = std::array<std::uint32_t, 11>;

std::vector<VertexBits> vertexBits(const TriangleMesh& mesh) {
  std::vector<VertexBits> bits(mesh.positions.size(), VertexBits{});
  for (std::size_t i = 0; i < bits.size(); ++i) {
    std::memcpy(&bits[i][0], mesh.positions[i].data(), 3 * sizeof(double));
    if (!mesh.normals.empty()) std::memcpy(&bits[i][6], mesh.normals[i].data(), 3 * sizeof(float));
    if (!mesh.uvs.empty()) std::memcpy(&bits[i][9], mesh.uvs[i].data(), 2 * sizeof(float));
  }
  return bits;
}

template <class T>
void keepOnly(const std::vector<std::uint32_t>& kept, std::vector<T>& values) {
  if (values.empty()) return;
  for (std::size_t i = 0; i < kept.size(); ++i) values[i] = values[kept[i]];
  values.resize(kept.size());
}

/// Merges vertices whose positions, normals and texture coordinates are equal bit for bit. Many file readers
/// give every corner its own vertex, and each of them would be moved and uploaded in every frame. Keeps the
/// order of first occurrence. The mesh must be valid.
void joinIdenticalVertices(TriangleMesh& mesh) {
  std::map<VertexBits, std::uint32_t> indexOf;
  std::vector<std::uint32_t> kept, newIndex;
  for (const VertexBits& bits : vertexBits(mesh)) {
    const auto [entry, isNew] = indexOf.try_emplace(bits, static_cast<std::uint32_t>(kept.size()));
    if (isNew) kept.push_back(static_cast<std::uint32_t>(newIndex.size()));
    newIndex.push_back(entry->second);
  }
  keepOnly(kept, mesh.positions);
  keepOnly(kept, mesh.normals);
  keepOnly(kept, mesh.uvs);
  for (Triangle& t : mesh.triangles) t = {newIndex[t[0]], newIndex[t[1]], newIndex[t[2]]};
}

/// Reads without any of assimp's repairs, so that our own checks see the contents of the file. It does not
/// even use assimp's splitting of polygons, which uses indices unchecked, drops small triangles and aborts
/// the program at a face without corners.
Result<TriangleMesh> readMesh(const std::string& path) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, 0);
  if (scene == nullptr && importer.GetException()) std::rethrow_exception(importer.GetException());
  if (scene == nullptr) return Error{importer.GetErrorString()};
  if (std::string reason = checkScene(*scene); !reason.empty()) return Error{std::move(reason)};

  TriangleMesh mesh = joinMeshes(*scene);
  if (mesh.triangles.empty()) return Error{"the file has no triangles"};
  if (Result<void> valid = validate(mesh); !valid) return Error{valid.error()};
  joinIdenticalVertices(mesh);
  return mesh;
}

/// Catches exceptions: on damaged files, assimp passes on those of its format readers and the standard
/// library.
Result<TriangleMesh> readWithoutThrowing(const std::string& path) {
  try {
    if (std::string reason = checkFile(path); !reason.empty()) return Error{std::move(reason)};
    return readMesh(path);
  } catch (const std::bad_alloc&) {
    return Error{"there is not enough memory: the file is damaged or too large"};
  } catch (const std::exception& failure) {
    return Error{failure.what()};
  } catch (...) {
    return Error{"the reader gave up for an unknown reason"};
  }
}

}  // namespace

Result<TriangleMesh> importMesh(const std::string& path) {
  Result<TriangleMesh> mesh = readWithoutThrowing(path);
  if (!mesh) return Error{"cannot import '" + path + "': " + mesh.error()};
  return mesh;
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
// Reads networks and measures their bends. Reads and cooks meshes, and keeps the results in a cache: a cooked
// mesh is one file with the report, named by a hash, and a .limber file for each body.

#include "scenes/networks.h"

#include "mesh_reader.h"
#include "output_files.h"

#include <limber/mesh.h>
#include <limber/network_builder.h>
#include <limber/spring_network.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

namespace limber::scenes {

bool isLimberFile(const std::string& file) {
  const std::string ending = ".limber";
  return file.size() > ending.size() && file.compare(file.size() - ending.size(), ending.size(), ending) == 0;
}

Result<SharedNetwork> cubeNetwork(BraceRule braces) {
  const Result<TriangleMesh> mesh = importMesh(LIMBER_MESH_DIR "/cube.obj");
  if (!mesh) return Error{mesh.error()};
  NetworkSettings settings;
  settings.braces = braces;
  return buildNetwork(*mesh, settings);
}

namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

using Positions = std::vector<Eigen::Vector3f>;

Eigen::Vector3f normalOf(const Positions& x, const Triangle& t) {
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized();
}

Positions restPoints(const SpringNetwork& network) {
  Positions points;
  for (const Eigen::Vector3d& p : network.restPoints) points.push_back(p.cast<float>());
  return points;
}

/// Returns the positions of the drawn vertices at rest: the places of the skin, or the points.
Positions restVertexPositions(const SpringNetwork& network) {
  const Positions points = restPoints(network);
  const Skin& skin = network.render.skin;
  if (skin.size() == 0) return points;
  Positions places(skin.size());
  applySkin(skin, points.front().data(), places.front().data());
  return places;
}

double angle(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::acos(std::clamp(double(a.dot(b)), -1.0, 1.0));
}

/// Returns the angles at the edges, ascending.
std::vector<double> bends(const SpringNetwork& network) {
  const Positions places = restVertexPositions(network);
  const auto& placeOf = network.render.vertexToPoint;
  std::map<Edge, Eigen::Vector3f> normals;  // of the first triangle at each edge
  std::vector<double> angles;
  for (const Triangle& drawn : network.render.triangles) {
    const Triangle t = {placeOf[drawn[0]], placeOf[drawn[1]], placeOf[drawn[2]]};
    const Eigen::Vector3f normal = normalOf(places, t);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Edge edge = std::minmax({t[corner], t[(corner + 1) % 3]});
      const auto [entry, isNew] = normals.try_emplace(edge, normal);
      if (!isNew) angles.push_back(angle(entry->second, normal));
    }
  }
  std::sort(angles.begin(), angles.end());
  return angles;
}

}  // namespace

double sharpestBend(const SpringNetwork& network) {
  const std::vector<double> angles = bends(network);
  return angles.empty() ? 0.0 : angles.back();
}

double usualBend(const SpringNetwork& network) {
  const std::vector<double> angles = bends(network);
  return angles.empty() ? 0.0 : angles[9 * angles.size() / 10];
}

// --- cooked meshes -----------------------------------------------------------------------------------------

namespace {

/// To be raised when cook() makes other bodies of the same mesh.
constexpr int kCookVersion = 7;

/// FNV-1a (G. Fowler, L. Noll, K.-P. Vo), 64 bits.
class Hash {
 public:
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3u;
  }
  template <class T>
  void add(const T& value) {
    add(&value, sizeof value);
  }
  template <class T>
  void add(const std::vector<T>& all) {
    add(all.size());
    if (!all.empty()) add(all.data(), all.size() * sizeof(T));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

std::string hashOf(const TriangleMesh& mesh, const CookSettings& s) {
  Hash hash;
  hash.add(kCookVersion);
  hash.add(mesh.positions);
  hash.add(mesh.normals);
  hash.add(mesh.uvs);
  hash.add(mesh.triangles);
  hash.add(s.size.value_or(-1.0));
  hash.add(s.points);
  hash.add(s.mode);
  hash.add(s.pieces);
  hash.add(s.skin ? static_cast<int>(*s.skin) : -1);
  return demo::hashText(hash.value());
}

std::string bodyFile(const std::string& base, std::size_t body) {
  return base + "-" + std::to_string(body) + ".limber";
}

/// Writes the bodies first: the report says that they are complete.
void keep(const CookedMesh& cooked, const std::string& base) {
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(base).parent_path(), error);
  for (std::size_t i = 0; i < cooked.bodies.size(); ++i)
    if (!saveNetwork(*cooked.bodies[i], bodyFile(base, i))) return;
  std::ostringstream out;
  out.precision(17);
  out << cooked.bodies.size() << ' ' << cooked.scale << '\n';
  for (const std::string& line : cooked.report) out << line << '\n';
  static_cast<void>(demo::writeText(base + ".txt", out.str()));  // without a cache the next run cooks again
}

/// Returns the cached bodies, or an error if there are none or they are damaged.
Result<CookedMesh> load(const std::string& base) {
  std::ifstream in(base + ".txt");
  std::size_t count = 0;
  CookedMesh cooked;
  if (!(in >> count >> cooked.scale) || count == 0 || count > 1000) return Error{"not cached"};
  for (std::size_t i = 0; i < count; ++i) {
    Result<SharedNetwork> network = loadNetwork(bodyFile(base, i));
    if (!network) return Error{network.error()};
    cooked.bodies.push_back(std::move(*network));
  }
  in.ignore();
  for (std::string& line : cooked.report)
    if (!std::getline(in, line)) return Error{"damaged"};
  return cooked;
}

Result<CookedMesh> bodiesOf(SharedNetwork network, const std::string& file) {
  CookedMesh cooked;
  cooked.report[0] = "body: " + file + ", " + std::to_string(network->restPoints.size()) + " points, " +
                     std::to_string(network->springs.size()) + " springs";
  cooked.bodies.push_back(std::move(network));
  return cooked;
}

}  // namespace

Result<CookedMesh> readBodies(const std::string& file, const CookSettings& settings,
                              const std::string& cache) {
  if (isLimberFile(file)) {
    Result<SharedNetwork> network = loadNetwork(file);
    return network ? bodiesOf(std::move(*network), file) : Result<CookedMesh>(Error{network.error()});
  }
  const Result<TriangleMesh> mesh = demo::readMesh(file);
  if (!mesh) return Error{mesh.error()};
  const std::string base = cache + "/" + hashOf(*mesh, settings);
  if (!cache.empty())
    if (Result<CookedMesh> kept = load(base)) return kept;
  Result<CookedMesh> cooked = cook(*mesh, settings);
  if (!cooked) return Error{file + ": " + cooked.error()};
  if (!cache.empty()) keep(*cooked, base);
  return cooked;
}

}  // namespace limber::scenes

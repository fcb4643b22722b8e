// SPDX-License-Identifier: Zlib
// Writes networks to .limber files and reads them. A hash detects damage, and the reader checks every value
// before use.

#include <limber/spring_network.h>

#include "mesh/bytes.h"

#include <limber/result.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

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
// the layout needs a new version. Version 2 also has groups.

/// Begins every .limber file. Like PNG's: not text, and damaged by a transfer as text.
constexpr SealedFormat kFormat = {
    {0x89, 'L', 'I', 'M', 'B', 'R', '\r', '\n'}, "a .limber file", "the file", 2};

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
}

std::string readContents(const std::uint8_t* bytes, std::size_t size, std::uint32_t version,
                         SpringNetwork& network) {
  ByteReader reader(bytes, size);
  transferNetwork(reader, network, version);
  if (!reader.problem().empty()) return reader.problem();
  if (reader.bytesLeft() > 0)
    return std::to_string(reader.bytesLeft()) + " bytes follow the end of its contents";
  return validate(network).error();
}

}  // namespace

std::vector<std::uint8_t> toBytes(const SpringNetwork& network) {
  const std::uint32_t version = network.groups.empty() ? 1 : 2;
  std::vector<std::uint8_t> bytes;
  bytes.resize(kHeaderBytes);
  ByteWriter writer(bytes);
  transferNetwork(writer, network, version);
  seal(kFormat, version, bytes);
  return bytes;
}

Result<SharedNetwork> fromBytes(const std::uint8_t* bytes, std::size_t size) {
  std::string reason = checkSealed(kFormat, bytes, size);
  auto network = std::make_shared<SpringNetwork>();
  if (reason.empty())
    reason = readContents(bytes + kHeaderBytes, size - kHeaderBytes, versionOf(bytes), *network);
  if (!reason.empty()) return Error{std::move(reason)};
  return SharedNetwork(std::move(network));
}

Result<void> saveNetwork(const SpringNetwork& network, const std::string& file) {
  if (Result<void> valid = validate(network); !valid) return Error{file + ": " + valid.error()};
  std::string reason = writeWholeFile(file, toBytes(network));
  return reason.empty() ? Result<void>() : Error{std::move(reason)};
}

Result<SharedNetwork> loadNetwork(const std::string& file) {
  const Result<std::vector<std::uint8_t>> bytes = readWholeFile(kFormat, file);
  if (!bytes) return Error{bytes.error()};
  Result<SharedNetwork> network = fromBytes(bytes->data(), bytes->size());
  return network ? network : Error{file + ": " + network.error()};
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "import/identical_vertices.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <numeric>

namespace limber {
namespace {

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

/// For each vertex the first one that is identical to it.
std::vector<std::uint32_t> firstIdentical(const std::vector<VertexBits>& bits) {
  std::vector<std::uint32_t> order(bits.size()), first(bits.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t i, std::uint32_t j) { return bits[i] != bits[j] ? bits[i] < bits[j] : i < j; });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool repeats = k > 0 && bits[order[k]] == bits[order[k - 1]];
    first[order[k]] = repeats ? first[order[k - 1]] : order[k];
  }
  return first;
}

template <class T>
void keepOnly(const std::vector<std::uint32_t>& kept, std::vector<T>& values) {
  if (values.empty()) return;
  for (std::size_t i = 0; i < kept.size(); ++i) values[i] = values[kept[i]];
  values.resize(kept.size());
}

}  // namespace

void joinIdenticalVertices(TriangleMesh& mesh) {
  const std::vector<std::uint32_t> first = firstIdentical(vertexBits(mesh));
  std::vector<std::uint32_t> kept, newIndex(first.size());
  for (std::uint32_t i = 0; i < first.size(); ++i) {
    newIndex[i] = first[i] == i ? static_cast<std::uint32_t>(kept.size()) : newIndex[first[i]];
    if (first[i] == i) kept.push_back(i);
  }
  keepOnly(kept, mesh.positions);
  keepOnly(kept, mesh.normals);
  keepOnly(kept, mesh.uvs);
  for (Triangle& t : mesh.triangles) t = {newIndex[t[0]], newIndex[t[1]], newIndex[t[2]]};
}

}  // namespace limber

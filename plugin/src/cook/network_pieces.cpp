// SPDX-License-Identifier: Zlib
#include "cook/network_pieces.h"

#include "mesh/edges.h"

#include <algorithm>
#include <cstdint>

namespace limber {
namespace {

constexpr std::uint32_t kNotHere = 0xffffffffu;

/// Those of the triangles or tetrahedra that have all corners here, with the points' new numbers.
template <class Corners>
std::vector<Corners> keep(const std::vector<Corners>& all, const std::vector<std::uint32_t>& number) {
  std::vector<Corners> kept;
  for (Corners corners : all) {
    for (std::uint32_t& corner : corners) corner = number[corner];
    if (std::find(corners.begin(), corners.end(), kNotHere) == corners.end()) kept.push_back(corners);
  }
  return kept;
}

}  // namespace

std::vector<std::vector<Eigen::Index>> findPieces(const SpringNetwork& network) {
  const std::size_t points = network.restPoints.size();
  DisjointSets sets(points);
  for (const NetworkSpring& s : network.springs) sets.join(s.a, s.b);
  std::vector<std::vector<Eigen::Index>> pieces;
  std::vector<std::size_t> pieceOfRoot(points, 0);
  for (std::uint32_t i = 0; i < points; ++i) {
    const std::uint32_t root = sets.root(i);
    if (root == i) pieceOfRoot[i] = pieces.size(), pieces.emplace_back();
    pieces[pieceOfRoot[root]].push_back(static_cast<Eigen::Index>(i));
  }
  return pieces;
}

SpringNetwork pieceOf(const SpringNetwork& network, const std::vector<Eigen::Index>& points) {
  SpringNetwork piece;
  piece.kind = network.kind;
  piece.stiffnessPerModulus = network.stiffnessPerModulus;
  std::vector<std::uint32_t> number(network.restPoints.size(), kNotHere);
  double mass = 0.0;
  for (const Eigen::Index point : points) {
    const auto i = static_cast<std::size_t>(point);
    number[i] = static_cast<std::uint32_t>(piece.restPoints.size());
    piece.restPoints.push_back(network.restPoints[i]);
    piece.massShares.push_back(network.massShares[i]);
    mass += network.massShares[i];
  }
  for (double& share : piece.massShares) share /= mass;
  for (const NetworkSpring& s : network.springs)
    if (number[s.a] != kNotHere && number[s.b] != kNotHere)
      piece.springs.push_back({number[s.a], number[s.b], s.kind, s.stiffnessScale});
  piece.surface = keep(network.surface, number);
  piece.tetrahedra = keep(network.tetrahedra, number);
  setEdgeDefects(piece.report, piece.surface);
  return piece;
}

}  // namespace limber

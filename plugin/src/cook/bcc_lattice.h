// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>

namespace limber {

/// Marks a place outside the lattice, or an edge without a cut.
constexpr std::uint32_t kNoSite = 0xffffffffu;

/// A body-centred cubic lattice: the corners and the centres of cubes (or, stretched, of boxes). A site has
/// whole coordinates, in half spacings, all even (corners) or all odd (centres); its number is
/// 2 (x + cells_x (y + cells_y z)) + 1 for centres, of the cell that it is the lower corner or the centre of.
struct BccLattice {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();   ///< m, of site 0
  Eigen::Vector3d spacing = Eigen::Vector3d::Zero();  ///< m, along each axis
  Eigen::Vector3i cells = Eigen::Vector3i::Zero();    ///< along each axis

  std::uint32_t size() const { return 2 * static_cast<std::uint32_t>(cells.prod()); }
};

/// Edges of a site: three long ones, of the spacing, and four short ones, of sqrt(3)/2 spacings, then the
/// seven opposite to these.
constexpr std::uint32_t kLongEdges = 3, kEdgesPerSite = 7, kNeighbours = 14;

Eigen::Vector3d sitePosition(const BccLattice& lattice, std::uint32_t site);

/// The other end of an edge, or kNoSite outside the lattice.
std::uint32_t neighbour(const BccLattice& lattice, std::uint32_t site, std::uint32_t direction);

/// The number of the edge from a site in a direction, the same from both ends: kEdgesPerSite times the end it
/// is one of the first seven of, plus its direction there. The edge must be in the lattice.
std::uint32_t edgeNumber(const BccLattice& lattice, std::uint32_t site, std::uint32_t direction);

/// The direction from a site to one of its neighbours.
std::uint32_t directionTo(const BccLattice& lattice, std::uint32_t from, std::uint32_t to);

/// The tetrahedra of the lattice, all congruent: two long edges, one of corners and one of centres, at right
/// angles, and four short ones. `site` is a corner, and the lower end of the long edge along `axis`, around
/// which four tetrahedra lie. Sites 0 and 1, and 2 and 3, are joined by the long edges; the orientation is
/// positive. The first is kNoSite where the lattice ends.
std::array<std::uint32_t, 4> latticeTetrahedron(const BccLattice& lattice, std::uint32_t site, int axis,
                                                int quarter);

}  // namespace limber

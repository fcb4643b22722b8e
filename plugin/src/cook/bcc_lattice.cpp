// SPDX-License-Identifier: Zlib
#include "cook/bcc_lattice.h"

namespace limber {
namespace {

using Eigen::Vector3i;

/// In half spacings.
const std::array<Vector3i, kNeighbours>& directions() {
  static const std::array<Vector3i, kNeighbours> all = [] {
    std::array<Vector3i, kNeighbours> d;
    d[0] = {2, 0, 0}, d[1] = {0, 2, 0}, d[2] = {0, 0, 2};
    d[3] = {1, 1, 1}, d[4] = {1, 1, -1}, d[5] = {1, -1, 1}, d[6] = {1, -1, -1};
    for (std::size_t i = 0; i < kEdgesPerSite; ++i) d[kEdgesPerSite + i] = -d[i];
    return d;
  }();
  return all;
}

Vector3i coordinates(const BccLattice& lattice, std::uint32_t site) {
  const int cell = static_cast<int>(site / 2), centre = static_cast<int>(site % 2);
  const int x = cell % lattice.cells[0], rest = cell / lattice.cells[0];
  return Vector3i(2 * x, 2 * (rest % lattice.cells[1]), 2 * (rest / lattice.cells[1])).array() + centre;
}

std::uint32_t siteAt(const BccLattice& lattice, const Vector3i& c) {
  for (int i = 0; i < 3; ++i)
    if (c[i] < 0 || c[i] >= 2 * lattice.cells[i]) return kNoSite;
  const int cell = c[0] / 2 + lattice.cells[0] * (c[1] / 2 + lattice.cells[1] * (c[2] / 2));
  return static_cast<std::uint32_t>(2 * cell + c[0] % 2);
}

}  // namespace

Eigen::Vector3d sitePosition(const BccLattice& lattice, std::uint32_t site) {
  return lattice.origin + 0.5 * lattice.spacing.cwiseProduct(coordinates(lattice, site).cast<double>());
}

std::uint32_t neighbour(const BccLattice& lattice, std::uint32_t site, std::uint32_t direction) {
  return siteAt(lattice, coordinates(lattice, site) + directions()[direction]);
}

std::uint32_t edgeNumber(const BccLattice& lattice, std::uint32_t site, std::uint32_t direction) {
  return direction < kEdgesPerSite
             ? kEdgesPerSite * site + direction
             : kEdgesPerSite * neighbour(lattice, site, direction) + direction - kEdgesPerSite;
}

std::uint32_t directionTo(const BccLattice& lattice, std::uint32_t from, std::uint32_t to) {
  const Vector3i d = coordinates(lattice, to) - coordinates(lattice, from);
  std::uint32_t direction = 0;
  while (directions()[direction] != d) ++direction;
  return direction;
}

std::array<std::uint32_t, 4> latticeTetrahedron(const BccLattice& lattice, std::uint32_t site, int axis,
                                                int quarter) {
  // around the edge the centres lie at (1, 1), (-1, 1), (-1, -1), (1, -1) in the plane of the other axes
  const auto centre = [&](int q) {
    Vector3i c = coordinates(lattice, site);
    c[axis] += 1;
    c[(axis + 1) % 3] += q % 4 == 0 || q % 4 == 3 ? 1 : -1;
    c[(axis + 2) % 3] += q % 4 < 2 ? 1 : -1;
    return siteAt(lattice, c);
  };
  const std::array<std::uint32_t, 4> sites{site, neighbour(lattice, site, static_cast<std::uint32_t>(axis)),
                                           centre(quarter), centre(quarter + 1)};
  const bool complete = sites[1] != kNoSite && sites[2] != kNoSite && sites[3] != kNoSite;
  return complete ? sites : std::array<std::uint32_t, 4>{kNoSite, kNoSite, kNoSite, kNoSite};
}

}  // namespace limber

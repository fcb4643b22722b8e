// SPDX-License-Identifier: Zlib
#include "cook/lattice_cut.h"

#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Shares of a long and of a short edge within which a cut draws its site near: the paper's "safe" values,
/// for which it proves the angles of all tetrahedra bounded.
constexpr double kWarpLong = 0.24999, kWarpShort = 0.41189;

/// A site this near to the surface, in spacings, is on it.
constexpr double kOnSurface = 1e-6;

/// Along a row the distance to the surface changes by no more than the spacing, so most sites need no query.
void findSides(CutLattice& cut, const TriangleBvh& surface) {
  const double spacing = cut.lattice.spacing[0];
  const auto row = 2 * static_cast<std::uint32_t>(cut.lattice.cells[0]);
  std::array<double, 2> clear{};  // m from the surface at least, of the last corner and the last centre
  for (std::uint32_t site = 0; site < cut.lattice.size(); ++site) {
    double& c = clear[site % 2];
    if (site % row >= 2 && c > spacing) {
      c -= spacing;
      cut.side[site] = cut.side[site - 2];
      continue;
    }
    const double distance = surface.signedDistance(cut.positions[site]);
    c = std::abs(distance);
    cut.side[site] = static_cast<std::int8_t>(c <= kOnSurface * spacing ? 0 : distance < 0.0 ? 1 : -1);
  }
}

/// Where the segment leaves the inside, with one end inside and one outside.
Vector3d bisect(Vector3d in, Vector3d out, const TriangleBvh& surface) {
  for (int i = 0; i < 30; ++i) {
    const Vector3d middle = 0.5 * (in + out);
    (surface.inside(middle) ? in : out) = middle;
  }
  return 0.5 * (in + out);
}

/// The first triangle that a ray from inside meets is where it leaves, unless surfaces lie within each other.
Vector3d findCut(const Vector3d& in, const Vector3d& out, const TriangleBvh& surface) {
  const double length = (out - in).norm(), step = 1e-3 * length;
  const Vector3d direction = (out - in) / length;
  const SurfaceHit hit = surface.firstHit(in, direction, 0.0, length);
  if (!hit) return bisect(in, out, surface);
  const bool leaves = hit.distance + step >= length || !surface.inside(hit.position + step * direction);
  return leaves ? hit.position : bisect(in, out, surface);
}

void cutEdges(CutLattice& cut, const TriangleBvh& surface) {
  for (std::uint32_t site = 0; site < cut.lattice.size(); ++site)
    for (std::uint32_t d = 0; d < kEdgesPerSite; ++d) {
      const std::uint32_t other = neighbour(cut.lattice, site, d);
      if (other == kNoSite || cut.side[site] * cut.side[other] >= 0) continue;
      const std::uint32_t in = cut.side[site] > 0 ? site : other, out = cut.side[site] > 0 ? other : site;
      cut.cutOfEdge[kEdgesPerSite * site + d] = static_cast<std::uint32_t>(cut.cuts.size());
      cut.cuts.push_back(findCut(cut.positions[in], cut.positions[out], surface));
    }
}

/// The cut that is too near to the site by the least share of its edge, or kNoSite.
std::uint32_t nearCut(const CutLattice& cut, std::uint32_t site) {
  std::uint32_t nearest = kNoSite;
  double least = 1.0;
  for (std::uint32_t d = 0; d < kNeighbours; ++d) {
    const std::uint32_t other = neighbour(cut.lattice, site, d);
    const std::uint32_t c = other == kNoSite ? kNoSite : cut.cutOfEdge[edgeNumber(cut.lattice, site, d)];
    if (c == kNoSite) continue;
    const double length = (sitePosition(cut.lattice, other) - cut.positions[site]).norm();
    const double share = (cut.cuts[c] - cut.positions[site]).norm() / length;
    if (share >= (d % kEdgesPerSite < kLongEdges ? kWarpLong : kWarpShort) || share >= least) continue;
    nearest = c;
    least = share;
  }
  return nearest;
}

void warp(CutLattice& cut) {
  for (std::uint32_t site = 0; site < cut.lattice.size(); ++site) {
    const std::uint32_t c = cut.side[site] == 0 ? kNoSite : nearCut(cut, site);
    if (c == kNoSite) continue;
    cut.positions[site] = cut.cuts[c];
    cut.side[site] = 0;
    for (std::uint32_t d = 0; d < kNeighbours; ++d)
      if (neighbour(cut.lattice, site, d) != kNoSite) cut.cutOfEdge[edgeNumber(cut.lattice, site, d)] = kNoSite;
  }
}

}  // namespace

CutLattice cutLattice(const BccLattice& lattice, const TriangleBvh& surface) {
  CutLattice cut;
  cut.lattice = lattice;
  cut.side.resize(lattice.size());
  cut.cutOfEdge.assign(kEdgesPerSite * lattice.size(), kNoSite);
  for (std::uint32_t site = 0; site < lattice.size(); ++site)
    cut.positions.push_back(sitePosition(lattice, site));
  findSides(cut, surface);
  cutEdges(cut, surface);
  warp(cut);
  return cut;
}

}  // namespace limber

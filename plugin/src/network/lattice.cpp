// SPDX-License-Identifier: Zlib
// Fills a surface by isosurface stuffing: the surface cuts a body-centred cubic lattice, near sites move onto
// the surface, and the parts inside become tetrahedra.

#include "network/tetrahedra.h"

namespace limber {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// Marks a position outside the lattice, or an edge without a cut.
constexpr std::uint32_t kNoSite = 0xffffffffu;

/// Edges of a site: three long ones, of the spacing, and four short ones, of sqrt(3)/2 spacings, then the
/// seven in the opposite directions.
constexpr std::uint32_t kLongEdges = 3, kEdgesPerSite = 7, kNeighbours = 14;

/// Returns the directions to the neighbours, in half spacings.
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

Eigen::Vector3d sitePosition(const BccLattice& lattice, std::uint32_t site) {
  return lattice.origin + 0.5 * lattice.spacing.cwiseProduct(coordinates(lattice, site).cast<double>());
}

/// Returns the other end of an edge, or kNoSite outside the lattice.
std::uint32_t neighbour(const BccLattice& lattice, std::uint32_t site, std::uint32_t direction) {
  return siteAt(lattice, coordinates(lattice, site) + directions()[direction]);
}

/// Returns the number of the edge from a site in a direction, the same from both ends: kEdgesPerSite times
/// the end at which it is one of the first seven edges, plus its direction there. The edge must be in the
/// lattice.
std::uint32_t edgeNumber(const BccLattice& lattice, std::uint32_t site, std::uint32_t direction) {
  return direction < kEdgesPerSite
             ? kEdgesPerSite * site + direction
             : kEdgesPerSite * neighbour(lattice, site, direction) + direction - kEdgesPerSite;
}

/// Returns the direction from a site to one of its neighbours.
std::uint32_t directionTo(const BccLattice& lattice, std::uint32_t from, std::uint32_t to) {
  const Vector3i d = coordinates(lattice, to) - coordinates(lattice, from);
  std::uint32_t direction = 0;
  while (directions()[direction] != d) ++direction;
  return direction;
}

/// Returns a tetrahedron of the lattice. All are congruent: two long edges at right angles, one between
/// corners and one between centres, and four short ones. `site` is a corner and the lower end of the long
/// edge along `axis`; four tetrahedra lie around this edge. The long edges join sites 0 and 1, and 2 and 3.
/// The orientation is positive. The first site is kNoSite if a site is outside the lattice.
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

/// A lattice with its cuts by a closed surface. Sites near the surface are moved onto it.
struct CutLattice {
  BccLattice lattice;
  std::vector<std::int8_t> side;           ///< #sites, 1 inside, -1 outside, 0 on the surface
  std::vector<Eigen::Vector3d> positions;  ///< #sites, m
  std::vector<std::uint32_t> cutOfEdge;    ///< kEdgesPerSite x #sites, index of a cut, or kNoSite
  std::vector<Eigen::Vector3d> cuts;       ///< #cuts, m, where an edge crosses the surface
};

/// Fractions of a long and of a short edge within which a cut attracts its site: the paper's "safe" values,
/// for which it proves that the angles of all tetrahedra are bounded.
constexpr double kWarpLong = 0.24999, kWarpShort = 0.41189;

/// A site within this distance from the surface, in spacings, is on it.
constexpr double kOnSurface = 1e-6;

/// Distances from the surface are computed up to this many spacings: farther ones cost more than they save.
constexpr double kReach = 3.0;

/// From site to site of a row the distance to the surface changes by the spacing at most, so most sites need
/// no query. Sites whose distances add up to more than the spacing are on the same side.
void findSides(CutLattice& cut, const TriangleBvh& surface) {
  const double spacing = cut.lattice.spacing[0];
  const auto row = 2 * static_cast<std::uint32_t>(cut.lattice.cells[0]);
  // m, lower bound of the distance of the last corner and the last centre from the surface
  std::array<double, 2> clearance{};
  for (std::uint32_t site = 0; site < cut.lattice.size(); ++site) {
    double& c = clearance[site % 2];
    const std::int8_t last = site % row >= 2 ? cut.side[site - 2] : std::int8_t{0};
    const double before = last != 0 ? c : 0.0;
    c = before - spacing;
    if (!(c > 0.0)) {
      const TriangleHit hit = surface.nearestWithin(cut.positions[site], kReach * spacing);
      c = hit ? hit.distance : kReach * spacing;
    }
    if (last != 0 && before + c > spacing)
      cut.side[site] = last;
    else if (c > kOnSurface * spacing)
      cut.side[site] = surface.inside(cut.positions[site]) ? 1 : -1;
  }
}

/// Returns the position where the segment, with one end inside and one outside, crosses the surface.
Vector3d bisect(Vector3d in, Vector3d out, const TriangleBvh& surface) {
  for (int i = 0; i < 30; ++i) {
    const Vector3d middle = 0.5 * (in + out);
    (surface.inside(middle) ? in : out) = middle;
  }
  return 0.5 * (in + out);
}

/// The segment leaves the body at the first triangle that the ray from inside hits, unless surfaces lie
/// within each other.
Vector3d findCut(const Vector3d& in, const Vector3d& out, const TriangleBvh& surface) {
  const double length = (out - in).norm(), step = 1e-3 * length;
  const Vector3d direction = (out - in) / length;
  const TriangleHit hit = surface.firstHit(in, direction, 0.0, length);
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

/// Returns the cut that is too near to the site, that with the smallest fraction of its edge if there are
/// several, or kNoSite.
std::uint32_t nearCut(const CutLattice& cut, std::uint32_t site) {
  std::uint32_t nearest = kNoSite;
  double minFraction = 1.0;
  for (std::uint32_t d = 0; d < kNeighbours; ++d) {
    const std::uint32_t other = neighbour(cut.lattice, site, d);
    const std::uint32_t c = other == kNoSite ? kNoSite : cut.cutOfEdge[edgeNumber(cut.lattice, site, d)];
    if (c == kNoSite) continue;
    const double length = (sitePosition(cut.lattice, other) - cut.positions[site]).norm();
    const double fraction = (cut.cuts[c] - cut.positions[site]).norm() / length;
    if (fraction >= (d % kEdgesPerSite < kLongEdges ? kWarpLong : kWarpShort) || fraction >= minFraction)
      continue;
    nearest = c;
    minFraction = fraction;
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
      if (neighbour(cut.lattice, site, d) != kNoSite)
        cut.cutOfEdge[edgeNumber(cut.lattice, site, d)] = kNoSite;
  }
}

/// The first three steps of isosurface stuffing: the side of the surface on which each site lies, the cuts of
/// edges with ends on both sides, and the warp. In the warp, a site with a cut nearer than a fraction of the
/// edge moves to this cut, and the other cuts of its edges are removed.
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

using Sites = std::array<std::uint32_t, 4>;

// The last step of isosurface stuffing: the inside part of each lattice tetrahedron is split into one to
// three tetrahedra. Neighbours use the same diagonals of the faces between them.

/// Corners of the new tetrahedra are sites, or cuts: the index of the cut plus the number of sites.
struct Filling {
  const CutLattice& cut;
  std::vector<Tetrahedron> tetrahedra;

  Vector3d position(std::uint32_t corner) const {
    const std::uint32_t sites = cut.lattice.size();
    return corner < sites ? cut.positions[corner] : cut.cuts[corner - sites];
  }
  std::uint32_t cutBetween(std::uint32_t a, std::uint32_t b) const {
    const BccLattice& l = cut.lattice;
    return l.size() + cut.cutOfEdge[edgeNumber(l, a, directionTo(l, a, b))];
  }
  bool joinedByLongEdge(std::uint32_t a, std::uint32_t b) const { return (a ^ b) % 2 == 0; }
};

/// Returns the sites in the order inside, on the surface, outside, with the same orientation.
Sites sortBySide(Sites sites, const std::vector<std::int8_t>& side) {
  bool odd = false;
  for (std::size_t pass = 0; pass < 3; ++pass)
    for (std::size_t i = 0; i + 1 < 4; ++i)
      if (side[sites[i]] < side[sites[i + 1]]) {
        std::swap(sites[i], sites[i + 1]);
        odd = !odd;
      }
  if (!odd) return sites;
  // two of the four are on the same side: swapping them restores the orientation
  for (std::size_t i = 0; i + 1 < 4; ++i)
    if (side[sites[i]] == side[sites[i + 1]]) {
      std::swap(sites[i], sites[i + 1]);
      break;
    }
  return sites;
}

bool isShorter(const Filling& f, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return (f.position(a) - f.position(b)).squaredNorm() < (f.position(c) - f.position(d)).squaredNorm();
}

/// For a face with a and b inside and m outside, cut at a' and b': returns whether its quadrilateral
/// a b b' a' is split from a to b' rather than from b to a'. The result depends on the face alone, so both
/// tetrahedra at the face agree. The diagonal ends at the cut of the long edge. If both cuts are on short
/// edges, the shorter diagonal is used. Then no three faces of a tetrahedron can have diagonals that form a
/// cycle, which could not be filled.
bool splitsFromFirst(const Filling& f, std::uint32_t a, std::uint32_t b, std::uint32_t m) {
  if (f.joinedByLongEdge(a, m)) return false;
  if (f.joinedByLongEdge(b, m)) return true;
  const bool swapped = b < a;  // makes the choice for equal lengths the same from both sides
  if (swapped) std::swap(a, b);
  return isShorter(f, a, f.cutBetween(b, m), b, f.cutBetween(a, m)) != swapped;
}

/// Adds a prism from the triangle p to the triangle q on its positive side. diagonal[i]: its side from
/// i to i + 1 is split from p_i to q_(i+1) rather than from p_(i+1) to q_i; not all three may be equal. Then
/// one p_i has two diagonals, one q_j has two as well, and the third tetrahedron has the other corners k of
/// both triangles.
void addPrism(Filling& f, const std::array<std::uint32_t, 3>& p, const std::array<std::uint32_t, 3>& q,
              const std::array<bool, 3>& diagonal) {
  std::size_t i = 0, j = 0;
  while (!(diagonal[i] && !diagonal[(i + 2) % 3])) ++i;
  while (!(!diagonal[j] && diagonal[(j + 2) % 3])) ++j;
  const std::size_t k = 3 - i - j;
  f.tetrahedra.push_back({p[0], p[1], p[2], q[j]});
  f.tetrahedra.push_back({q[0], q[2], q[1], p[i]});
  if ((i + 1) % 3 == j)
    f.tetrahedra.push_back({p[i], p[k], q[k], q[j]});
  else
    f.tetrahedra.push_back({p[i], p[k], q[j], q[k]});
}

/// Adds the inside part of a tetrahedron with one site inside, the others on the surface or outside.
void addTip(Filling& f, const Sites& s) {
  Tetrahedron t{s[0], s[1], s[2], s[3]};
  for (std::size_t i = 1; i < 4; ++i)
    if (f.cut.side[s[i]] < 0) t[i] = f.cutBetween(s[0], s[i]);
  f.tetrahedra.push_back(t);
}

/// Adds the inside part with two sites inside, one on the surface, one outside: a pyramid.
void addPyramid(Filling& f, const Sites& s) {
  const std::uint32_t a = s[0], b = s[1], top = s[2];
  const std::uint32_t aCut = f.cutBetween(a, s[3]), bCut = f.cutBetween(b, s[3]);
  if (splitsFromFirst(f, a, b, s[3])) {
    f.tetrahedra.push_back({a, b, top, bCut});
    f.tetrahedra.push_back({a, bCut, top, aCut});
  } else {
    f.tetrahedra.push_back({a, b, top, aCut});
    f.tetrahedra.push_back({aCut, b, top, bCut});
  }
}

/// Adds the inside part with two sites inside, two outside. The side of the prism that lies in the surface
/// belongs to this tetrahedron alone.
void addWedge(Filling& f, const Sites& s) {
  const std::array<std::uint32_t, 3> p{s[0], f.cutBetween(s[0], s[2]), f.cutBetween(s[0], s[3])};
  const std::array<std::uint32_t, 3> q{s[1], f.cutBetween(s[1], s[2]), f.cutBetween(s[1], s[3])};
  const bool first = splitsFromFirst(f, s[0], s[1], s[2]), last = !splitsFromFirst(f, s[0], s[1], s[3]);
  const bool middle = first == last ? !first : isShorter(f, p[1], q[2], p[2], q[1]);
  addPrism(f, p, q, {first, middle, last});
}

/// Adds the inside part with three sites inside, one outside: a tetrahedron without its tip.
void addTrunk(Filling& f, const Sites& s) {
  const std::array<std::uint32_t, 3> p{s[0], s[1], s[2]};
  std::array<std::uint32_t, 3> q{};
  std::array<bool, 3> diagonal{};
  for (std::size_t i = 0; i < 3; ++i) {
    q[i] = f.cutBetween(p[i], s[3]);
    diagonal[i] = splitsFromFirst(f, p[i], p[(i + 1) % 3], s[3]);
  }
  addPrism(f, p, q, diagonal);
}

void addInside(Filling& f, const Sites& sites) {
  const Sites s = sortBySide(sites, f.cut.side);
  const auto inside = std::count_if(s.begin(), s.end(), [&](auto i) { return f.cut.side[i] > 0; });
  const auto outside = std::count_if(s.begin(), s.end(), [&](auto i) { return f.cut.side[i] < 0; });
  if (inside == 0) return;
  if (outside == 0)
    f.tetrahedra.push_back({s[0], s[1], s[2], s[3]});
  else if (inside == 1)
    addTip(f, s);
  else if (inside == 3)
    addTrunk(f, s);
  else if (outside == 1)
    addPyramid(f, s);
  else
    addWedge(f, s);
}

TetrahedralMesh numberPoints(const Filling& f) {
  TetrahedralMesh mesh;
  Renumbering numbers(f.cut.lattice.size() + f.cut.cuts.size());
  for (const Tetrahedron& t : f.tetrahedra) mesh.tetrahedra.push_back(numbers(t));
  for (const std::uint32_t corner : numbers.kept()) mesh.points.push_back(f.position(corner));
  return mesh;
}

}  // namespace

TetrahedralMesh fillLattice(const BccLattice& lattice, const TriangleBvh& surface) {
  const CutLattice cut = cutLattice(lattice, surface);
  Filling filling{cut, {}};
  for (std::uint32_t site = 0; site < cut.lattice.size(); site += 2)
    for (int axis = 0; axis < 3; ++axis)
      for (int quarter = 0; quarter < 4; ++quarter) {
        const Sites sites = latticeTetrahedron(cut.lattice, site, axis, quarter);
        if (sites[0] != kNoSite) addInside(filling, sites);
      }
  return numberPoints(filling);
}

}  // namespace limber

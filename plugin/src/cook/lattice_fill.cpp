// SPDX-License-Identifier: Zlib
#include "cook/lattice_fill.h"

#include <algorithm>
#include <utility>

namespace limber {
namespace {

using Eigen::Vector3d;
using Sites = std::array<std::uint32_t, 4>;

/// Corners of the tetrahedra being made are sites, or cuts: their index plus the number of sites.
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

/// The sites in the order inside, on the surface, outside, with the orientation kept.
Sites sortBySide(Sites sites, const std::vector<std::int8_t>& side) {
  bool odd = false;
  for (std::size_t pass = 0; pass < 3; ++pass)
    for (std::size_t i = 0; i + 1 < 4; ++i)
      if (side[sites[i]] < side[sites[i + 1]]) {
        std::swap(sites[i], sites[i + 1]);
        odd = !odd;
      }
  if (!odd) return sites;
  // two of the four are on the same side: exchanging them restores the orientation
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

/// Of a face with a and b inside and m outside, cut at a' and b': whether its quadrilateral a b b' a' is
/// split from a to b' rather than from b to a'. It depends on the face alone, so both tetrahedra at the face
/// agree. The diagonal ends at the cut of the long edge; with both cuts on short edges the shorter one is
/// taken. No three faces of a tetrahedron can then have diagonals that run in a circle, which could not be
/// filled.
bool splitsFromFirst(const Filling& f, std::uint32_t a, std::uint32_t b, std::uint32_t m) {
  if (f.joinedByLongEdge(a, m)) return false;
  if (f.joinedByLongEdge(b, m)) return true;
  const bool swapped = b < a;  // equal lengths: the same choice from both sides
  if (swapped) std::swap(a, b);
  return isShorter(f, a, f.cutBetween(b, m), b, f.cutBetween(a, m)) != swapped;
}

/// A prism from the triangle p to the triangle q, which lies on its positive side. diagonal[i]: its side from
/// i to i + 1 is split from p_i to q_(i+1) rather than from p_(i+1) to q_i; not all three alike. Then one p_i
/// has two diagonals, one q_j too, and the third tetrahedron has the other corners k of both triangles.
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

/// One site inside, the others on the surface or outside.
void addTip(Filling& f, const Sites& s) {
  Tetrahedron t{s[0], s[1], s[2], s[3]};
  for (std::size_t i = 1; i < 4; ++i)
    if (f.cut.side[s[i]] < 0) t[i] = f.cutBetween(s[0], s[i]);
  f.tetrahedra.push_back(t);
}

/// Two inside, one on the surface, one outside: a pyramid.
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

/// Two inside, two outside. The side of the prism in the surface belongs to this tetrahedron alone.
void addWedge(Filling& f, const Sites& s) {
  const std::array<std::uint32_t, 3> p{s[0], f.cutBetween(s[0], s[2]), f.cutBetween(s[0], s[3])};
  const std::array<std::uint32_t, 3> q{s[1], f.cutBetween(s[1], s[2]), f.cutBetween(s[1], s[3])};
  const bool first = splitsFromFirst(f, s[0], s[1], s[2]), last = !splitsFromFirst(f, s[0], s[1], s[3]);
  const bool middle = first == last ? !first : isShorter(f, p[1], q[2], p[2], q[1]);
  addPrism(f, p, q, {first, middle, last});
}

/// Three inside, one outside: a tetrahedron without its tip.
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

TetrahedralMesh numbered(const Filling& f) {
  TetrahedralMesh mesh;
  std::vector<std::uint32_t> pointOf(f.cut.lattice.size() + f.cut.cuts.size(), kNoSite);
  for (const Tetrahedron& t : f.tetrahedra) {
    mesh.tetrahedra.push_back(t);
    for (std::uint32_t& corner : mesh.tetrahedra.back()) {
      std::uint32_t& point = pointOf[corner];
      if (point == kNoSite) {
        point = static_cast<std::uint32_t>(mesh.points.size());
        mesh.points.push_back(f.position(corner));
      }
      corner = point;
    }
  }
  return mesh;
}

}  // namespace

TetrahedralMesh fillLattice(const CutLattice& cut) {
  Filling filling{cut, {}};
  for (std::uint32_t site = 0; site < cut.lattice.size(); site += 2)
    for (int axis = 0; axis < 3; ++axis)
      for (int quarter = 0; quarter < 4; ++quarter) {
        const Sites sites = latticeTetrahedron(cut.lattice, site, axis, quarter);
        if (sites[0] != kNoSite) addInside(filling, sites);
      }
  return numbered(filling);
}

}  // namespace limber

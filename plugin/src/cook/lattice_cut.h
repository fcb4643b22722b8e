// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/bcc_lattice.h"
#include "mesh/triangle_bvh.h"

#include <cstdint>
#include <vector>

namespace limber {

/// A lattice that knows where a closed surface cuts it, drawn onto the surface where that is near.
struct CutLattice {
  BccLattice lattice;
  std::vector<std::int8_t> side;           ///< #sites, 1 inside, -1 outside, 0 on the surface
  std::vector<Eigen::Vector3d> positions;  ///< #sites, m
  std::vector<std::uint32_t> cutOfEdge;    ///< kEdgesPerSite x #sites, index of a cut, or kNoSite
  std::vector<Eigen::Vector3d> cuts;       ///< #cuts, m, where an edge leaves the inside
};

/// The first three steps of isosurface stuffing (F. Labelle, J. R. Shewchuk, "Isosurface stuffing: fast
/// tetrahedral meshes with good dihedral angles", SIGGRAPH 2007): on which side of the surface each site
/// lies, where edges between the sides meet it, and the warp: a site one of whose cuts is nearer than a share
/// of the edge moves there, which the other cuts of its edges make way for.
CutLattice cutLattice(const BccLattice& lattice, const TriangleBvh& surface);

}  // namespace limber

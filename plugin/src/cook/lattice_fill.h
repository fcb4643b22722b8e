// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/lattice_cut.h"
#include "cook/tetrahedra.h"

namespace limber {

/// The last step of isosurface stuffing: the part of each lattice tetrahedron that is inside, as one to three
/// tetrahedra, which agree with their neighbours' about the diagonals of the faces between them. Points are
/// numbered in the order of their first use; the surface is left empty.
TetrahedralMesh fillLattice(const CutLattice& cut);

}  // namespace limber

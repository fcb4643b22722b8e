// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace limber::bench {

/// A body of a material, and the same on a lattice that gives four times as many points.
struct MaterialRow {
  std::string mesh;
  std::size_t points = 0, finePoints = 0;
  double youngError = 0.0;    ///< of the modulus asked for, after calibration
  double calibration = 0.0;   ///< drift of the fine body's modulus, with the coarse one's calibration
  double bending = 0.0;       ///< drift of the mean bending modulus, each body with its own calibration
  double worstBending = 0.0;  ///< of any of the six
  double isotropy = 0.0;      ///< smallest over largest modulus of 40 directions
  double poissonRatio = 0.0;
};

/// A bar 4 : 1 of square section, against beam theory: the measured over the requested Young's modulus.
struct BeamRow {
  std::size_t points = 0;
  double tension = 0.0, bending = 0.0, torsion = 0.0;
};

/// How stiff the L is against being opened, braced against of tetrahedra, each relative to its bulk modulus.
struct MaterialResults {
  std::vector<MaterialRow> rows;
  std::vector<BeamRow> beams;  ///< 2, 4 and 8 cells across; with --quick only the first two
  double openingRatio = 0.0;   ///< see measureOpening
};

MaterialResults measureMaterials(bool quick);
std::string materialTable(const MaterialResults& results);
std::string materialTargets(const MaterialResults& results);

}  // namespace limber::bench

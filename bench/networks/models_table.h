// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber::bench {

/// A difficult mesh of meshes/, as cook() makes it and as it ends after a drop.
struct ModelRow {
  std::string mesh, form;  ///< form: solid, cloth, rope; wrapped, thickened
  std::size_t vertices = 0, bodies = 0, points = 0, springs = 0, tetrahedra = 0;
  double seconds = 0.0;                  ///< of this thread, to cook it
  double megabytes = 0.0;                ///< most that the process has held so far
  std::uint32_t runs = 0, returned = 0;  ///< of the largest body; sheets and ropes have no shape to return to
  double shapeError =
      0.0;          ///< largest RMS error of a solid at the end of the drop, as a fraction of the size
  std::string end;  ///< reason of a failed end check, or empty
};

/// Cooks and drops the meshes whose names contain `part`. `runs`: large deformations of each. Minutes.
std::vector<ModelRow> measureModels(const std::string& part, std::uint32_t runs);
std::string modelTable(const std::vector<ModelRow>& rows);
std::string modelTargets(const std::vector<ModelRow>& rows);

}  // namespace limber::bench

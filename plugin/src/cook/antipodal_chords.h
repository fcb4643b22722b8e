// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/inside_chords.h"

namespace limber {

/// A chord from each point along its inward normal through the body: to the corner nearest to where the ray
/// meets the surface again, or the next nearest if that chord leaves the body. Joins them in `chords` and
/// returns them, in the order of the points. `triangles` are those of the surface, turned as in it.
std::vector<Edge> antipodalChords(const std::vector<Eigen::Vector3d>& points,
                                  const std::vector<Triangle>& triangles, InsideChords& chords);

}  // namespace limber

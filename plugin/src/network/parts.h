// SPDX-License-Identifier: Zlib
// Declares the parts of a mesh that become bodies.
#pragma once

#include <limber/mesh.h>
#include <limber/result.h>

#include <vector>

namespace limber {

/// A part of a mesh that becomes one body.
struct Part {
  TriangleMesh mesh;
  WeldedMesh welded;
};

/// Splits a mesh into parts, the largest first: pieces that the wrapped surface joins stay together. If there
/// were more than 32 parts, or if they may not be apart, the whole mesh is one. Parts of less than half a
/// percent of the largest one's size are left out. Errors: those of weld() and wrap().
Result<std::vector<Part>> splitIntoParts(const TriangleMesh& mesh, const WrapSettings& settings,
                                         bool mayBeApart);

/// Returns the wrap of a mesh without hollows, at least `thickness` (m) thick everywhere. Pieces that are
/// apart are joined by rods: a part is one body. Errors: those of wrap().
Result<WeldedMesh> wrapOutside(const TriangleMesh& mesh, WrapSettings settings, double thickness);

}  // namespace limber

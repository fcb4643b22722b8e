// SPDX-License-Identifier: Zlib
// Declares the parts of a mesh that become bodies, and the recognition of
// parts that are sheets or thin tubes.
#pragma once

#include <limber/cook.h>

#include <Eigen/Core>

#include <cstddef>
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

// --- sheets and ropes --------------------------------------------------------------------------------------

/// The smallest box around points that has one side in the direction in which these spread least.
struct FlatBox {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: along, across, normal; a rotation
  Eigen::Vector3d size = Eigen::Vector3d::Zero();      ///< m, in these directions
};
FlatBox flatBoxOf(const std::vector<Eigen::Vector3d>& points);

/// Returns the share of the area that faces along the normal or against it, within 60 degrees: 2/3 of a round
/// wire across.
double facingShare(const WeldedMesh& mesh, const Eigen::Vector3d& normal);

/// Returns a cloth if the mesh is one piece that is flat, or open with a border that is long for its area: as
/// a disc has it, and not a ball with holes. Of a flat closed plate it is the front side. The cloth has the
/// mesh's points, or about `points` (0: 800) if these are more; coarse meshes are divided so that they can
/// fold. Its thickness is that of the plate, or half a percent of the size. Returns null of other meshes.
SharedNetwork sheetOf(const TriangleMesh& mesh, const WeldedMesh& welded, std::size_t points);

/// Returns a rope along the middle of the mesh if this is one piece, a tube without branches that is at least
/// 25 times as long as it is thick, or null.
SharedNetwork ropeOf(const WeldedMesh& welded);

}  // namespace limber

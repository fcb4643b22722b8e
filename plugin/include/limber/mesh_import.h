// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/triangle_mesh.h>

#include <string>

namespace limber {

/// All triangle meshes of a file in any format assimp reads, joined into one: polygons triangulated, node
/// transforms applied, texture coordinates (first set) and normals kept when every mesh of the file has them,
/// vertices stored once that are equal bit for bit in all of these. Positions are in the file's units.
/// Errors name the file and the reason: missing or unreadable file, no triangles, and everything
/// validate(TriangleMesh) refuses, with the index.
/// Damaged OBJ, STL, PLY and OFF files give errors; assimp's readers of richer formats (COLLADA, FBX, ...)
/// can crash on files made to harm, so take those from people you trust. OFF files: assimp moves indices out
/// of range to the last vertex without a word. Thread rule: any thread; calls are independent. Needs the
/// library limber_import (assimp).
Result<TriangleMesh> importMesh(const std::string& path);

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/triangle_mesh.h>

#include <string>

namespace limber {

/// Reads all triangle meshes of a file in any format that assimp reads, and joins them into one. Polygons are
/// triangulated and node transforms are applied. Normals and the first set of texture coordinates are kept if
/// every mesh of the file has them. Vertices that are bit-equal in all of these are stored once. Positions
/// are in the file's units. Errors name the file and the reason: missing or unreadable file, no triangles,
/// and everything that validate(TriangleMesh) rejects, with the index. Damaged OBJ, STL, PLY and OFF files
/// give errors. The assimp readers of richer formats (COLLADA, FBX, ...) can crash on malicious files, so
/// load these formats only from trusted sources. In OFF files assimp replaces indices that are out of range
/// by the last vertex, without a message. Thread rule: any thread; calls are independent. Needs the library
/// limber_import (assimp).
Result<TriangleMesh> importMesh(const std::string& path);

}  // namespace limber

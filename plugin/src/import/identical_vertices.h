// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/triangle_mesh.h>

namespace limber {

/// Stores vertices once that are equal bit for bit in position, normal and texture coordinates: many file
/// readers give every corner a vertex of its own, and each of them would be moved and uploaded in every
/// frame. Keeps the order of first occurrence. The mesh must be valid.
void joinIdenticalVertices(TriangleMesh& mesh);

}  // namespace limber

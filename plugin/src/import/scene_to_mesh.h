// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/triangle_mesh.h>

#include <string>

struct aiScene;

namespace limber {

/// The first mesh or index in the scene that must not be followed, or an empty string.
std::string checkScene(const aiScene& scene);

/// The faces of all meshes at all nodes as triangles, in the coordinates of the root; points and lines are
/// left out. The scene must have passed checkScene().
TriangleMesh joinMeshes(const aiScene& scene);

}  // namespace limber

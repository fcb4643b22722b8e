// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/triangle_mesh.h>

#include <string>

struct aiScene;

namespace limber {

/// The first mesh or index in the scene that must not be followed, or an empty string.
std::string checkScene(const aiScene& scene);

/// The triangles of all meshes at all nodes, in the coordinates of the root. The scene must have passed
/// checkScene() and be triangulated; points and lines are left out.
TriangleMesh joinMeshes(const aiScene& scene);

}  // namespace limber

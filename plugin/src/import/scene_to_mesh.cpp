// SPDX-License-Identifier: Zlib
#include "import/scene_to_mesh.h"

#include "import/polygon_triangles.h"

#include <assimp/scene.h>

#include <Eigen/Geometry>

#include <vector>

namespace limber {
namespace {

/// A mesh at a node; a mesh that two nodes refer to has two placements.
struct Placement {
  const aiMesh* mesh;
  Eigen::Matrix3d linear;
  Eigen::Vector3d origin;
};

Eigen::Vector3d toEigen(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Eigen::Matrix4d toEigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d matrix;
  matrix << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4;
  return matrix;
}

/// Faces of one or two corners are points and lines.
bool isPolygon(const aiFace& face) { return face.mNumIndices >= 3; }

bool hasPolygons(const aiMesh& mesh) {
  for (unsigned face = 0; face < mesh.mNumFaces; ++face) {
    if (isPolygon(mesh.mFaces[face])) return true;
  }
  return false;
}

/// Those that are there: assimp's RAW reader leaves some out.
std::vector<const aiNode*> childrenOf(const aiNode& node) {
  std::vector<const aiNode*> children;
  for (unsigned i = 0; node.mChildren != nullptr && i < node.mNumChildren; ++i) {
    if (node.mChildren[i] != nullptr) children.push_back(node.mChildren[i]);
  }
  return children;
}

void collectPlacements(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& parent,
                       std::vector<Placement>& placements) {
  const Eigen::Matrix4d toRoot = parent * toEigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh* mesh = scene.mMeshes[node.mMeshes[i]];
    if (hasPolygons(*mesh))
      placements.push_back({mesh, toRoot.topLeftCorner<3, 3>(), toRoot.topRightCorner<3, 1>()});
  }
  for (const aiNode* child : childrenOf(node)) collectPlacements(scene, *child, toRoot, placements);
}

template <class Has>
bool allHave(const std::vector<Placement>& placements, Has has) {
  for (const Placement& placement : placements) {
    if (!has(*placement.mesh)) return false;
  }
  return true;
}

void addPositions(const Placement& placement, std::vector<Eigen::Vector3d>& positions) {
  for (unsigned i = 0; i < placement.mesh->mNumVertices; ++i) {
    positions.push_back(placement.linear * toEigen(placement.mesh->mVertices[i]) + placement.origin);
  }
}

/// Normals go with the inverse transpose of the linear part, which is its cofactor matrix / determinant. The
/// cofactors (cross products of the columns) exist even when the determinant is 0; of it only the sign
/// matters.
void addNormals(const Placement& placement, std::vector<Eigen::Vector3f>& normals) {
  const Eigen::Matrix3d& m = placement.linear;
  Eigen::Matrix3d cofactors;
  cofactors << m.col(1).cross(m.col(2)), m.col(2).cross(m.col(0)), m.col(0).cross(m.col(1));
  if (m.determinant() < 0.0) cofactors = -cofactors;
  for (unsigned i = 0; i < placement.mesh->mNumVertices; ++i) {
    normals.push_back((cofactors * toEigen(placement.mesh->mNormals[i])).normalized().cast<float>());
  }
}

void addUvs(const Placement& placement, std::vector<Eigen::Vector2f>& uvs) {
  for (unsigned i = 0; i < placement.mesh->mNumVertices; ++i) {
    const aiVector3D& uv = placement.mesh->mTextureCoords[0][i];
    uvs.emplace_back(static_cast<float>(uv.x), static_cast<float>(uv.y));
  }
}

std::vector<Triangle> splitFace(const aiMesh& mesh, const aiFace& face) {
  if (face.mNumIndices == 3) return {{0, 1, 2}};
  std::vector<Eigen::Vector3d> corners;
  for (unsigned i = 0; i < face.mNumIndices; ++i)
    corners.push_back(toEigen(mesh.mVertices[face.mIndices[i]]));
  return splitPolygon(corners);
}

/// A mirror turns the order of the corners around.
void addTriangles(const Placement& placement, std::uint32_t firstVertex, std::vector<Triangle>& triangles) {
  const bool mirrored = placement.linear.determinant() < 0.0;
  for (unsigned i = 0; i < placement.mesh->mNumFaces; ++i) {
    const aiFace& face = placement.mesh->mFaces[i];
    if (!isPolygon(face)) continue;
    for (const Triangle& corner : splitFace(*placement.mesh, face)) {
      const auto vertex = [&](std::size_t k) { return firstVertex + face.mIndices[corner[k]]; };
      triangles.push_back({vertex(0), vertex(mirrored ? 2 : 1), vertex(mirrored ? 1 : 2)});
    }
  }
}

std::string checkFaces(const aiMesh& mesh, unsigned meshIndex) {
  for (unsigned face = 0; face < mesh.mNumFaces; ++face) {
    for (unsigned corner = 0; corner < mesh.mFaces[face].mNumIndices; ++corner) {
      const unsigned vertex = mesh.mFaces[face].mIndices[corner];
      if (vertex < mesh.mNumVertices) continue;
      return "face " + std::to_string(face) + " of mesh " + std::to_string(meshIndex) + " uses vertex " +
             std::to_string(vertex) + " of " + std::to_string(mesh.mNumVertices);
    }
  }
  return {};
}

std::string checkNode(const aiScene& scene, const aiNode& node) {
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    if (node.mMeshes[i] < scene.mNumMeshes) continue;
    return "node '" + std::string(node.mName.C_Str()) + "' uses mesh " + std::to_string(node.mMeshes[i]) +
           " of " + std::to_string(scene.mNumMeshes);
  }
  for (const aiNode* child : childrenOf(node)) {
    std::string reason = checkNode(scene, *child);
    if (!reason.empty()) return reason;
  }
  return {};
}

}  // namespace

std::string checkScene(const aiScene& scene) {
  if (scene.mRootNode == nullptr) return "the file has no scene";
  std::string reason = checkNode(scene, *scene.mRootNode);
  for (unsigned i = 0; i < scene.mNumMeshes && reason.empty(); ++i) reason = checkFaces(*scene.mMeshes[i], i);
  return reason;
}

TriangleMesh joinMeshes(const aiScene& scene) {
  std::vector<Placement> placements;
  collectPlacements(scene, *scene.mRootNode, Eigen::Matrix4d::Identity(), placements);
  const bool withNormals = allHave(placements, [](const aiMesh& mesh) { return mesh.HasNormals(); });
  const bool withUvs = allHave(placements, [](const aiMesh& mesh) { return mesh.HasTextureCoords(0); });

  TriangleMesh joined;
  for (const Placement& placement : placements) {
    addTriangles(placement, static_cast<std::uint32_t>(joined.positions.size()), joined.triangles);
    addPositions(placement, joined.positions);
    if (withNormals) addNormals(placement, joined.normals);
    if (withUvs) addUvs(placement, joined.uvs);
  }
  return joined;
}

}  // namespace limber

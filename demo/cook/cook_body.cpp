// SPDX-License-Identifier: Zlib
#include "cook/cook_body.h"

#include <limber/mesh_import.h>
#include <limber/simplify_mesh.h>

#include <utility>

namespace limber::demo {
namespace {

TriangleMesh meshOf(WeldedMesh welded) {
  TriangleMesh mesh;
  mesh.positions = std::move(welded.points);
  mesh.triangles = std::move(welded.triangles);
  return mesh;
}

/// The network drawn as `mesh`, which must not be the one it was made of.
Result<SharedNetwork> skinned(Result<SharedNetwork> network, const TriangleMesh& mesh,
                              const SkinSettings& settings) {
  return network ? withSkin(**network, mesh, settings) : network;
}

Result<SharedNetwork> cookMaterial(const TriangleMesh& mesh, const CookOptions& options) {
  const double tolerance = options.network.weldTolerance;
  if (tolerance == 0.0 && !options.skin) return buildMaterialNetwork(mesh, options.materialMesh);
  Result<WeldedMesh> welded = weld(mesh, tolerance);
  if (!welded) return Error{welded.error()};
  const SkinSettings skin = options.skin.value_or(SkinSettings{SkinKind::Barycentric, 32, tolerance});
  return skinned(buildMaterialNetwork(meshOf(std::move(*welded)), options.materialMesh), mesh, skin);
}

Result<SharedNetwork> cookSimplified(const TriangleMesh& mesh, WeldedMesh welded,
                                     const CookOptions& options) {
  if (options.network.progress) options.network.progress("simplify", 0.0);
  const Result<TriangleMesh> coarse = simplify(meshOf(std::move(welded)), options.points);
  if (!coarse) return Error{coarse.error()};
  if (options.network.progress) options.network.progress("simplify", 1.0);
  SkinSettings skin = options.skin.value_or(SkinSettings{});
  skin.weldTolerance = options.network.weldTolerance;
  return skinned(buildNetwork(*coarse, options.network), mesh, skin);
}

Result<SharedNetwork> cookMesh(const TriangleMesh& mesh, const CookOptions& options) {
  if (options.material) return cookMaterial(mesh, options);
  if (options.points == 0) return buildNetwork(mesh, options.network);
  Result<WeldedMesh> welded = weld(mesh, options.network.weldTolerance);
  if (!welded) return Error{welded.error()};
  // coarse enough as it is: its vertices then ride on the points themselves
  if (welded->points.size() <= options.points) return buildNetwork(mesh, options.network);
  return cookSimplified(mesh, std::move(*welded), options);
}

}  // namespace

Result<SharedNetwork> cookBody(const CookOptions& options) {
  const Result<TriangleMesh> mesh = importMesh(options.meshFile);
  if (!mesh) return Error{mesh.error()};
  Result<SharedNetwork> network = cookMesh(*mesh, options);
  return network ? network : Error{options.meshFile + ": " + network.error()};
}

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#include "scenes/read_network.h"

#include <limber/mesh_import.h>
#include <limber/network_builder.h>
#include <limber/network_file.h>

namespace limber::scenes {

bool isLimberFile(const std::string& file) {
  const std::string ending = ".limber";
  return file.size() > ending.size() && file.compare(file.size() - ending.size(), ending.size(), ending) == 0;
}

Result<SharedNetwork> readNetwork(const std::string& file) {
  if (isLimberFile(file)) return loadNetwork(file);
  const Result<TriangleMesh> mesh = importMesh(file);
  if (!mesh) return Error{mesh.error()};
  Result<SharedNetwork> network = buildNetwork(*mesh);
  if (!network) return Error{file + ": " + network.error()};
  return network;
}

}  // namespace limber::scenes

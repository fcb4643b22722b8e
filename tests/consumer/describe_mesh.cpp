// SPDX-License-Identifier: Zlib
// Describes the network of a mesh file: a program that uses the import and the analysis without Bullet.
#include <limber/mesh.h>
#include <limber/network_analysis.h>
#include <limber/network_builder.h>

#include <cstdio>

int main(int count, char** arguments) {
  const limber::Result<limber::TriangleMesh> mesh = limber::importMesh(count > 1 ? arguments[1] : "");
  const auto network = mesh ? limber::buildNetwork(*mesh) : limber::Error{mesh.error()};
  if (!network) {
    std::fprintf(stderr, "%s\n", network.error().c_str());
    return 1;
  }
  std::printf("%s", describe(limber::analyse(**network)).c_str());
  return 0;
}

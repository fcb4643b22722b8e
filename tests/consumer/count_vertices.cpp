// SPDX-License-Identifier: Zlib
// Prints the number of vertices of a mesh file: a program that uses the import without Bullet.
#include <limber/mesh.h>

#include <cstdio>

int main(int count, char** arguments) {
  const limber::Result<limber::TriangleMesh> mesh = limber::importMesh(count > 1 ? arguments[1] : "");
  if (!mesh) {
    std::fprintf(stderr, "%s\n", mesh.error().c_str());
    return 1;
  }
  std::printf("%zu vertices\n", mesh->positions.size());
  return 0;
}

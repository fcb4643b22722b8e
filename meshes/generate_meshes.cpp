// SPDX-License-Identifier: Zlib
// Writes the meshes of this folder: limber_generate_meshes <folder>
#include "box_shapes.h"
#include "figure.h"
#include "round_shapes.h"

#include <array>
#include <cstdio>
#include <fstream>

namespace {

struct NamedShape {
  const char* name;
  shapes::TriangleSoup (*make)();
};

constexpr std::array<NamedShape, 7> kShapes{{{"cube", shapes::makeCube},
                                             {"icosphere", shapes::makeIcosphere},
                                             {"torus", shapes::makeTorus},
                                             {"cylinder", shapes::makeCylinder},
                                             {"l_shape", shapes::makeLShape},
                                             {"star", shapes::makeStar},
                                             {"figure", shapes::makeFigure}}};

/// Binary, so that line ends are the same everywhere.
bool writeShape(const NamedShape& shape, const std::string& folder) {
  const std::string path = folder + "/" + shape.name + ".obj";
  std::ofstream file(path, std::ios::binary);
  file << shapes::toObjText(shape.make(), shape.name);
  file.close();
  if (!file) std::fprintf(stderr, "cannot write %s\n", path.c_str());
  return bool(file);
}

}  // namespace

int main(int argumentCount, char** arguments) {
  if (argumentCount != 2) {
    std::fprintf(stderr, "usage: limber_generate_meshes <folder>\n");
    return 2;
  }
  for (const NamedShape& shape : kShapes) {
    if (!writeShape(shape, arguments[1])) return 1;
  }
  return 0;
}

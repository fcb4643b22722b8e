// SPDX-License-Identifier: Zlib
// Writes the meshes of this folder, or those that are named: limber_generate_meshes <folder> [<mesh>...]

#include "shapes.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

namespace {

struct NamedShape {
  std::string name;
  shapes::TriangleSoup (*make)();
  shapes::ObjFormat format;
};

const std::vector<NamedShape> kShapes{{"cube", shapes::makeCube, {}},
                                      {"icosphere", shapes::makeIcosphere, {}},
                                      {"torus", shapes::makeTorus, {}},
                                      {"cylinder", shapes::makeCylinder, {}},
                                      {"l_shape", shapes::makeLShape, {}},
                                      {"star", shapes::makeStar, {}},
                                      {"figure", shapes::makeFigure, {}},
                                      {"animal", shapes::makeAnimal, {1.0, 1e-4, false}},
                                      {"teapot", shapes::makeTeapot, {1.0, 1e-4, false}},
                                      {"head", shapes::makeHead, {1.0, 1e-4, false}},
                                      {"ogre", shapes::makeOgre, {100.0, 1e-2, false}},
                                      {"bunny", shapes::makeBunny, {1.0, 1e-4, false}},
                                      {"car", shapes::makeCar, {1000.0, 0.1, false}},
                                      {"puppet", shapes::makePuppet, {1.0, 1e-4, false}}};

/// Binary, so that line ends are the same everywhere.
bool writeShape(const NamedShape& shape, const std::string& folder) {
  const std::string path = folder + "/" + shape.name + ".obj";
  std::ofstream file(path, std::ios::binary);
  file << shapes::toObjText(shape.make(), shape.name, shape.format);
  file.close();
  if (!file) std::fprintf(stderr, "cannot write %s\n", path.c_str());
  return bool(file);
}

/// The shapes with these names, all if there are no names. Empty if a name is unknown.
std::vector<NamedShape> findShapes(const std::vector<std::string>& names) {
  if (names.empty()) return kShapes;
  std::vector<NamedShape> found;
  for (const std::string& name : names) {
    const auto shape = std::find_if(kShapes.begin(), kShapes.end(),
                                    [&](const NamedShape& candidate) { return candidate.name == name; });
    if (shape == kShapes.end()) {
      std::fprintf(stderr, "no mesh is called %s\n", name.c_str());
      return {};
    }
    found.push_back(*shape);
  }
  return found;
}

}  // namespace

int main(int argumentCount, char** arguments) {
  if (argumentCount < 2) {
    std::fprintf(stderr, "usage: limber_generate_meshes <folder> [<mesh>...]\n");
    return 2;
  }
  const std::vector<NamedShape> chosen = findShapes({arguments + 2, arguments + argumentCount});
  for (const NamedShape& shape : chosen) {
    if (!writeShape(shape, arguments[1])) return 1;
  }
  return chosen.empty() ? 2 : 0;
}

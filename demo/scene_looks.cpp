// SPDX-License-Identifier: Zlib
#include "scene_looks.h"

#include <unordered_map>

namespace limber::demo {

view::SoftView::Look softLooks(const scenes::Scene& scene, render::TextureId checker) {
  std::unordered_map<const SoftBody*, view::SoftLook> looks;
  for (std::size_t b = 0; b < scene.looks.size(); ++b) {
    const scenes::BodyLook& look = scene.looks[b];
    view::SoftLook& shown = looks[scene.soft->body(b)];
    shown.shading = look.smooth ? render::Shading::Smooth : render::Shading::Flat;
    shown.instance = {toVec3(look.colour), look.checkered ? checker : render::TextureId{}};
  }
  return [looks = std::move(looks)](const SoftBody& body) { return looks.at(&body); };
}

view::RigidView::Look rigidLooks(const scenes::Scene& scene) {
  std::unordered_map<const btCollisionObject*, render::InstanceLook> looks;
  for (const scenes::RigidLook& look : scene.rigidLooks) looks[look.body] = {toVec3(look.colour), {}};
  return [looks = std::move(looks)](const btCollisionObject& object) { return looks.at(&object); };
}

render::Image checkerTexture() {
  constexpr int kSquares = 8, kSquarePixels = 32;
  constexpr std::uint8_t kLight = 255, kDark = 168;
  render::Image image;
  image.resize(kSquares * kSquarePixels, kSquares * kSquarePixels);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const bool light = (x / kSquarePixels + y / kSquarePixels) % 2 == 0;
      std::uint8_t* pixel = image.pixel(x, y);
      pixel[0] = pixel[1] = pixel[2] = light ? kLight : kDark;
      pixel[3] = 255;
    }
  }
  return image;
}

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#include "test_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "limber/render/gl_debug_messages.h"
#include "limber/render/gl_functions.h"

namespace limber::render::test {
namespace {

void addSpring(Scenery& scenery, std::uint32_t a, std::uint32_t b) {
  const float* p = scenery.points.data() + 3 * a;
  const float* q = scenery.points.data() + 3 * b;
  scenery.shape.lines.insert(scenery.shape.lines.end(), {a, b});
  scenery.shape.lineRestLengths.push_back(std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
}

}  // namespace

RendererDesc smallDesc(ComputeOn computeOn) {
  RendererDesc desc;
  desc.width = kWidth;
  desc.height = kHeight;
  desc.shadowMapSize = 512;
  desc.textureSize = 64;
  desc.computeOn = computeOn;
  return desc;
}

Stage::Stage(Backend backend, const RendererDesc& desc) {
  ContextDesc contextDesc;
  contextDesc.backend = backend;
  context_ = createContext(contextDesc);
  renderer_ = std::make_unique<Renderer>(*context_, desc);
  camera.eye = {2.5f, 2.2f, 4.5f};
  camera.target = {0.0f, 0.5f, 0.0f};
  light.shadowRadius = 4.0f;
}

Renderer& Stage::renderer() {
  context_->makeCurrent();
  return *renderer_;
}

Stage::~Stage() {
  context_->makeCurrent();
  EXPECT_NO_THROW(checkGlErrors(renderer_->gl(), "end of the test"));
  const DebugMessages& messages = *renderer_->debugMessages();
  EXPECT_EQ(messages.complaints(), 0u) << messages.lastComplaint();
}

InstanceId Stage::add(ShapeId shape, std::vector<float> points, const InstanceLook& look) {
  const InstanceId id = renderer().addInstance(shape, look);
  actors_.push_back({id, std::move(points)});
  return id;
}

InstanceId Stage::add(const Scenery& scenery, const InstanceLook& look) {
  return add(renderer().addShape(scenery.shape), scenery.points, look);
}

void Stage::remove(InstanceId id) {
  renderer().removeInstance(id);
  actors_.erase(std::remove_if(actors_.begin(), actors_.end(),
                               [id](const Actor& a) {
                                 return a.id.index == id.index && a.id.generation == id.generation;
                               }),
                actors_.end());
}

void Stage::draw(const DrawOptions& options) {
  FrameWriter frame = renderer().beginFrame();
  write(frame);
  renderer_->draw(frame, camera, light, options, overlay);
}

Image Stage::picture(const DrawOptions& options) {
  draw(options);
  return renderer().readPixels();
}

std::vector<float> moved(std::vector<float> points, float x, float y, float z) {
  for (std::size_t i = 0; i < points.size(); i += 3) {
    points[i] += x;
    points[i + 1] += y;
    points[i + 2] += z;
  }
  return points;
}

Scenery springBox(float halfExtent) {
  Scenery box = makeBox({}, {halfExtent, halfExtent, halfExtent});
  for (std::uint32_t a = 0; a < 8; ++a) {
    for (std::uint32_t b = a + 1; b < 8; ++b) {
      addSpring(box, a, b);
    }
  }
  return box;
}

Scenery cloth(std::uint32_t n) {
  Scenery sheet;
  sheet.shape.name = "cloth";
  sheet.shape.pointCount = n * n;
  sheet.shape.shading = Shading::Smooth;
  sheet.shape.twoSided = true;
  for (std::uint32_t i = 0; i < n * n; ++i) {
    const float u = static_cast<float>(i % n) / static_cast<float>(n - 1);
    const float v = static_cast<float>(i / n) / static_cast<float>(n - 1);
    sheet.shape.uvs.insert(sheet.shape.uvs.end(), {u, v});
    sheet.points.insert(sheet.points.end(), {1.2f * u, 0.15f * std::sin(6.0f * u + 3.0f * v), 1.2f * v});
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      addSpring(sheet, j * n + i, j * n + i + 1);
      if (j + 1 < n) {
        const std::uint32_t a = j * n + i;
        sheet.shape.triangles.insert(sheet.shape.triangles.end(), {a, a + n, a + 1, a + 1, a + n, a + n + 1});
      }
    }
  }
  return sheet;
}

Scenery rope(std::uint32_t points) {
  Scenery tube;
  tube.shape.name = "rope";
  tube.shape.pointCount = points;
  tube.shape.tubeRadius = 0.08f;
  for (std::uint32_t i = 0; i < points; ++i) {
    const auto x = static_cast<float>(i);
    tube.points.insert(tube.points.end(), {0.2f * x, 0.1f * std::sin(x), 0.15f * std::cos(0.8f * x)});
  }
  for (std::uint32_t i = 0; i + 1 < points; ++i) {
    addSpring(tube, i, i + 1);
  }
  return tube;
}

Scenery skinnedBall(std::uint32_t cells) {
  constexpr float kRadius = 0.4f;
  const Scenery ball = makeUvSphere({}, kRadius, 10, 14);
  Scenery skinned;
  skinned.shape = ball.shape;
  skinned.shape.name = "skinned ball";
  const std::uint32_t side = cells + 1;
  skinned.shape.pointCount = side * side * side;
  const auto cell = static_cast<float>(cells);
  for (std::uint32_t i = 0; i < skinned.shape.pointCount; ++i) {
    for (const std::uint32_t k : {i % side, i / side % side, i / side / side}) {
      skinned.points.push_back(kRadius * (2.0f * static_cast<float>(k) / cell - 1.0f));
    }
  }
  Skin& skin = skinned.shape.skin;
  skin.first = {0};
  for (std::size_t p = 0; p < ball.points.size(); p += 3) {
    std::array<std::uint32_t, 3> low{};
    std::array<float, 3> fraction{};
    for (std::size_t c = 0; c < 3; ++c) {
      const float coordinate = 0.5f * cell * (ball.points[p + c] / kRadius + 1.0f);
      low[c] = std::min(static_cast<std::uint32_t>(std::max(coordinate, 0.0f)), cells - 1);
      fraction[c] = coordinate - static_cast<float>(low[c]);
    }
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
      float weight = 1.0f;
      std::uint32_t index = 0;
      std::uint32_t stride = 1;
      for (std::size_t c = 0; c < 3; ++c, stride *= side) {
        const std::uint32_t bit = corner >> c & 1u;
        weight *= bit != 0 ? fraction[c] : 1.0f - fraction[c];
        index += stride * (low[c] + bit);
      }
      skin.points.push_back(index);
      skin.weights.push_back(weight);
    }
    skin.first.push_back(static_cast<std::uint32_t>(skin.weights.size()));
  }
  return skinned;
}

void populateMeshes(Stage& stage) {
  Renderer& renderer = stage.renderer();
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < 32 * 32; ++i) {
    const bool dark = ((i / 4) + (i / 128)) % 2 == 0;
    pixels.insert(pixels.end(), {dark ? std::uint8_t{40} : std::uint8_t{240}, 120, 200, 255});
  }
  const TextureId texture = renderer.addTexture(32, 32, pixels.data());
  stage.add(makeFloor({}, 8.0f), {{0.93f, 0.92f, 0.90f}, {}});
  const Scenery box = springBox(0.25f);
  const ShapeId boxShape = renderer.addShape(box.shape);
  for (int i = 0; i < 6; ++i) {
    const auto f = static_cast<float>(i);
    std::vector<float> points = moved(box.points, 0.7f * f - 1.8f, 0.25f + 0.1f * f, -0.8f);
    points[1] += 0.05f * f;
    stage.add(boxShape, points, {{0.2f + 0.1f * f, 0.5f, 0.4f}, i % 2 == 0 ? texture : TextureId{}});
  }
  const Scenery ball = makeUvSphere({}, 0.4f, 8, 12);
  const ShapeId ballShape = renderer.addShape(ball.shape);
  stage.add(ballShape, moved(ball.points, -0.9f, 0.5f, 0.4f), {{0.3f, 0.5f, 0.8f}, {}});
  stage.add(ballShape, moved(ball.points, 0.1f, 0.4f, 0.6f), {{1.0f, 1.0f, 1.0f}, texture});
  const Scenery sheet = cloth(9);
  const ShapeId sheetShape = renderer.addShape(sheet.shape);
  stage.add(sheetShape, moved(sheet.points, 0.6f, 0.9f, -0.2f), {{0.8f, 0.4f, 0.3f}, {}});
  stage.add(sheetShape, moved(sheet.points, -1.8f, 1.3f, -0.6f), {{0.9f, 0.8f, 0.3f}, texture});
}

void populate(Stage& stage) {
  populateMeshes(stage);
  const Scenery tube = rope(7);
  const ShapeId tubeShape = stage.renderer().addShape(tube.shape);
  stage.add(tubeShape, moved(tube.points, -0.6f, 0.2f, 1.3f), {{0.6f, 0.4f, 0.7f}, {}});
  stage.add(tubeShape, moved(tube.points, -0.2f, 0.3f, 1.8f), {{0.4f, 0.6f, 0.4f}, {}});
  for (const std::uint32_t cells : {1u, 3u}) {
    const Scenery skinned = skinnedBall(cells);
    const ShapeId skinnedShape = stage.renderer().addShape(skinned.shape);
    const float x = cells == 1 ? 1.2f : 1.7f;
    stage.add(skinnedShape, moved(skinned.points, x, 0.4f, 1.0f), {{0.3f, 0.7f, 0.6f}, {}});
    stage.add(skinnedShape, moved(skinned.points, x, 1.2f, 0.3f), {{0.7f, 0.7f, 0.3f}, {}});
  }
}

int brightness(const Image& image, int x, int y) {
  const std::uint8_t* p = image.pixel(x, y);
  return p[0] + p[1] + p[2];
}

int largestDifference(const Image& a, const Image& b) {
  if (a.rgba.size() != b.rgba.size()) {
    throw std::runtime_error("pictures of different sizes");
  }
  int largest = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    largest = std::max(largest, std::abs(int{a.rgba[i]} - int{b.rgba[i]}));
  }
  return largest;
}

double differingShare(const Image& a, const Image& b, int tolerance) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    bool differs = false;
    for (std::size_t c = i; c < i + 4; ++c) {
      differs = differs || std::abs(int{a.rgba[c]} - int{b.rgba[c]}) > tolerance;
    }
    count += differs ? 1u : 0u;
  }
  return 4.0 * static_cast<double>(count) / static_cast<double>(a.rgba.size());
}

}  // namespace limber::render::test

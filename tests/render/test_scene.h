// SPDX-License-Identifier: Zlib
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "limber/render/gl_context.h"
#include "limber/render/renderer.h"
#include "limber/render/scenery.h"

namespace limber::render::test {

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr int kMiddleX = kWidth / 2;
constexpr int kMiddleY = kHeight / 2;

/// Small pictures, so that tests are fast.
RendererDesc smallDesc();

/// A renderer on a context of its own. Every test that uses it ends with the demand that OpenGL had
/// nothing to complain about.
class Stage {
 public:
  explicit Stage(Backend backend = Backend::Auto, const RendererDesc& desc = smallDesc());
  ~Stage();
  /// Several stages may live at once: each call makes the stage's own context current.
  Renderer& renderer();

  /// Adds an instance whose points are `points` in every frame until changed.
  InstanceId add(ShapeId shape, std::vector<float> points, const InstanceLook& look = {});
  InstanceId add(const Scenery& scenery, const InstanceLook& look = {});
  void remove(InstanceId id);
  /// Writes all points and draws.
  void draw(const DrawOptions& options = {}, StreamPath path = StreamPath::Ring);
  Image picture(const DrawOptions& options = {}, StreamPath path = StreamPath::Ring);

  Camera camera;
  Light light;
  Overlay overlay;

 private:
  struct Actor {
    InstanceId id;
    std::vector<float> points;
  };

  std::unique_ptr<GlContext> context_;
  std::unique_ptr<Renderer> renderer_;
  std::vector<Actor> actors_;
};

std::vector<float> moved(std::vector<float> points, float x, float y, float z);

/// A cube with its edges as springs, somewhat squeezed by the caller if wanted.
Scenery springBox(float halfExtent);
/// A two-sided smooth sheet of n x n points with springs and texture coordinates.
Scenery cloth(std::uint32_t n);
/// A tube through `points` points along a wave.
Scenery rope(std::uint32_t points);

/// A smooth ball of radius 0.4 whose vertices follow the (cells + 1)^3 corners of a grid of cells over
/// [-0.4, 0.4]^3, trilinearly: each has eight weights, which make a dense skin of one cell and a sparse
/// one of more.
Scenery skinnedBall(std::uint32_t cells);

/// Floor, cubes, textured and plain spheres, and cloth.
void populateMeshes(Stage& stage);
/// These, ropes and skinned balls: a little of everything.
void populate(Stage& stage);

/// Brightness of a pixel, 0 to 765.
int brightness(const Image& image, int x, int y);
/// Largest difference of any channel.
int largestDifference(const Image& a, const Image& b);

}  // namespace limber::render::test

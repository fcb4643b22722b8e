// SPDX-License-Identifier: Zlib
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
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

/// Settings for small pictures, which make tests fast.
RendererDesc smallDesc(ComputeOn computeOn = ComputeOn::Auto);

/// A renderer with its own context. Every test with it fails at the end if OpenGL has reported an error.
class Stage {
 public:
  explicit Stage(Backend backend = Backend::Auto, const RendererDesc& desc = smallDesc());
  ~Stage();
  /// Makes the stage's own context current, so that several stages can exist at once.
  Renderer& renderer();

  /// Adds an instance whose points are `points` in every frame until changed.
  InstanceId add(ShapeId shape, std::vector<float> points, const InstanceLook& look = {});
  InstanceId add(const Scenery& scenery, const InstanceLook& look = {});
  void remove(InstanceId id);
  /// Writes all points and draws.
  void draw(const DrawOptions& options = {});
  Image picture(const DrawOptions& options = {});
  /// Writes all points into a FrameWriter or a bench::Baseline.
  template <typename Frame>
  void write(const Frame& frame) const {
    for (const Actor& actor : actors_) {
      std::copy(actor.points.begin(), actor.points.end(), frame.points(actor.id));
    }
  }

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

/// Returns a cube with springs between all its points.
Scenery springBox(float halfExtent);
/// Returns a two-sided smooth sheet of n x n points with springs and texture coordinates.
Scenery cloth(std::uint32_t n);
/// Returns a tube through `points` points along a wave.
Scenery rope(std::uint32_t points);

/// Returns a smooth ball of radius 0.4 whose vertices follow the (cells + 1)^3 corners of a grid of cells
/// over [-0.4, 0.4]^3, trilinearly. Each vertex has eight weights, which give a dense skin for one cell and a
/// sparse one for more.
Scenery skinnedBall(std::uint32_t cells);

/// Adds a floor, cubes, textured and plain spheres, and cloth.
void populateMeshes(Stage& stage);
/// Adds the same, ropes and skinned balls.
void populate(Stage& stage);

/// Returns the brightness of a pixel, 0 to 765.
int brightness(const Image& image, int x, int y);
/// Returns the largest difference of any channel.
int largestDifference(const Image& a, const Image& b);
/// Returns the share of the pixels of which a channel differs by more than `tolerance`.
double differingShare(const Image& a, const Image& b, int tolerance);

}  // namespace limber::render::test

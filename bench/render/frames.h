// SPDX-License-Identifier: Zlib
#pragma once

#include "bench.h"
#include "render/baselines/baseline.h"
#include "results.h"

#include <limber/render/camera.h>
#include <limber/render/gl_context.h>
#include <limber/render/light.h>
#include <limber/render/renderer.h>
#include <limber/render/scenery.h>
#include <Eigen/Geometry>

#include <memory>
#include <string>
#include <vector>

namespace limber::bench {

// --- scenes ---

/// Bodies of one shape over a floor that deform without being simulated.
struct FrameScene {
  std::string name;
  render::ShapeDesc shape;
  Eigen::Matrix3Xf rest;     ///< m, points of a body around its middle
  Eigen::Matrix3Xf centres;  ///< m, of the bodies
  render::Scenery floor;

  std::size_t bodies() const { return static_cast<std::size_t>(centres.cols()); }
  std::size_t points() const;     ///< that are written each frame: of all bodies and the floor
  std::size_t triangles() const;  ///< likewise
  render::Camera camera(float aspect) const;
  render::Light light(bool shadows) const;

 private:
  Eigen::AlignedBox3f box() const;
};

/// A square of cubes of 8 points and 12 triangles with flat sides.
FrameScene makeCubeScene(std::size_t count);
/// One smooth closed body of 50 002 points and 100 000 triangles, or of a tenth as many.
FrameScene makeBallScene(bool tenth);

/// The points of all bodies, one body after the other, in frame number `frame`.
void pose(const FrameScene& scene, int frame, Eigen::Matrix3Xf& points);

// --- paths and stages ---

/// A method of drawing.
struct DrawPath {
  const char* name;
  std::unique_ptr<Baseline> (*makeBaseline)(render::Renderer&);  ///< nullptr: the renderer itself draws
  bool usesShapes;  ///< whether it reads the renderer's data of shapes in each frame
};

/// Limber: positions straight into the mapped buffer, a draw per shape. Points body by body: positions
/// uploaded and drawn body by body, normals by the shaders. Vertices body by body: as the paper and Bullet's
/// example browser do, vertices and normals made on the CPU.
const std::vector<DrawPath>& drawPaths();

struct DrawContext {
  const char* name;
  render::Backend backend;
};

std::unique_ptr<render::GlContext> makeContext(const DrawContext& context);

/// What is drawn, and how large.
struct FrameCase {
  const FrameScene* scene;
  int width, height;  ///< pixels
  bool shadows;
  render::ComputeOn computeOn = render::ComputeOn::Auto;  ///< of the renderer itself; baselines use the GPU
};

/// Milliseconds of one frame. The first four follow one another, so they add up to the whole frame but for
/// some microseconds.
struct FrameTimes {
  double upload = 0.0;   ///< opening the frame, writing all positions where the path wants them, and what it
                         ///< makes of them on this thread: normals, vertices, uploads, the instances' table
  double submit = 0.0;   ///< all draw calls and dispatches; software drivers shade the vertices in them, and
                         ///< wait for the shadow map before the first draw that reads it
  double finish = 0.0;   ///< waiting for the picture
  double read = 0.0;     ///< copying it
  double frame = 0.0;    ///< the whole
  double own = 0.0;      ///< upload and submit in this thread's own time, so without such waits
  double process = 0.0;  ///< the whole in the time of all threads, a software rasteriser's included
};

/// A renderer on a context of its own that draws a case in one way.
class FrameStage {
 public:
  FrameStage(const FrameCase& frameCase, const DrawPath& path, const DrawContext& context);
  ~FrameStage();
  /// The next so many bodies of the scene; at first there is only the floor.
  void addBodies(std::size_t count);

  /// Draws the bodies that were added with these points, see pose(), and reads the picture.
  FrameTimes play(const Eigen::Matrix3Xf& points);

  const DrawPath& path() const { return path_; }
  const DrawContext& context() const { return drawContext_; }
  const render::FrameStats& lastFrame() const { return renderer_->lastFrame(); }
  /// Of the buffers that this path needs.
  std::size_t bufferBytes() const;
  std::string driver() const;

 private:
  template <class Frame>
  void write(const Frame& frame, const Eigen::Matrix3Xf& points) const;

  const FrameScene& scene_;
  DrawPath path_;
  DrawContext drawContext_;
  render::Camera camera_;
  render::Light light_;
  std::unique_ptr<render::GlContext> context_;
  std::unique_ptr<render::Renderer> renderer_;
  std::unique_ptr<Baseline> baseline_;  // nullptr: the renderer itself draws
  render::InstanceId floor_;
  render::ShapeId shape_;
  std::vector<render::InstanceId> bodies_;
  render::Image image_;
};

// --- the parts of the bench ---

/// Frames before the measured ones: shaders are compiled, each region of the ring is touched.
constexpr int kWarmUp = 4;

/// Turns of each path or method, and frames in each turn. The first frame of a turn is not measured.
struct Turns {
  int blocks = 5, framesPerBlock = 6;
};

/// Adds the medians of all parts of FrameTimes.
void addTimes(const Subject& subject, const std::vector<FrameTimes>& samples, Results& results);

/// What bodies of a skin cost, skins.cpp: 1280x720 without shadows, the skin computed by the renderer's
/// compute shader, by the renderer on the CPU, or by the program with applySkin(), which then streams all
/// vertices.
void measureSkins(const DrawContext& context, bool quick, const Turns& turns, Results& results);

}  // namespace limber::bench

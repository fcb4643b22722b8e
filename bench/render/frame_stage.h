// SPDX-License-Identifier: Zlib
#pragma once

#include "render/baselines/baseline.h"
#include "render/frame_scene.h"

#include <limber/render/gl_context.h>
#include <limber/render/renderer.h>

#include <memory>
#include <vector>

namespace limber::bench {

class Stopwatch;

/// A way of drawing.
struct DrawPath {
  const char* name;
  std::unique_ptr<Baseline> (*makeBaseline)(render::Renderer&);  ///< nullptr: the renderer itself draws
  bool usesShapes;  ///< whether it reads the renderer's data of shapes in each frame
};

/// limber: positions straight into the mapped buffer, a draw per shape. naive_points: positions uploaded and
/// drawn body by body, normals by the shaders. naive: as the paper and Bullet's example browser do, vertices
/// and normals made on the CPU.
const std::vector<DrawPath>& drawPaths();

struct DrawContext {
  const char* name;
  render::Backend backend;
};

const std::vector<DrawContext>& drawContexts();

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
  double drawItself(const Eigen::Matrix3Xf& points, const Stopwatch& watch);
  double drawBaseline(const Eigen::Matrix3Xf& points, const Stopwatch& watch);

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

}  // namespace limber::bench

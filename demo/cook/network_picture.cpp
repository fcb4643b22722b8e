// SPDX-License-Identifier: Zlib
#include "cook/network_picture.h"

#include "cook/cook_names.h"
#include "cook/cook_report.h"
#include "cook/network_scenery.h"
#include "cook/picture_legend.h"
#include "scene_looks.h"

#include <limber/render/gl_context.h>
#include <limber/render/renderer.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace limber::demo {
namespace {

constexpr render::Vec3 kWallColour{0.86f, 0.89f, 0.93f};
constexpr render::Vec3 kLineColour{0.60f, 0.60f, 0.61f};  // what the renderer draws uncoloured lines in
// Okabe and Ito's colours, which colour-blind people tell apart as well
constexpr std::array<render::Vec3, 4> kKindColours{
    {kLineColour, {0.0f, 0.62f, 0.45f}, {0.0f, 0.45f, 0.70f}, {0.84f, 0.37f, 0.0f}}};
constexpr std::array<SpringKind, 3> kRodKinds{SpringKind::Shear, SpringKind::Bending, SpringKind::Brace};

/// A rod is as thick as it can be without hiding others: the more there are, the thinner.
double rodRadius(const SpringNetwork& network, double size) {
  double length = 0.0;
  for (const NetworkSpring& spring : network.springs)
    length += (network.restPoints[spring.a] - network.restPoints[spring.b]).norm();
  const double mean = length / static_cast<double>(std::max<std::size_t>(network.springs.size(), 1));
  return std::min(0.03 * mean, 0.006 * size);
}

/// Things that do not move, and their instances.
class StillLife {
 public:
  explicit StillLife(render::Renderer& renderer) : renderer_(renderer) {}

  void add(render::Scenery scenery, const render::Vec3& colour) {
    if (scenery.points.empty()) return;
    render::InstanceLook look;
    look.colour = colour;
    const render::ShapeId shape = renderer_.addShape(scenery.shape);
    things_.push_back({renderer_.addInstance(shape, look), std::move(scenery.points)});
  }

  render::Image draw(const render::Camera& camera, const render::Light& light,
                     const render::DrawOptions& options) {
    render::FrameWriter frame = renderer_.beginFrame();
    for (const auto& [instance, points] : things_)
      std::copy(points.begin(), points.end(), frame.points(instance));
    renderer_.draw(frame, camera, light, options);
    return renderer_.readPixels();
  }

 private:
  render::Renderer& renderer_;
  std::vector<std::pair<render::InstanceId, std::vector<float>>> things_;
};

render::Camera cameraFor(const Eigen::AlignedBox3d& box, int width, int height) {
  const float aspect = static_cast<float>(width) / static_cast<float>(height);
  return render::frameBox(toVec3(box.min()), toVec3(box.max()), {0.45f, 0.4f, 1.0f}, aspect);
}

render::Light plainLight() {
  render::Light light;
  light.towards = {-0.2f, 0.75f, 0.65f};
  light.sun = {0.35f, 0.35f, 0.35f};  // little against the sky: walls differ, but none is dark
  light.sky = {0.75f, 0.75f, 0.75f};
  light.ground = {0.55f, 0.55f, 0.55f};
  light.shadows = false;  // rods would cast them on each other, and there are enough lines without
  return light;
}

render::DrawOptions drawOptions(int height) {
  render::DrawOptions options;
  options.mode = render::DrawMode::Wireframe;
  options.lineWidth = std::max(1.0f, static_cast<float>(height) / 720.0f);
  options.legend = false;  // that of strain
  options.backgroundTop = options.backgroundBottom = {1.0f, 1.0f, 1.0f};
  return options;
}

std::vector<LegendEntry> legendOf(const SpringNetwork& network) {
  const auto counts = springCounts(network);
  std::vector<LegendEntry> entries;
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    if (counts[kind] == 0) continue;
    const std::string text = std::to_string(counts[kind]) + " " + kSpringKinds.names[kind];
    entries.push_back({text, kKindColours[kind]});
  }
  return entries;
}

}  // namespace

render::Image drawNetwork(const SpringNetwork& network, int width, int height) {
  const Eigen::AlignedBox3d box = boundsOf(network);
  const double size = box.diagonal().norm(), radius = rodRadius(network, size);
  const auto context = render::createContext();
  render::RendererDesc desc;
  desc.width = width;
  desc.height = height;
  desc.samples = 4;
  render::Renderer renderer(*context, desc);
  StillLife things(renderer);
  things.add(farWalls(network, 0.004 * size), kWallColour);
  things.add(springLines(network, SpringKind::Structural), kLineColour);
  for (const SpringKind kind : kRodKinds)
    things.add(springRods(network, kind, radius), kKindColours[static_cast<std::size_t>(kind)]);
  render::Image image = things.draw(cameraFor(box, width, height), plainLight(), drawOptions(height));
  drawLegend(image, legendOf(network));
  return image;
}

}  // namespace limber::demo

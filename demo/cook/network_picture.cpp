// SPDX-License-Identifier: Zlib
#include "cook/network_picture.h"

#include "cook/cook_options.h"
#include "cook/cook_report.h"
#include "scene_renderer.h"

#include <limber/render/gl_context.h>
#include <limber/render/renderer.h>
#include <limber/render/text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace limber::demo {
namespace {

constexpr std::uint32_t kSides = 6;
constexpr double kTwoPi = 6.283185307179586;

void addPoint(std::vector<float>& points, const Eigen::Vector3d& p) {
  for (int axis = 0; axis < 3; ++axis) points.push_back(static_cast<float>(p[axis]));
}

/// Adds six points around each end and two triangles for each side.
void addRod(render::Scenery& rods, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius) {
  const Eigen::Vector3d along = (b - a).normalized();
  const Eigen::Vector3d across = along.unitOrthogonal(), third = along.cross(across);
  const std::uint32_t first = rods.shape.pointCount;
  for (std::uint32_t side = 0; side < kSides; ++side) {
    const double angle = kTwoPi * side / kSides;
    const Eigen::Vector3d out = radius * (std::cos(angle) * across + std::sin(angle) * third);
    addPoint(rods.points, a + out);
    addPoint(rods.points, b + out);
    const std::uint32_t current = first + 2 * side, next = first + 2 * ((side + 1) % kSides);
    for (const std::uint32_t corner : {current, next, next + 1, current, next + 1, current + 1})
      rods.shape.triangles.push_back(corner);
  }
  rods.shape.pointCount += 2 * kSides;
}

std::vector<Eigen::Vector3d> pointNormals(const SpringNetwork& network) {
  std::vector<Eigen::Vector3d> normals(network.restPoints.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : network.surface) {
    const Eigen::Vector3d& a = network.restPoints[t[0]];
    const Eigen::Vector3d twiceArea = (network.restPoints[t[1]] - a).cross(network.restPoints[t[2]] - a);
    for (const std::uint32_t corner : t) normals[corner] += twiceArea;
  }
  for (Eigen::Vector3d& normal : normals) normal.normalize();
  return normals;
}

}  // namespace

Eigen::AlignedBox3d boundsOf(const SpringNetwork& network) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : network.restPoints) box.extend(p);
  return box;
}

render::Scenery springLines(const SpringNetwork& network, SpringKind kind) {
  render::Scenery lines;
  lines.shape.name = "spring lines";
  for (const NetworkSpring& spring : network.springs) {
    if (spring.kind == kind) lines.shape.lines.insert(lines.shape.lines.end(), {spring.a, spring.b});
  }
  if (lines.shape.lines.empty()) return lines;
  lines.shape.pointCount = static_cast<std::uint32_t>(network.restPoints.size());
  for (const Eigen::Vector3d& p : network.restPoints) addPoint(lines.points, p);
  return lines;
}

render::Scenery springRods(const SpringNetwork& network, SpringKind kind, double radius) {
  render::Scenery rods;
  rods.shape.name = "spring rods";
  rods.shape.shading = render::Shading::Smooth;
  for (const NetworkSpring& spring : network.springs) {
    if (spring.kind == kind) addRod(rods, network.restPoints[spring.a], network.restPoints[spring.b], radius);
  }
  return rods;
}

render::Scenery farWalls(const SpringNetwork& network, double distance) {
  render::Scenery walls;
  walls.shape.name = "far walls";
  if (network.surface.empty()) return walls;
  walls.shape.pointCount = static_cast<std::uint32_t>(network.restPoints.size());
  const std::vector<Eigen::Vector3d> normals = pointNormals(network);
  for (std::size_t i = 0; i < normals.size(); ++i)
    addPoint(walls.points, network.restPoints[i] + distance * normals[i]);
  for (const Triangle& t : network.surface)
    for (const std::uint32_t corner : {t[0], t[2], t[1]}) walls.shape.triangles.push_back(corner);
  return walls;
}

namespace {

constexpr int kSquare = 7, kLine = 11, kGap = 6;  // dots
constexpr render::Vec3 kInk{0.15f, 0.15f, 0.17f};

std::uint8_t byteOf(float share) { return static_cast<std::uint8_t>(std::lround(255.0f * share)); }

/// Fills a rectangle in pixels, clipped at the picture's edges.
void fill(render::Image& image, int left, int top, int width, int height, const render::Vec3& colour) {
  for (int y = std::max(top, 0); y < std::min(top + height, image.height); ++y) {
    for (int x = std::max(left, 0); x < std::min(left + width, image.width); ++x) {
      std::uint8_t* pixel = image.pixel(x, y);
      pixel[0] = byteOf(colour.x);
      pixel[1] = byteOf(colour.y);
      pixel[2] = byteOf(colour.z);
    }
  }
}

}  // namespace

void drawLegend(render::Image& image, const std::vector<LegendEntry>& entries) {
  const int dot = std::max(1, image.height / (48 * kSquare));  // pixels
  int top = kLine * dot;
  for (const LegendEntry& entry : entries) {
    int left = kLine * dot;
    fill(image, left, top, kSquare * dot, kSquare * dot, entry.colour);
    left += (kSquare + kGap) * dot;
    for (const render::TextBar& bar : render::textBars(entry.text))
      fill(image, left + dot * int(bar.left), top + dot * int(bar.top), dot * int(bar.width),
           dot * int(bar.height), kInk);
    top += kLine * dot;
  }
}

namespace {

constexpr render::Vec3 kWallColour{0.86f, 0.89f, 0.93f};
constexpr render::Vec3 kLineColour{0.60f, 0.60f, 0.61f};  // the renderer's colour of lines without strain
// colours by Okabe and Ito, which colour-blind people can distinguish
constexpr std::array<render::Vec3, 4> kKindColours{
    {kLineColour, {0.0f, 0.62f, 0.45f}, {0.0f, 0.45f, 0.70f}, {0.84f, 0.37f, 0.0f}}};
constexpr std::array<SpringKind, 3> kRodKinds{SpringKind::Shear, SpringKind::Bending, SpringKind::Brace};

/// Returns the radius of rods; it is smaller for shorter springs, so that rods do not hide each other.
double rodRadius(const SpringNetwork& network, double size) {
  double length = 0.0;
  for (const NetworkSpring& spring : network.springs)
    length += (network.restPoints[spring.a] - network.restPoints[spring.b]).norm();
  const double mean = length / static_cast<double>(std::max<std::size_t>(network.springs.size(), 1));
  return std::min(0.03 * mean, 0.006 * size);
}

/// Shapes that do not move, and their instances.
class StaticShapes {
 public:
  explicit StaticShapes(render::Renderer& renderer) : renderer_(renderer) {}

  void add(render::Scenery scenery, const render::Vec3& colour) {
    if (scenery.points.empty()) return;
    render::InstanceLook look;
    look.colour = colour;
    const render::ShapeId shape = renderer_.addShape(scenery.shape);
    instances_.push_back({renderer_.addInstance(shape, look), std::move(scenery.points)});
  }

  render::Image draw(const render::Camera& camera, const render::Light& light,
                     const render::DrawOptions& options) {
    render::FrameWriter frame = renderer_.beginFrame();
    for (const auto& [instance, points] : instances_)
      std::copy(points.begin(), points.end(), frame.points(instance));
    renderer_.draw(frame, camera, light, options);
    return renderer_.readPixels();
  }

 private:
  render::Renderer& renderer_;
  std::vector<std::pair<render::InstanceId, std::vector<float>>> instances_;
};

const Eigen::Vector3d kTowardsEye(0.45, 0.4, 1.0);

/// Returns the network without the springs on the eye's side of a plane through its middle, across its
/// thinnest extent, if they hide braces.
SpringNetwork cutAway(SpringNetwork network) {
  const auto isBrace = [](const NetworkSpring& spring) { return spring.kind == SpringKind::Brace; };
  if (std::none_of(network.springs.begin(), network.springs.end(), isBrace)) return network;
  const Eigen::AlignedBox3d box = boundsOf(network);
  Eigen::Index axis = 0;
  box.sizes().minCoeff(&axis);
  const auto isInFront = [&](const NetworkSpring& spring) {
    return network.restPoints[spring.a][axis] + network.restPoints[spring.b][axis] > 2.0 * box.center()[axis];
  };
  network.springs.erase(std::remove_if(network.springs.begin(), network.springs.end(), isInFront),
                        network.springs.end());
  return network;
}

render::Camera cameraFor(const Eigen::AlignedBox3d& box, int width, int height) {
  const float aspect = static_cast<float>(width) / static_cast<float>(height);
  return render::frameBox(toVec3(box.min()), toVec3(box.max()), toVec3(kTowardsEye), aspect);
}

render::Light plainLight() {
  render::Light light;
  light.towards = {-0.2f, 0.75f, 0.65f};
  light.sun = {0.35f, 0.35f, 0.35f};  // weak against the sky: walls differ in brightness, but none is dark
  light.sky = {0.75f, 0.75f, 0.75f};
  light.ground = {0.55f, 0.55f, 0.55f};
  light.shadows = false;  // shadows of rods on rods would look like more lines
  return light;
}

render::DrawOptions drawOptions(int height) {
  render::DrawOptions options;
  options.mode = render::DrawMode::Wireframe;
  options.lineWidth = std::max(1.0f, static_cast<float>(height) / 720.0f);
  options.legend = false;  // the legend of strain
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
  const SpringNetwork cut = cutAway(network);
  const auto context = render::createContext();
  render::RendererDesc desc;
  desc.width = width;
  desc.height = height;
  desc.samples = 4;
  desc.quality = render::Quality::Gallery;
  render::Renderer renderer(*context, desc);
  StaticShapes shapes(renderer);
  shapes.add(farWalls(network, 0.004 * size), kWallColour);
  shapes.add(springLines(cut, SpringKind::Structural), kLineColour);
  for (const SpringKind kind : kRodKinds)
    shapes.add(springRods(cut, kind, radius), kKindColours[static_cast<std::size_t>(kind)]);
  render::Image image =
      shapes.draw(cameraFor(box, width, height),
                  render::lightBox(toVec3(box.min()), toVec3(box.max()), plainLight()), drawOptions(height));
  drawLegend(image, legendOf(network));
  return image;
}

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#include "scene_renderer.h"

#include "scenes/end_checks.h"
#include "scenes/scene.h"

#include <limber/view/velocity_arrows.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace limber::demo {
namespace {

constexpr double kTwoPi = 6.283185307179586;
// rad; sides of a twelve-sided cylinder are smooth, those of a box sharp
constexpr float kSharpAngle = 0.75f;
constexpr float kThreads = 90.0f;             // of a cloth
constexpr float kTranslucency = 0.35f;        // of jelly, in sizes of the body
constexpr float kNear = 0.02f, kFar = 40.0f;  // in distances of the user's camera from its target
constexpr float kFloorSizes = 40.0f;          // half sides of the floor, in sizes of what is shown

render::Material materialOf(scenes::Finish finish, double size) {
  switch (finish) {
    case scenes::Finish::Jelly:
      return render::Material::jelly(kTranslucency * static_cast<float>(size));
    case scenes::Finish::Cloth:
      return render::Material::cloth(kThreads);
    case scenes::Finish::Metal:
      return render::Material::metal();
    case scenes::Finish::Rubber:
      break;
  }
  return render::Material::rubber();
}

/// Returns the largest extent of a body at rest, m.
double sizeOf(const SoftBody& body) { return scenes::sizeOf(scenes::restShape(body)); }

}  // namespace

/// Extends the view by bodies that lie or roll within twice its size; those that still fall come into it.
void follow(scenes::View& view, const scenes::View& start, const scenes::Scene& scene) {
  const Eigen::AlignedBox3d& box = start.box;
  const Eigen::AlignedBox3d widest(box.center() - box.sizes(), box.center() + box.sizes());
  for (std::size_t i = 0; i < scene.soft->bodyCount(); ++i) {
    const SoftBody& body = *scene.soft->body(i);
    const double radius = 0.5 * sizeOf(body);
    const Eigen::Vector3d centre = body.centerOfMass(), size = Eigen::Vector3d::Constant(radius);
    if (centre.y() - 2.0 * radius > box.min().y()) continue;
    const Eigen::AlignedBox3d near = Eigen::AlignedBox3d(centre - size, centre + size).intersection(widest);
    if (!near.isEmpty()) view.box.extend(near);
  }
}

render::Camera cameraAt(const scenes::View& view, const DemoOptions& options, double share) {
  const float aspect = static_cast<float>(options.width) / static_cast<float>(options.height);
  const render::Vec3 low = toVec3(view.box.min()), high = toVec3(view.box.max());
  const render::Vec3 direction = toVec3(view.direction);
  if (options.camera.path == CameraPath::Orbit)
    return render::orbitBox(low, high, direction, aspect, static_cast<float>(kTwoPi * share));
  render::Camera camera = render::frameBox(low, high, direction, aspect);
  if (options.camera.path == CameraPath::Fixed) {
    camera.eye = toVec3(options.camera.eye);
    camera.target = toVec3(options.camera.target);
    const float distance = (options.camera.eye - options.camera.target).cast<float>().norm();
    camera.nearPlane = kNear * distance;
    camera.farPlane = kFar * distance;
  }
  return camera;
}

render::Light lightOf(const scenes::View& view) {
  render::Light light;
  light.towards = {-0.35f, 0.85f, 0.45f};
  return render::lightBox(toVec3(view.box.min()), toVec3(view.box.max()), light);
}

view::SoftView::Look softLooks(const scenes::Scene& scene, render::TextureId checker) {
  std::unordered_map<const SoftBody*, view::SoftLook> looks;
  for (std::size_t b = 0; b < scene.looks.size(); ++b) {
    const scenes::BodyLook& look = scene.looks[b];
    const SoftBody* body = scene.soft->body(b);
    view::SoftLook& shown = looks[body];
    shown.shading = render::Shading::Smooth;
    shown.sharpAngle = look.smooth ? 0.0f : kSharpAngle;
    // half the time of a picture of several detailed meshes without a GPU
    shown.hideBackFaces = body->network().render.skin.size() > 0;
    shown.instance = {toVec3(look.colour), look.checkered ? checker : render::TextureId{},
                      materialOf(look.finish, sizeOf(*body))};
  }
  return [looks = std::move(looks)](const SoftBody& body) { return looks.at(&body); };
}

render::Vec3 islandColour(int island) {
  constexpr double kGoldenShare = 0.618033988749895;  // spreads hues evenly, however many there are
  if (island < 0) return {0.62f, 0.62f, 0.64f};
  const double hue = std::fmod(kGoldenShare * island, 1.0), lightness = island % 2 == 0 ? 0.60 : 0.50;
  const auto channel = [&](double shift) {
    return static_cast<float>(lightness + 0.32 * std::cos(kTwoPi * (hue + shift)));
  };
  return {channel(0.0), channel(-1.0 / 3.0), channel(1.0 / 3.0)};
}

view::RigidView::Look rigidLooks(const scenes::Scene& scene) {
  return [&scene](const btCollisionObject& object) {
    const auto& looks = scene.rigidLooks;
    const auto look = std::find_if(looks.begin(), looks.end(),
                                   [&object](const scenes::RigidLook& one) { return one.body == &object; });
    return render::InstanceLook{toVec3(look->colour), {}, materialOf(look->finish, 1.0)};
  };
}

namespace {

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

}  // namespace

render::TextureId addCheckerTexture(render::Renderer& renderer) {
  const render::Image image = checkerTexture();
  return renderer.addTexture(image.width, image.height, image.rgba.data());
}

namespace {

/// Half the diagonal of the shown box, m; the size of marks is proportional to it.
double viewRadius(const scenes::View& view) { return 0.5 * view.box.diagonal().norm(); }

constexpr double kContactSize = 0.04;  // of viewRadius()

int modeOf(const OverlayChoice& choice) {
  int mode = btIDebugDraw::DBG_NoDebug;
  if (choice.contacts) mode |= btIDebugDraw::DBG_DrawContactPoints;
  if (choice.constraints) mode |= btIDebugDraw::DBG_DrawConstraints | btIDebugDraw::DBG_DrawConstraintLimits;
  if (choice.boxes) mode |= btIDebugDraw::DBG_DrawAabb;
  return mode;
}

/// Bullet calls debugDraw() of its actions, which draw the soft bodies, in these modes only.
constexpr int kActionModes =
    btIDebugDraw::DBG_DrawWireframe | btIDebugDraw::DBG_DrawAabb | btIDebugDraw::DBG_DrawNormals;

constexpr render::Vec3 kWaterLine{0.10f, 0.42f, 0.72f};
constexpr int kWaterLines = 12;

/// Adds the surface of the water within a box, as a net of lines.
void addWater(render::Overlay& lines, double level, const Eigen::AlignedBox3d& box) {
  for (int i = 0; i <= kWaterLines; ++i) {
    const double share = static_cast<double>(i) / kWaterLines;
    const double x = box.min().x() + share * box.sizes().x(), z = box.min().z() + share * box.sizes().z();
    const auto at = [level](double px, double pz) { return toVec3(Eigen::Vector3d(px, level, pz)); };
    lines.push_back({at(x, box.min().z()), at(x, box.max().z()), kWaterLine});
    lines.push_back({at(box.min().x(), z), at(box.max().x(), z), kWaterLine});
  }
}

}  // namespace

SceneOverlay::SceneOverlay(const scenes::Scene& scene) : scene_(scene) {
  drawer_.contactSize = static_cast<float>(kContactSize * viewRadius(scene.view));
}

render::Overlay& SceneOverlay::draw(const OverlayChoice& choice, render::Vec3 eye) {
  drawer_.overlay.clear();
  const int mode = modeOf(choice);
  drawer_.setDebugMode(mode);
  if (mode != btIDebugDraw::DBG_NoDebug) {
    btDiscreteDynamicsWorld& world = scene_.world->dynamics;
    world.setDebugDrawer(&drawer_);
    world.debugDrawWorld();
    world.setDebugDrawer(nullptr);
    if ((mode & kActionModes) == 0) scene_.soft->debugDraw(drawer_);
  }
  if (const std::optional<Water>& water = scene_.soft->water())
    addWater(drawer_.overlay, water->level, scene_.view.box);
  if (choice.velocities) {
    for (std::size_t b = 0; b < scene_.soft->bodyCount(); ++b)
      view::addVelocities(drawer_.overlay, *scene_.soft->body(b), kVelocityArrows, eye);
  }
  return drawer_.overlay;
}

namespace {

const render::Vec3 kFloorColour{0.80f, 0.79f, 0.78f};
const render::Vec3 kWallTop{0.47f, 0.56f, 0.66f}, kWallBottom{0.95f, 0.93f, 0.90f};  // of the gallery

/// Hanging and resting bodies of the scenes have strains of a few per cent.
constexpr float kStrainRange = 0.03f;

}  // namespace

render::DrawOptions drawOptions(const Shot& shot, render::Quality quality) {
  render::DrawOptions draw;
  if (shot.mode == PictureMode::Wireframe) draw.mode = render::DrawMode::Wireframe;
  draw.strainRange = kStrainRange;
  if (quality == render::Quality::Gallery) draw.backgroundTop = kWallTop, draw.backgroundBottom = kWallBottom;
  if (shot.overlay.velocities) draw.legends = {view::speedLegend(kVelocityArrows)};
  return draw;
}

FloorView::FloorView(render::Renderer& renderer, const scenes::Scene& scene) : renderer_(renderer) {
  const float extent = kFloorSizes * static_cast<float>(scene.view.box.diagonal().norm());
  const render::RigidShape rigid =
      render::makeRigid(render::makeFloor({}, static_cast<float>(scene.floorHalfSize), extent));
  scale_ = rigid.reach;
  shape_ = renderer_.addShape(rigid.shape);
  instance_ = renderer_.addInstance(shape_, {kFloorColour, {}});
}

FloorView::~FloorView() {
  renderer_.removeInstance(instance_);
  renderer_.removeShape(shape_);
}

void FloorView::write(const render::FrameWriter& frame) const {
  render::writeFrame(scale_, {}, frame.points(instance_));
}

SceneView::SceneView(const scenes::Scene& scene, render::Renderer& renderer, render::TextureId checker)
    : scene_(scene),
      renderer_(renderer),
      softBodies_(renderer, *scene.soft, looks(checker)),
      rigidBodies_(renderer, scene.world->dynamics, rigidLooks(scene)),
      floor_(renderer, scene),
      overlay_(scene) {}

view::SoftView::Look SceneView::looks(render::TextureId checker) const {
  return [this, look = softLooks(scene_, checker)](const SoftBody& body) {
    view::SoftLook shown = look(body);
    if (islands_) shown.instance = {islandColour(body.island()), {}};
    return shown;
  };
}

void SceneView::draw(const Shot& shot) {
  softBodies_.update();
  if (islands_ || shot.overlay.islands) {
    islands_ = shot.overlay.islands;
    softBodies_.updateLooks();
  }
  rigidBodies_.update();
  render::FrameWriter frame = renderer_.beginFrame();
  floor_.write(frame);
  softBodies_.write(frame, shot.tickFraction);
  rigidBodies_.write(frame, shot.tickFraction, 1.0 / static_cast<double>(scenes::kTicksPerSecond));
  render::Overlay& lines = overlay_.draw(shot.overlay, shot.camera.eye);
  lines.insert(lines.end(), shot.marks.begin(), shot.marks.end());
  renderer_.draw(frame, shot.camera, shot.light, drawOptions(shot, renderer_.quality()), lines);
}

namespace {

render::RendererDesc rendererDesc(const scenes::Scene& scene, const DemoOptions& options) {
  render::RendererDesc desc;
  desc.width = options.width;
  desc.height = options.height;
  desc.samples = 4;
  desc.quality = options.quality;
  desc.initialPoints = scenes::pointCount(scene) + 1024;  // for the rigid bodies
  return desc;
}

}  // namespace

SceneRenderer::SceneRenderer(const scenes::Scene& scene, const DemoOptions& options)
    : scene_(scene),
      seen_(scene.view),
      options_(options),
      context_(render::createContext(options.context)),
      renderer_(*context_, rendererDesc(scene, options)),
      view_(scene, renderer_, addCheckerTexture(renderer_)) {}

void SceneRenderer::draw(const Moment& moment, render::Image& image) {
  Shot shot;
  if (scene_.view.follows) follow(seen_, scene_.view, scene_);
  shot.light = lightOf(seen_);
  shot.camera = cameraAt(seen_, options_, moment.share);
  shot.tickFraction = moment.tickFraction;
  shot.mode = options_.mode;
  shot.overlay = options_.overlay;
  view_.draw(shot);
  renderer_.readPixels(image);
}

std::string SceneRenderer::driver() const { return render::describeDriver(renderer_.gl()); }

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <Eigen/Geometry>

#include <memory>
#include <utility>

namespace limber::scenes {
namespace {

constexpr std::uint32_t kBannerCells = 24;
constexpr double kBannerSize = 1.4, kBannerTop = 1.8;  // m
constexpr std::int64_t kFirstCut = 60, kSweep = 60;    // ticks
constexpr double kPart = 0.6;                          // m/s, at which pieces part
const Eigen::Vector3d kBlockCentre(1.5, 0.45, 0.0);    // m

std::string addBanner(Scene& scene, const SceneOptions& options) {
  ClothSettings shape;
  shape.width = shape.depth = kBannerSize;
  shape.columns = shape.rows = kBannerCells;
  const Result<SharedNetwork> network = buildCloth(shape);
  if (!network) return network.error();
  SoftBodySettings settings;
  settings.totalMass = 0.4;
  settings.damping = 0.4;
  settings.pointRadius = 0.012;
  settings.flow.linearDrag = 1.6;
  // upright, its first row on top
  settings.rotation = Eigen::AngleAxisd(0.5 * 3.141592653589793, Eigen::Vector3d::UnitX());
  settings.position = {-0.6, kBannerTop - 0.5 * kBannerSize, 0.0};
  apply(options, settings);
  BodyLook look;
  look.colour = paletteColour(0);
  look.smooth = look.checkered = true;
  look.finish = Finish::Cloth;
  if (const std::string reason = addBody(scene, *network, settings, look); !reason.empty()) return reason;
  for (std::uint32_t i = 0; i <= kBannerCells; ++i) scene.soft->body(0)->pin(i);
  return {};
}

std::string addBlock(Scene& scene, const SceneOptions& options) {
  const Result<SharedNetwork> cube = readNetwork(LIMBER_MESH_DIR "/cube.obj");
  if (!cube) return cube.error();
  TriangleMesh mesh;
  mesh.positions = (*cube)->restPoints;
  mesh.triangles = (*cube)->surface;
  MaterialMesh fill;
  fill.points = 250;
  const Result<SharedNetwork> network = buildMaterialNetwork(mesh, fill);
  if (!network) return network.error();
  SoftBodySettings settings;
  settings.scale = Eigen::Vector3d(0.9, 0.7, 0.7);
  settings.position = kBlockCentre;
  settings.rotation = Eigen::AngleAxisd(Random(options.seed).between(-0.02, 0.02), Eigen::Vector3d::UnitY());
  settings.selfCollision = true;
  settings.pointRadius = 0.012;
  const Result<SoftBodySettings> jelly = withMaterial(**network, Material::jelly(), settings);
  if (!jelly) return jelly.error();
  settings = *jelly;
  apply(options, settings);
  BodyLook look;
  look.colour = paletteColour(1);
  look.finish = Finish::Jelly;
  return addBody(scene, *network, settings, look);
}

/// Gives the points on each side of a plane a velocity away from it.
void partAt(SoftBody& body, const Eigen::Vector3d& place, const Eigen::Vector3d& normal) {
  const double speed = kPart * body.totalMass();
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
    const double side = normal.dot(body.position(i) - place) > 0.0 ? 1.0 : -1.0;
    const double push = side * speed * body.network().massFractions[i];
    static_cast<void>(body.applyImpulse(toBullet(push * normal), i));
  }
}

/// Cuts the block by planes, and the banner by a blade that moves across it.
void cutAll(Scene& scene, std::size_t& made) {
  SoftBody &banner = *scene.soft->body(0), &block = *scene.soft->body(1);
  const std::int64_t ticks = scene.ticks - kFirstCut;
  if (ticks >= 0 && ticks <= kSweep && ticks % 5 == 0) {
    // always in the same plane, and at last beyond the other edge
    const double way = 0.07 + 0.93 * double(ticks) / double(kSweep);
    const btVector3 away(0, 0, 1), start(btScalar(-1.4), btScalar(kBannerTop - 0.75 * kBannerSize), 0),
        tip = start + btVector3(btScalar(1.65), btScalar(0.35), 0) * btScalar(way);
    if (const auto cut = banner.cut({start - away, start + away, tip + away, tip - away})) made += *cut;
  }
  const std::pair<std::int64_t, Eigen::Vector3d> planes[] = {{0, Eigen::Vector3d::UnitX()},
                                                             {kSweep, Eigen::Vector3d::UnitZ()}};
  for (const auto& [when, normal] : planes) {
    if (ticks != when) continue;
    const Eigen::Vector3d place = fromBullet(block.transform().getOrigin()) + 0.02 * normal;
    if (const auto cut = block.cut(toBullet(place), toBullet(normal))) made += *cut;
    partAt(block, place, normal);
  }
}

/// Checks that the parts of both bodies are apart.
Check checkCut(const std::shared_ptr<std::size_t>& made) {
  return [made](const Scene& scene) {
    if (*made < 60) return "only " + std::to_string(*made) + " points were divided";
    const SoftBody& banner = *scene.soft->body(0);
    // the last row of the banner as it was made
    for (std::uint32_t i = 0; i <= kBannerCells; ++i)
      if (banner.position(kBannerCells * (kBannerCells + 1) + i).y() > 0.2)
        return std::string("the lower part of the banner has not fallen");
    Eigen::AlignedBox3d box;
    const SoftBody& block = *scene.soft->body(1);
    for (std::uint32_t i = 0; i < block.pointCount(); ++i) box.extend(block.position(i));
    if (box.sizes().x() < 1.0 || box.sizes().z() < 0.8)
      return std::string("the parts of the block are together");
    return std::string();
  };
}

}  // namespace

SceneResult createCut(const SceneOptions& options) {
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 10.0);
  if (const std::string reason = addBanner(*scene, options); !reason.empty()) return Error{reason};
  if (const std::string reason = addBlock(*scene, options); !reason.empty()) return Error{reason};
  const auto made = std::make_shared<std::size_t>(0);
  scene->beforeTick = [made](Scene& now) { cutAll(now, *made); };
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-1.4, 0, -0.6), Eigen::Vector3d(2.4, 1.9, 1.3));
  scene->view.direction = {0.3, 0.4, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkCut(made), checkCalm(0.1)};
  return scene;
}

}  // namespace limber::scenes

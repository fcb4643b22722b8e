// SPDX-License-Identifier: Zlib
// A cloth falls over a statue, a mesh of triangles.
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <algorithm>

namespace limber::scenes {
namespace {

constexpr double kStatueHeight = 1.3;                          // m
constexpr double kPedestalHeight = 0.5, kPedestalHalf = 0.32;  // m
constexpr double kVeilWidth = 2.6;                             // m
constexpr std::uint32_t kVeilCells = 32;
const Eigen::Vector3f kMarble(0.90f, 0.88f, 0.84f);

/// Bullet's shape of a mesh only refers to the triangles.
struct StatueTriangles {
  explicit StatueTriangles(const TriangleMesh& mesh) {
    for (const Triangle& t : mesh.triangles)
      triangles.addTriangle(toBullet(mesh.positions[t[0]]), toBullet(mesh.positions[t[1]]),
                            toBullet(mesh.positions[t[2]]));
  }
  btTriangleMesh triangles;
};

class StatueShape : private StatueTriangles, public btBvhTriangleMeshShape {
 public:
  explicit StatueShape(const TriangleMesh& mesh)
      : StatueTriangles(mesh), btBvhTriangleMeshShape(&triangles, true) {}
};

/// Moves a mesh onto the pedestal, in the height of the statue.
void place(TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.positions) box.extend(p);
  const Eigen::Vector3d foot(box.center().x(), box.min().y(), box.center().z());
  const double scale = kStatueHeight / box.sizes().y();
  for (Eigen::Vector3d& p : mesh.positions)
    p = scale * (p - foot) + Eigen::Vector3d(0.0, kPedestalHeight, 0.0);
}

/// Checks that the veil lies on the statue's head and hangs down on all sides.
std::string checkVeiled(const Scene& scene) {
  const SoftBody& veil = *scene.soft->body(0);
  double top = 0.0;
  for (std::uint32_t i = 0; i < veil.pointCount(); ++i) top = std::max(top, veil.position(i).y());
  const double head = kPedestalHeight + kStatueHeight;
  if (top < head - 0.05 || top > head + 0.1) return "the veil does not lie on the statue's head";
  constexpr std::uint32_t kRow = kVeilCells + 1;
  for (const std::uint32_t corner : {0u, kVeilCells, kVeilCells * kRow, kVeilCells * kRow + kVeilCells})
    if (veil.position(corner).y() > kPedestalHeight + 0.5 * kStatueHeight)
      return "a corner of the veil does not hang down";
  return {};
}

std::string addVeil(Scene& scene, const SceneOptions& options) {
  const Result<SharedNetwork> network = clothNetwork(kVeilWidth, kVeilWidth, kVeilCells, kVeilCells);
  if (!network) return network.error();
  SoftBodySettings settings;
  settings.totalMass = 1.6;
  settings.extensionStiffness = settings.compressionStiffness = 200.0;
  settings.damping = 0.3;
  settings.pointRadius = 0.02;
  settings.friction = 0.6;
  settings.flow.linearDrag = 1.2;
  settings.position = {0.0, kPedestalHeight + kStatueHeight + 0.25, 0.0};
  settings.rotation =
      Eigen::AngleAxisd(0.7 + Random(options.seed).between(-0.1, 0.1), Eigen::Vector3d::UnitY());
  apply(options, settings);
  return addBody(scene, *network, settings, clothLook({0.16f, 0.36f, 0.62f}, false));
}

}  // namespace

SceneResult createStatue(const SceneOptions& options) {
  Result<TriangleMesh> mesh = importMesh(LIMBER_MESH_DIR "/head.obj");
  if (!mesh) return Error{mesh.error()};
  place(*mesh);
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 6.0, 1.0);
  const Eigen::Vector3d half(kPedestalHalf, 0.5 * kPedestalHeight, kPedestalHalf);
  addStatic(*scene, std::make_unique<btBoxShape>(toBullet(half)), {0.0, half.y(), 0.0}, 0.6, kMarble);
  addStatic(*scene, std::make_unique<StatueShape>(*mesh), {0.0, 0.0, 0.0}, 0.6, kMarble);
  if (std::string reason = addVeil(*scene, options); !reason.empty()) return Error{reason};
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-1.1, 0, -0.9), Eigen::Vector3d(1.1, 1.95, 0.9));
  scene->view.direction = {0.35, 0.3, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkVeiled, checkCalm(0.1), checkStretch(0.1)};
  return scene;
}

}  // namespace limber::scenes

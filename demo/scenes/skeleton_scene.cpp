// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

namespace limber::scenes {
namespace {

using Eigen::Vector3d;

constexpr double kDancerPi = 3.141592653589793;
constexpr double kDanceSeconds = 6.0;                         // then the dancers stand still
constexpr double kDancerSpacing = 1.8;                        // m
constexpr double kHip = 0.95, kShoulder = 1.42;               // m, heights when standing
constexpr std::uint32_t kDressColumns = 44, kDressRows = 26;  // cells, around and down
constexpr double kDressTop = 1.40, kDressHem = 0.42;          // m
constexpr double kDressMass = 0.5;                            // kg
constexpr std::uint32_t kPinnedRows = 3, kCloseRows = 12;     // from the top: sewn on, and close to the body
constexpr double kCloseDistance = 0.02;                       // m, that points of the close rows may move
const Eigen::Vector3f kSkinColour(0.80f, 0.72f, 0.64f);

/// The bones of a dancer.
enum Bone : std::size_t { kPelvis, kChest, kHead, kLeftLeg, kRightLeg, kLeftArm, kRightArm, kBones };

/// The capsule that a bone carries: its ends in the bone's coordinates.
struct Limb {
  Vector3d from, to;
  double radius;
};

const std::array<Limb, kBones> kLimbs = {{{{-0.06, -0.02, 0}, {0.06, -0.02, 0}, 0.125},
                                          {{0, 0.10, 0}, {0, 0.36, 0}, 0.12},
                                          {{0, 0.53, 0}, {0, 0.63, 0}, 0.09},
                                          {{0, 0, 0}, {0, -0.86, 0}, 0.075},
                                          {{0, 0, 0}, {0, -0.86, 0}, 0.075},
                                          {{0, 0, 0}, {0.56, 0, 0}, 0.045},
                                          {{0, 0, 0}, {-0.56, 0, 0}, 0.045}}};

btTransform placed(const Eigen::Quaterniond& turn, const Vector3d& origin) {
  return btTransform(
      btQuaternion(btScalar(turn.x()), btScalar(turn.y()), btScalar(turn.z()), btScalar(turn.w())),
      toBullet(origin));
}

Eigen::Quaterniond about(const Vector3d& axis, double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
}

/// Returns the bones at a time: the dancer sways, swings the legs and turns to and fro. It starts and ends at
/// rest, standing.
std::vector<btTransform> poseAt(double seconds, const Vector3d& feet) {
  const double t = std::min(seconds / kDanceSeconds, 1.0);
  const double ease = std::sin(kDancerPi * t) * std::sin(kDancerPi * t);  // 0 at both ends, with its rate
  const double beat = 2.0 * kDancerPi * 4.0 * t;
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  const Vector3d hip = feet + Vector3d(0.10 * ease * std::sin(beat), kHip, 0);
  const Eigen::Quaterniond turn = about(y, 2.4 * ease * std::sin(0.5 * beat));
  const Eigen::Quaterniond lean = turn * about(z, -0.15 * ease * std::sin(beat));
  const Vector3d legs = turn * Vector3d(0.08, -0.03, 0);
  const double swing = 0.45 * ease * std::sin(beat);
  const Vector3d shoulder(0.19, kShoulder - kHip, 0), other(-0.19, kShoulder - kHip, 0);
  return {placed(turn, hip),
          placed(lean, hip),
          placed(lean, hip),
          placed(turn * about(x, -swing), hip + legs),
          placed(turn * about(x, swing), hip - legs),
          placed(lean * about(z, -0.9 + 0.9 * ease), hip + lean * shoulder),
          placed(lean * about(z, 0.9 - 0.9 * ease), hip + lean * other)};
}

/// m, radius of the dress at a height when standing: chest, waist, hips, and the flare of the skirt.
double dressRadius(double height) {
  const std::array<std::pair<double, double>, 5> profile = {
      {{kDressHem, 0.42}, {0.90, 0.24}, {1.08, 0.155}, {1.25, 0.155}, {kDressTop, 0.15}}};
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    const auto [low, radius] = profile[i];
    const auto [high, next] = profile[i + 1];
    if (height <= high) return radius + (next - radius) * (height - low) / (high - low);
  }
  return profile.back().second;
}

std::uint32_t dressPoint(std::uint32_t column, std::uint32_t row) {
  return row * kDressColumns + column % kDressColumns;
}

/// A tube with its first row on top; triangles face outward.
TriangleMesh dressMesh() {
  TriangleMesh mesh;
  for (std::uint32_t row = 0; row <= kDressRows; ++row) {
    const double height = kDressTop + (kDressHem - kDressTop) * row / kDressRows;
    for (std::uint32_t column = 0; column < kDressColumns; ++column) {
      const double angle = 2.0 * kDancerPi * column / kDressColumns;
      const double radius = dressRadius(height);
      mesh.positions.emplace_back(radius * std::sin(angle), height, 0.9 * radius * std::cos(angle));
    }
  }
  for (std::uint32_t row = 0; row < kDressRows; ++row)
    for (std::uint32_t c = 0; c < kDressColumns; ++c) {
      const std::uint32_t a = dressPoint(c, row), b = dressPoint(c + 1, row);
      const std::uint32_t d = dressPoint(c, row + 1), e = dressPoint(c + 1, row + 1);
      const bool even = (row + c) % 2 == 0;
      mesh.triangles.push_back(even ? Triangle{a, d, e} : Triangle{a, d, b});
      mesh.triangles.push_back(even ? Triangle{a, e, b} : Triangle{d, e, b});
    }
  return mesh;
}

/// Edges, and weak springs across them that resist folds.
Result<SharedNetwork> dressNetwork() {
  NetworkSettings settings;
  settings.braces = BraceRule::TwoRing;
  settings.braceWeight = 0.02;
  return buildNetwork(dressMesh(), settings);
}

/// One dancer: kinematic capsules that follow the bones, and the dress on them.
struct Dancer {
  Vector3d feet = Vector3d::Zero();
  std::vector<btRigidBody*> limbs;  // #bones
  SoftBody* dress = nullptr;
  std::shared_ptr<Skeleton> skeleton;

  void moveTo(double seconds) {
    const std::vector<btTransform> bones = poseAt(seconds, feet);
    for (std::size_t b = 0; b < kBones; ++b) limbs[b]->setWorldTransform(limbPlace(b, bones[b]));
    static_cast<void>(skeleton->moveTo(bones));
  }

  static btTransform limbPlace(std::size_t bone, const btTransform& at) {
    const Limb& limb = kLimbs[bone];
    const Eigen::Quaterniond along =
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitY(), limb.to - limb.from);
    return at * placed(along, 0.5 * (limb.from + limb.to));
  }
};

void addLimbs(Scene& scene, Dancer& dancer) {
  const std::vector<btTransform> bones = poseAt(0.0, dancer.feet);
  for (std::size_t b = 0; b < kBones; ++b) {
    const Limb& limb = kLimbs[b];
    auto shape =
        std::make_unique<btCapsuleShape>(btScalar(limb.radius), btScalar((limb.to - limb.from).norm()));
    const btTransform place = Dancer::limbPlace(b, bones[b]);
    btRigidBody& body = addMovable(*scene.world, std::move(shape), 0.0, fromBullet(place.getOrigin()), 0.3);
    body.setWorldTransform(place);
    body.setInterpolationWorldTransform(place);
    scene.rigidLooks.push_back({&body, kSkinColour});
    dancer.limbs.push_back(&body);
  }
}

/// The top of the dress is sewn to the chest, the part above the hips is close to chest and pelvis, and the
/// skirt is free.
std::vector<BoundPoint> boundPoints() {
  std::vector<BoundPoint> points;
  for (std::uint32_t row = 0; row < kCloseRows; ++row)
    for (std::uint32_t column = 0; column < kDressColumns; ++column) {
      const double pelvis = std::max(0.0, double(row) - kPinnedRows) / double(kCloseRows - kPinnedRows);
      BoundPoint bound{dressPoint(column, row), {{kPelvis, pelvis}, {kChest, 1.0 - pelvis}}};
      if (row >= kPinnedRows) bound.maxDistance = kCloseDistance, bound.backStop = 0.0;
      points.push_back(bound);
    }
  return points;
}

std::string addDancer(Scene& scene, const SharedNetwork& network, const SceneOptions& options,
                      Dancer& dancer) {
  addLimbs(scene, dancer);
  SoftBodySettings settings;
  settings.totalMass = kDressMass;
  settings.extensionStiffness = 300.0;
  settings.compressionStiffness = 300.0;
  settings.damping = 0.1;
  settings.pointRadius = 0.008;
  settings.friction = 0.3;
  settings.flow.linearDrag = 1.0;
  settings.position = dancer.feet;
  settings.linearVelocity = {0.0, 0.0, Random(options.seed + scene.looks.size()).between(-0.05, 0.05)};
  apply(options, settings);
  const BodyLook look = clothLook(paletteColour(scene.looks.size()), false);
  if (std::string reason = addBody(scene, network, settings, look); !reason.empty()) return reason;
  dancer.dress = scene.soft->body(scene.soft->bodyCount() - 1);
  Result<Skeleton> skeleton =
      Skeleton::bind(*scene.soft, *dancer.dress, boundPoints(), poseAt(0.0, dancer.feet));
  if (!skeleton) return skeleton.error();
  dancer.skeleton = std::make_shared<Skeleton>(std::move(*skeleton));
  return {};
}

/// Notes how far the hems have flown and how far bound points have been from their places.
struct DressWatch {
  double widest = 0.0;    ///< m, largest distance of a hem's point from the dancer's axis
  double farthest = 0.0;  ///< m, of a bound point from its place

  void look(const std::vector<Dancer>& dancers) {
    for (const Dancer& dancer : dancers) {
      for (std::uint32_t column = 0; column < kDressColumns; ++column) {
        const Vector3d p = dancer.dress->position(dressPoint(column, kDressRows)) - dancer.feet;
        widest = std::max(widest, std::hypot(p.x(), p.z()));
      }
      for (std::uint32_t i = 0; i < kCloseRows * kDressColumns; ++i) {
        const Vector3d place = fromBullet(dancer.skeleton->place(i));
        farthest = std::max(farthest, (dancer.dress->position(i) - place).norm());
      }
    }
  }
};

Check checkDresses(const std::shared_ptr<DressWatch>& watch, const std::vector<Dancer>& dancers) {
  return [watch, dancers](const Scene&) {
    if (watch->widest < 0.5) return std::string("no skirt has flown");
    if (watch->farthest > 2.0 * kCloseDistance) return std::string("a dress has left its bones");
    for (std::size_t i = 0; i < dancers.size(); ++i)
      if (middleOf(*dancers[i].dress).y() < 0.7) return "dress " + std::to_string(i) + " has slipped";
    return std::string();
  };
}

}  // namespace

SceneResult createSkeleton(const SceneOptions& options) {
  const Result<SharedNetwork> network = dressNetwork();
  if (!network) return Error{network.error()};
  const std::uint32_t count = options.count.value_or(1);
  const double half = 0.5 * kDancerSpacing * double(count - 1);
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 10.0 + half);
  const auto dancers = std::make_shared<std::vector<Dancer>>(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    Dancer& dancer = (*dancers)[i];
    dancer.feet = {kDancerSpacing * i - half, 0.0, 0.0};
    if (const std::string reason = addDancer(*scene, *network, options, dancer); !reason.empty())
      return Error{reason};
  }
  const auto watch = std::make_shared<DressWatch>();
  scene->beforeTick = [dancers](Scene& now) {
    for (Dancer& dancer : *dancers) dancer.moveTo(double(now.ticks + 1) / double(kTicksPerSecond));
  };
  scene->afterTick = [dancers, watch](Scene&) { watch->look(*dancers); };
  scene->view.box = Eigen::AlignedBox3d(Vector3d(-half - 0.75, 0, -0.6), Vector3d(half + 0.75, 1.75, 0.6));
  scene->view.direction = {0.35, 0.25, 1.0};
  scene->endChecks = {checkFinite, checkDresses(watch, *dancers), checkRigidApart(0.02), checkStretch(0.3),
                      checkCalm(0.05)};
  return scene;
}

}  // namespace limber::scenes

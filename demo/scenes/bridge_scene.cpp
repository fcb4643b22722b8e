// SPDX-License-Identifier: Zlib
// A car of rigid bodies and hinges drives over a bridge of cloth.
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <array>
#include <memory>

namespace limber::scenes {
namespace {

constexpr double kSpan = 5.0, kDeckWidth = 1.4, kBank = 1.6, kBankHeight = 1.0;  // m
constexpr std::uint32_t kDeckColumns = 40, kDeckRows = 11;
constexpr double kDeckRadius = 0.02;                                                   // m, of its points
constexpr double kWheelRadius = 0.17, kWheelHalf = 0.06, kAxle = 0.42, kTrack = 0.36;  // m
constexpr double kDriveSpeed = 9.0, kDriveTorque = 0.06;  // rad/s; N m s, in a tick
const Eigen::Vector3f kStone(0.62f, 0.60f, 0.57f), kBodywork(0.90f, 0.66f, 0.12f), kTyre(0.12f, 0.12f, 0.13f);

/// A chassis, its wheels and the hinges between them. The hinges end with it, before the bodies.
struct Car {
  explicit Car(btDiscreteDynamicsWorld& itsWorld) : world(itsWorld) {}
  ~Car() {
    for (const auto& hinge : hinges) world.removeConstraint(hinge.get());
  }
  Car(const Car&) = delete;
  Car& operator=(const Car&) = delete;

  btDiscreteDynamicsWorld& world;
  btRigidBody* chassis = nullptr;
  std::vector<std::unique_ptr<btHingeConstraint>> hinges;
};

void addWheel(Scene& scene, Car& car, const Eigen::Vector3d& offset) {
  const btVector3 half = toBullet({kWheelRadius, kWheelRadius, kWheelHalf});
  const Eigen::Vector3d at = fromBullet(car.chassis->getWorldTransform().getOrigin()) + offset;
  btRigidBody& wheel = addMovable(*scene.world, std::make_unique<btCylinderShapeZ>(half), 1.0, at, 1.5);
  wheel.setActivationState(DISABLE_DEACTIVATION);
  scene.rigidLooks.push_back({&wheel, kTyre});
  const btVector3 axis(0, 0, 1);
  car.hinges.push_back(std::make_unique<btHingeConstraint>(*car.chassis, wheel, toBullet(offset),
                                                           btVector3(0, 0, 0), axis, axis));
  scene.world->dynamics.addConstraint(car.hinges.back().get(), true);
}

std::shared_ptr<Car> addCar(Scene& scene, const Eigen::Vector3d& at) {
  auto car = std::make_shared<Car>(scene.world->dynamics);
  car->chassis = &addBox(scene, at, {0.62, 0.12, 0.26}, 6.0, kBodywork);
  car->chassis->setActivationState(DISABLE_DEACTIVATION);
  for (const double x : {-kAxle, kAxle})
    for (const double z : {-kTrack, kTrack}) addWheel(scene, *car, {x, -0.12, z});
  return car;
}

/// Drives over the bridge and brakes on the other bank.
void drive(Car& car) {
  const bool across = double(car.chassis->getWorldTransform().getOrigin().x()) > 0.5 * kSpan + 0.6;
  for (const auto& hinge : car.hinges)
    hinge->enableAngularMotor(true, btScalar(across ? 0.0 : kDriveSpeed), btScalar(kDriveTorque));
}

std::string addDeck(Scene& scene, const SceneOptions& options) {
  const Result<SharedNetwork> network = clothNetwork(kSpan, kDeckWidth, kDeckColumns, kDeckRows);
  if (!network) return network.error();
  SoftBodySettings settings;
  settings.totalMass = 6.0;
  settings.extensionStiffness = settings.compressionStiffness = 1.5e4;
  settings.damping = 8.0;
  settings.friction = 1.0;
  settings.pointRadius = kDeckRadius;
  settings.position = {0.0, kBankHeight + Random(options.seed).between(0.0, 1e-3), 0.0};
  apply(options, settings);
  const BodyLook look = clothLook({0.55f, 0.25f, 0.16f});
  if (const std::string reason = addBody(scene, *network, settings, look); !reason.empty()) return reason;
  SoftBody& deck = *scene.soft->body(0);
  for (std::uint32_t row = 0; row <= kDeckRows; ++row)
    for (const std::uint32_t column : {0u, kDeckColumns}) deck.pin(row * (kDeckColumns + 1) + column);
  return {};
}

void addBanks(Scene& scene) {
  const Eigen::Vector3d half(0.5 * kBank, 0.5 * kBankHeight, kDeckWidth);
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d centre(side * 0.5 * (kSpan + kBank), half.y(), 0.0);
    addStatic(scene, std::make_unique<btBoxShape>(toBullet(half)), centre, 1.0, kStone);
  }
}

}  // namespace

SceneResult createBridge(const SceneOptions& options) {
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 8.0);
  addBanks(*scene);
  if (std::string reason = addDeck(*scene, options); !reason.empty()) return Error{reason};
  const std::shared_ptr<Car> car =
      addCar(*scene, {-0.5 * (kSpan + kBank), kBankHeight + kWheelRadius + 0.14, 0.0});
  scene->beforeTick = [car](Scene&) { drive(*car); };
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-3.4, 0, -1.0), Eigen::Vector3d(3.4, 1.6, 1.0));
  scene->view.direction = {0.3, 0.35, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkStretch(0.1), checkCalm(0.05),
                      [chassis = car->chassis](const Scene&) {
                        const Eigen::Vector3d at = fromBullet(chassis->getWorldTransform().getOrigin());
                        return at.x() > 0.5 * kSpan && at.y() > kBankHeight
                                   ? std::string()
                                   : std::string("the car has not crossed the bridge");
                      }};
  return scene;
}

}  // namespace limber::scenes

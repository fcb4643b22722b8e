// SPDX-License-Identifier: Zlib
#include "window/session.h"

#include "scene_renderer.h"
#include "scenes/scene_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace limber::demo {
namespace {

using scenes::fromBullet;
using scenes::toBullet;

constexpr double kRadian = 3.141592653589793 / 180.0;
const Eigen::Vector3f kBallColour(0.25f, 0.28f, 0.33f);

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
  return text;
}

std::string textOf(const Eigen::Vector3d& place) {
  char text[96];
  std::snprintf(text, sizeof text, "at %.3f %.3f %.3f", place.x(), place.y(), place.z());
  return text;
}

std::string textOf(const scenes::Scene& scene, const Pick& pick) {
  if (pick.rigid) return "rigid body " + textOf(pick.place);
  return "body " + std::to_string(indexOf(scene, pick.soft)) + " point " + std::to_string(pick.point) + " " +
         textOf(pick.place);
}

Setting settingOf(const std::string& name) {
  const auto& list = settingList();
  const auto found =
      std::find_if(list.begin(), list.end(), [&name](const SettingInfo& info) { return name == info.name; });
  return static_cast<Setting>(found - list.begin());
}

std::size_t layerOf(const std::string& name) {
  const auto& list = layerList();
  return static_cast<std::size_t>(
      std::find_if(list.begin(), list.end(), [&name](const LayerInfo& info) { return name == info.name; }) -
      list.begin());
}

/// m, half the diagonal of what the scene shows.
double radiusOf(const scenes::Scene& scene) { return 0.5 * scene.view.box.diagonal().norm(); }

/// Returns `now` with the values of the panel, which are relative to how the body was made.
SoftBodySettings changed(SoftBodySettings now, const SoftBodySettings& made, const Settings& settings) {
  now.extensionStiffness = made.extensionStiffness * settings[Setting::Stiffness];
  now.compressionStiffness = made.compressionStiffness * settings[Setting::Stiffness];
  if (made.volumeModulus) now.volumeModulus = *made.volumeModulus * settings[Setting::Stiffness];
  now.damping = made.damping * settings[Setting::Damping];
  now.pressure = made.pressure + settings[Setting::Pressure];
  now.stepping = made.stepping;
  if (settings[Setting::MaxSubsteps] > 0.0)
    now.stepping.maxSubsteps = static_cast<int>(settings[Setting::MaxSubsteps]);
  now.stepping.minSubsteps =
      std::min(made.stepping.minSubsteps, now.stepping.maxSubsteps > 0 ? now.stepping.maxSubsteps : 10000);
  if (settings[Setting::Tolerance] > 0.0) now.stepping.relativeTolerance = settings[Setting::Tolerance];
  return now;
}

bullet_soft::TwinSettings twinSettings(const Settings& settings) {
  bullet_soft::TwinSettings twin;
  twin.iterations = static_cast<int>(settings[Setting::BulletIterations]);
  twin.stiffness = settings[Setting::BulletStiffness];
  twin.damping = settings[Setting::BulletDamping];
  twin.pressure = settings[Setting::BulletPressure];
  twin.friction = settings[Setting::BulletFriction];
  twin.margin = settings[Setting::BulletMargin];
  return twin;
}

/// Some scenes begin in a wind.
Settings startOf(const scenes::Scene& scene) {
  Settings settings;
  const Eigen::Vector3d wind = scene.soft->air().wind;
  settings[Setting::Wind] = std::hypot(wind.x(), wind.z());
  settings[Setting::WindDirection] = std::atan2(wind.z(), wind.x()) / kRadian;
  return settings;
}

}  // namespace

OrbitCamera framedCamera(const scenes::Scene& scene, const WindowSize& size) {
  const scenes::View& view = scene.view;
  const render::Camera camera = render::frameBox(toVec3(view.box.min()), toVec3(view.box.max()),
                                                 toVec3(view.direction), static_cast<float>(size.aspect()));
  const auto wide = [](const render::Vec3& v) -> Eigen::Vector3d {
    return {double(v.x), double(v.y), double(v.z)};
  };
  return orbitOf(wide(camera.eye), wide(camera.target));
}

Result<std::unique_ptr<Session>> Session::create(const SceneChoice& choice, const WindowSize& size) {
  std::unique_ptr<Session> session(new Session);
  session->size_ = size;
  for (std::size_t i = 0; i < kLayerCount; ++i) session->layers_[i] = layerList()[i].start;
  if (const std::string reason = session->create(choice); !reason.empty()) return Error{reason};
  return session;
}

Session::~Session() = default;

std::string Session::create(const SceneChoice& choice) {
  scenes::SceneResult scene = scenes::findScene(choice.name)->create(choice.options);
  if (!scene) return scene.error();
  hand_.release();
  scene_ = std::move(*scene);
  if (choice.name != choice_.name || sceneNumber_ == 0) camera_ = framedCamera(*scene_, layout(size_).view);
  choice_ = choice;
  createTwin();
  ++sceneNumber_;
  settings_ = start_ = startOf(*scene_);
  made_.clear();
  for (std::size_t b = 0; b < scene_->soft->bodyCount(); ++b)
    made_.push_back(scene_->soft->body(b)->settings());
  return {};
}

std::string Session::perform(const Command& command) {
  const std::string outcome = act(command);
  if (listener_) listener_(command, outcome);
  return outcome;
}

std::string Session::act(const Command& command) {
  switch (command.action) {
    case Action::Camera:
      camera_ = cameraOf(command);
      return {};
    case Action::Grab:
      return grab(rayOf(command));
    case Action::Drag:
      hand_.drag(rayOf(command));
      return {};
    case Action::Release:
      hand_.release();
      return {};
    case Action::Shoot:
      return shoot(rayOf(command));
    case Action::Cut:
      return cut(command.numbers);
    case Action::Pin:
      return pin(rayOf(command));
    case Action::Set:
      return set(command);
    case Action::Show:
      return show(command);
    case Action::Restart:
      return restart();
    case Action::Scene:
      return nextScene(command.word);
    case Action::Pause:
      pace_.paused = command.numbers[0] != 0.0;
      return {};
    case Action::Tick:
      pace_.step();
      return {};
    case Action::Speed:
      pace_.speed = command.numbers[0];
      return {};
    case Action::Wait:
      break;
  }
  return {};
}

scenes::TickTimes Session::tick() {
  ++ticks_;
  const scenes::TickTimes times = scenes::tick(*scene_);
  tickTwin();
  return times;
}

Diagnostics Session::diagnostics() const {
  Diagnostics sum;
  const double gravity = settings_[Setting::Gravity];
  for (std::size_t b = 0; b < scene_->soft->bodyCount(); ++b) {
    const SoftBody& body = *scene_->soft->body(b);
    sum.kinetic += body.kineticEnergy();
    sum.elastic += body.elasticEnergy();
    sum.potential += body.totalMass() * gravity * body.centerOfMass().y();
    sum.error = std::max(sum.error, body.errorPerSecond());
  }
  return sum;
}

std::uint64_t Session::stateHash() const {
  const std::uint64_t hash = scenes::stateHash(*scene_);
  return twin_ ? (hash ^ twin_->stateHash()) * 1099511628211ull : hash;
}

// --- btSoftBody --------------------------------------------------------------------------------------------

ViewLayout Session::layout(const WindowSize& window) const {
  return layoutOf(window, shows(Layer::Split), shows(Layer::Panel));
}

/// Both engines begin at once: the scene begins anew with the split.
std::string Session::show(const Command& command) {
  const std::size_t layer = layerOf(command.word);
  const bool before = layers_[layer];
  layers_[layer] = command.numbers[0] != 0.0;
  if (static_cast<Layer>(layer) != Layer::Split || layers_[layer] == before) return {};
  camera_ = framedCamera(*scene_, layout(size_).view);
  hand_.release();  // its springs are none of the scene, which btSoftBody must be able to play
  if (layers_[layer] && bullet_soft::BulletTwin::problemOf(*scene_).empty()) return restart();
  createTwin();
  return {};
}

void Session::createTwin() {
  twin_.reset();
  twinProblem_.clear();
  if (!shows(Layer::Split)) return;
  twinProblem_ = bullet_soft::BulletTwin::problemOf(*scene_);
  if (!twinProblem_.empty()) return;
  scenes::SceneResult scene = scenes::findScene(choice_.name)->create(choice_.options);
  auto twin = scene ? bullet_soft::BulletTwin::create(std::move(*scene))
                    : Result<std::unique_ptr<bullet_soft::BulletTwin>>(Error{scene.error()});
  if (twin)
    twin_ = std::move(*twin);
  else
    twinProblem_ = twin.error();
}

void Session::tickTwin() {
  if (!twin_) return;
  std::optional<bullet_soft::HeldPoint> held;
  if (const SoftBody* body = hand_.soft()) held = {indexOf(*scene_, body), hand_.point(), hand_.place()};
  twin_->tick(*scene_, twinSettings(settings_), held);
}

std::string Session::bulletProblem() const { return twin_ ? twin_->problem() : twinProblem_; }

// --- what the mouse does -----------------------------------------------------------------------------------

std::string Session::grab(const Ray& ray) {
  const std::optional<Pick> found = pick(*scene_, ray);
  if (!found) return "nothing there";
  const std::string reason = hand_.grab(*scene_, *found);
  if (!reason.empty()) return reason;
  return textOf(*scene_, *found) + (twin_ && found->rigid ? ", but not btSoftBody's" : "");
}

std::string Session::shoot(const Ray& ray) {
  constexpr double kRadiusShare = 0.05, kSeconds = 0.4;
  constexpr double kDensity = 300.0;  // kg/m^3, of wood
  const double scale = radiusOf(*scene_), radius = kRadiusShare * scale;
  const double mass = kDensity * 4.19 * radius * radius * radius;
  const auto shootInto = [&](scenes::Scene& scene) {
    btRigidBody& ball = scenes::addBall(scene, ray.at(0.1 * camera_.distance), radius, mass, kBallColour);
    ball.setLinearVelocity(toBullet(camera_.distance / kSeconds * ray.direction));
    ball.setCcdMotionThreshold(btScalar(radius));
    ball.setCcdSweptSphereRadius(btScalar(0.5 * radius));
  };
  shootInto(*scene_);
  if (twin_) {
    shootInto(twin_->scene());
    twin_->takeRigidBodies();
  }
  char text[64];
  std::snprintf(text, sizeof text, "a ball of %.3g kg", mass);
  return text;
}

std::string Session::cut(const std::vector<double>& n) {
  const Ray from{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}}, to{from.origin, {n[6], n[7], n[8]}};
  const double nearest = 0.05 * camera_.distance, farthest = camera_.distance + 4.0 * radiusOf(*scene_);
  const std::array<btVector3, 4> blade = {toBullet(from.at(nearest)), toBullet(from.at(farthest)),
                                          toBullet(to.at(farthest)), toBullet(to.at(nearest))};
  std::size_t points = 0;
  std::vector<std::string> problems;
  for (std::size_t b = 0; b < scene_->soft->bodyCount(); ++b) {
    const Result<std::uint32_t> made = scene_->soft->body(b)->cut(blade);
    if (made)
      points += *made;
    else
      problems.push_back("body " + std::to_string(b) + ": " + made.error());
  }
  return problems.empty() ? std::to_string(points) + " points divided" : joined(problems);
}

std::string Session::pin(const Ray& ray) {
  const std::optional<Pick> found = pick(*scene_, ray);
  if (!found || !found->soft) return "nothing there";
  const bool pinned = found->soft->pinned(found->point);
  const Result<void> done = pinned ? found->soft->unpin(found->point) : found->soft->pin(found->point);
  if (!done) return done.error();
  return (pinned ? "unpinned " : "pinned ") + textOf(*scene_, *found);
}

// --- settings ----------------------------------------------------------------------------------------------

std::string Session::set(const Command& command) {
  const Setting setting = settingOf(command.word);
  settings_[setting] = command.numbers[0];
  return apply(setting);
}

std::string Session::restart() {
  const Settings kept = settings_;
  if (const std::string reason = create(choice_); !reason.empty()) return reason;
  settings_ = kept;
  std::vector<std::string> outcomes;
  for (std::size_t i = 0; i < kSettingCount; ++i) {
    if (settings_.values[i] == start_.values[i]) continue;
    if (const std::string outcome = apply(static_cast<Setting>(i)); !outcome.empty())
      outcomes.push_back(outcome);
  }
  return joined(outcomes);
}

std::string Session::nextScene(const std::string& name) {
  if (!scenes::findScene(name)) return "there is no scene " + name;
  SceneChoice next;
  next.name = name;
  next.options.seed = choice_.options.seed;
  return create(next);
}

std::string Session::apply(Setting setting) {
  if (isOfBullet(setting)) return {};  // the next tick reads them
  if (setting == Setting::Gravity) {
    applyGravity();
    return {};
  }
  if (setting != Setting::Wind && setting != Setting::WindDirection)
    return changeBodies(setting == Setting::Pressure);
  Air air = scene_->soft->air();
  const double angle = kRadian * settings_[Setting::WindDirection];
  air.wind = settings_[Setting::Wind] * Eigen::Vector3d(std::cos(angle), 0.0, std::sin(angle));
  return scene_->soft->setAir(air).error();
}

/// Returns the reasons of bodies that cannot have the settings. Open bodies cannot have the pressure, but all
/// other settings; that is told only where the pressure itself is set.
std::string Session::changeBodies(bool tellPressure) {
  std::vector<std::string> problems;
  for (std::size_t b = 0; b < scene_->soft->bodyCount(); ++b) {
    SoftBody& body = *scene_->soft->body(b);
    SoftBodySettings wanted = changed(body.settings(), made_[b], settings_);
    Result<void> done = body.change(wanted);
    if (done) continue;
    wanted.pressure = made_[b].pressure;
    const Result<void> otherwise = body.change(wanted);
    if (tellPressure || !otherwise) problems.push_back("body " + std::to_string(b) + ": " + done.error());
  }
  if (problems.size() > 1) return problems[0] + "; and " + std::to_string(problems.size() - 1) + " more";
  return joined(problems);
}

// Bullet gives a new gravity only to bodies that are awake.
void Session::applyGravity() {
  btDiscreteDynamicsWorld& world = scene_->world->dynamics;
  for (int i = 0; i < world.getNumCollisionObjects(); ++i) world.getCollisionObjectArray()[i]->activate();
  world.setGravity(btVector3(0, btScalar(-settings_[Setting::Gravity]), 0));
  for (std::size_t b = 0; b < scene_->soft->bodyCount(); ++b) scene_->soft->body(b)->wake();
}

// --- pace --------------------------------------------------------------------------------------------------

int Pace::ticksDue(double seconds) {
  constexpr double kMaxTicks = 4.0;  // a frame
  if (paused) return std::exchange(steps_, 0);
  steps_ = 0;
  const double ticks = seconds * speed * static_cast<double>(scenes::kTicksPerSecond);
  remainder_ += std::clamp(ticks, 0.0, kMaxTicks);
  const double due = std::floor(remainder_);
  remainder_ -= due;
  return static_cast<int>(due);
}

double slowerThan(double speed) {
  constexpr double kSlowest = 0.05, kShare = 0.25;
  return speed * kShare < kSlowest ? 1.0 : speed * kShare;
}

}  // namespace limber::demo

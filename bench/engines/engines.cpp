// SPDX-License-Identifier: Zlib
#include "engines/engines.h"

#include "scenes/scene.h"

#include <limber/contacts.h>
#include <limber/soft_body_system.h>

#include <cstdlib>
#include <map>
#include <stdexcept>
#include <utility>

namespace limber::bench {
namespace {

/// Returns a matrix with these columns.
template <class Get>
Eigen::Matrix3Xd columns(std::size_t count, Get get) {
  Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) all.col(static_cast<Eigen::Index>(i)) = get(i);
  return all;
}

// --- Limber ---

/// Sets given positions and velocities. Requests points only if these are given: points cost less while they
/// are not exposed.
void setInitialState(SoftBody& body, const BodySetup& setup) {
  if (!setup.positions.cols() && !setup.velocities.cols()) return;
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
    btRigidBody& point = *body.point(i);
    if (setup.positions.cols()) point.getWorldTransform().setOrigin(toBullet(setup.positions.col(i)));
    if (setup.velocities.cols()) point.setLinearVelocity(toBullet(setup.velocities.col(i)));
  }
}

void keepAwake(SoftBody& body) {
  if (btCollisionObject* surface = body.surfaceObject())
    return surface->setActivationState(DISABLE_DEACTIVATION);
  for (std::uint32_t i = 0; i < body.pointCount(); ++i)
    body.point(i)->setActivationState(DISABLE_DEACTIVATION);
}

/// Changes the setting of a key; ignores keys of other engines.
void change(SoftBodySettings& settings, const std::string& key, const std::string& value) {
  static const std::map<std::string, Stepper> kSteppers = {{"auto", Stepper::Auto},
                                                           {"verlet", Stepper::Verlet},
                                                           {"midpoint", Stepper::ImplicitMidpoint},
                                                           {"newton", Stepper::Newton}};
  Stepping& stepping = settings.stepping;
  const double number = std::strtod(value.c_str(), nullptr);
  if (key == "stepper") stepping.stepper = kSteppers.at(value);
  if (key == "minSubsteps") stepping.minSubsteps = static_cast<int>(number);
  if (key == "maxSubsteps") stepping.maxSubsteps = static_cast<int>(number);
  if (key == "periodTolerance") stepping.periodTolerance = number;
  if (key == "relativeTolerance") stepping.relativeTolerance = number;
  if (key == "searchDistance") stepping.searchDistance = number;
  if (key == "collision") settings.collision = value == "points" ? Collision::Points : Collision::Surface;
}

class LimberEngine final : public Engine {
 public:
  explicit LimberEngine(TuneSettings tune, ParallelFor parallelFor = {}) : tune_(std::move(tune)) {
    soft_.setParallelFor(std::move(parallelFor));
  }

  btDiscreteDynamicsWorld& world() override { return world_.dynamics; }
  void set(const std::string& key, const std::string& value) override { values_[key] = value; }
  std::size_t addBody(const BodySetup& setup) override {
    SoftBodySettings settings = setup.settings;
    // scenes and reference solutions have springs only and no air, as all other engines
    settings.volumeModulus = 0.0;
    settings.flow.drag = settings.flow.linearDrag = 0.0;
    if (tune_) tune_(settings);
    for (const auto& [key, value] : values_) change(settings, key, value);
    SoftBody& body = *valueOf(soft_.createBody(setup.network, settings));
    setInitialState(body, setup);
    if (!setup.maySleep) keepAwake(body);
    for (const std::uint32_t pin : setup.pins) body.pin(pin);
    return soft_.bodyCount() - 1;
  }
  void tick(double dt) override { world().stepSimulation(static_cast<btScalar>(dt), 0); }
  double stepMicroseconds() const override { return 1e3 * soft_.profile().stepMs; }
  double untoldImpulse() const override {
    double sum = 0.0;
    for (std::size_t i = 0; i < soft_.bodyCount(); ++i)
      if (soft_.body(i)->surfaceObject())
        for (const SoftContact& contact : soft_.body(i)->contacts()) sum += contact.normalImpulse;
    return sum;
  }
  Eigen::Matrix3Xd positions(std::size_t body) const override {
    const SoftBody& soft = *soft_.body(body);
    return columns(soft.pointCount(), [&](std::size_t i) { return soft.position(std::uint32_t(i)); });
  }
  Eigen::Matrix3Xd velocities(std::size_t body) const override {
    const SoftBody& soft = *soft_.body(body);
    return columns(soft.pointCount(), [&](std::size_t i) { return soft.velocity(std::uint32_t(i)); });
  }
  int substeps(std::size_t body) const { return soft_.body(body)->substeps(); }
  void setPinned(std::size_t body, std::uint32_t point, bool pinned) override {
    pinned ? soft_.body(body)->pin(point) : soft_.body(body)->unpin(point);
  }
  void addSpring(BodyPoint a, BodyPoint b, const SpringSettings& settings) override {
    const auto end = [&](BodyPoint p) { return SpringEnd{soft_.body(p.body)->point(p.point)}; };
    valueOf(soft_.addSpring(end(a), end(b), settings));
  }

 private:
  TuneSettings tune_;
  std::map<std::string, std::string> values_;  // of set(), after tune_
  scenes::SceneWorld world_;
  SoftBodySystem soft_{world_.dynamics};
};

// --- loose spheres ---

using Spheres = std::vector<std::unique_ptr<btRigidBody>>;

std::unique_ptr<btRigidBody> makeSphere(btSphereShape& shape, double mass, const SoftBodySettings& settings) {
  btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, &shape);
  info.m_friction = static_cast<btScalar>(settings.friction);
  info.m_restitution = static_cast<btScalar>(settings.restitution);
  auto sphere = std::make_unique<btRigidBody>(info);
  sphere->setAngularFactor(btScalar(0));
  sphere->setFlags(sphere->getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
  return sphere;
}

class BareEngine final : public Engine {
 public:
  btDiscreteDynamicsWorld& world() override { return world_.dynamics; }
  std::size_t addBody(const BodySetup& setup) override {
    const BodyStart start = startOf(setup);
    btSphereShape& shape = shapeOf(pointRadius(*setup.network, setup.settings));
    Spheres& spheres = bodies_.emplace_back();
    for (Eigen::Index i = 0; i < start.positions.cols(); ++i) {
      spheres.push_back(makeSphere(shape, start.masses[i], setup.settings));
      btRigidBody& sphere = *spheres.back();
      sphere.setWorldTransform(btTransform(btQuaternion::getIdentity(), toBullet(start.positions.col(i))));
      sphere.setLinearVelocity(toBullet(start.velocities.col(i)));
      if (!setup.maySleep) sphere.setActivationState(DISABLE_DEACTIVATION);
      world().addRigidBody(&sphere);
    }
    for (const std::uint32_t pin : setup.pins) setPinned(bodies_.size() - 1, pin, true);
    return bodies_.size() - 1;
  }
  void tick(double dt) override { world().stepSimulation(static_cast<btScalar>(dt), 0); }
  double stepMicroseconds() const override { return 0.0; }
  Eigen::Matrix3Xd positions(std::size_t body) const override {
    const Spheres& all = bodies_[body];
    return columns(all.size(),
                   [&](std::size_t i) { return fromBullet(all[i]->getWorldTransform().getOrigin()); });
  }
  Eigen::Matrix3Xd velocities(std::size_t body) const override {
    const Spheres& all = bodies_[body];
    return columns(all.size(), [&](std::size_t i) { return fromBullet(all[i]->getLinearVelocity()); });
  }
  void setPinned(std::size_t body, std::uint32_t point, bool pinned) override {
    btRigidBody& sphere = *bodies_[body][point];
    const btScalar free = pinned ? btScalar(0) : btScalar(1);
    sphere.setLinearFactor(btVector3(free, free, free));
    if (pinned) sphere.setLinearVelocity(btVector3(0, 0, 0));
  }

 private:
  btSphereShape& shapeOf(double radius) {
    std::unique_ptr<btSphereShape>& shape = shapes_[radius];
    if (!shape) shape = std::make_unique<btSphereShape>(static_cast<btScalar>(radius));
    return *shape;
  }

  // the world is the last member, so it is destroyed first, while its objects still exist
  std::map<double, std::unique_ptr<btSphereShape>> shapes_;
  std::vector<Spheres> bodies_;
  scenes::SceneWorld world_;
};

}  // namespace

std::unique_ptr<Engine> makeLimberEngine(TuneSettings tune, ParallelFor parallelFor) {
  return std::make_unique<LimberEngine>(std::move(tune), std::move(parallelFor));
}

EngineChoice limberChoice(const std::string& setting, const TuneSettings& tune,
                          const ParallelFor& parallelFor) {
  return {"Limber", setting, [=](const EngineUse&) { return makeLimberEngine(tune, parallelFor); }};
}

int stableSubsteps(const BodySetup& setup, double dt) {
  LimberEngine engine([](SoftBodySettings& s) { s.stepping.stepper = Stepper::Verlet; });
  const std::size_t body = engine.addBody(setup);
  engine.tick(dt);
  return engine.substeps(body);
}

std::unique_ptr<Engine> makeBareEngine() { return std::make_unique<BareEngine>(); }

// --- the list ---

double asleepShare(btDiscreteDynamicsWorld& world) {
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  int movable = 0, asleep = 0;
  for (int i = 0; i < objects.size(); ++i) {
    // Limber's object that marks the step boundary is awake and has no contacts
    if (objects[i]->isStaticObject() || !objects[i]->hasContactResponse()) continue;
    ++movable;
    asleep += !objects[i]->isActive();
  }
  return movable ? static_cast<double>(asleep) / movable : 0.0;
}

std::string iterationsText(int count) {
  return std::to_string(count) + (count == 1 ? " iteration" : " iterations");
}

std::vector<EngineChoice> allEngines() {
  const std::pair<const char*, Stepper> steppers[] = {{"default", Stepper::Auto},
                                                      {"Verlet", Stepper::Verlet},
                                                      {"implicit midpoint", Stepper::ImplicitMidpoint},
                                                      {"Newton", Stepper::Newton}};
  const std::pair<const char*, LinkStiffness> links[] = {{"full stiffness", LinkStiffness::Full},
                                                         {"calibrated", LinkStiffness::Calibrated}};
  std::vector<EngineChoice> choices;
  for (const auto& [name, stepper] : steppers)
    choices.push_back(limberChoice(name, [s = stepper](SoftBodySettings& b) { b.stepping.stepper = s; }));
  for (const int iterations : {1, 4, 10})
    for (const auto& [name, stiffness] : links)
      choices.push_back(
          {"btSoftBody", iterationsText(iterations) + ", " + name,
           [=, s = stiffness](const EngineUse& use) { return makeSoftBodyEngine(use.dt, iterations, s); }});
  for (const bool implicit : {true, false})
    choices.push_back({"btDeformable", implicit ? "implicit" : "explicit",
                       [=](const EngineUse&) { return makeDeformableEngine(implicit); }});
  return choices;
}

std::vector<EngineChoice> wantedEngines(const std::vector<EngineChoice>& engines, const Options& options) {
  std::vector<EngineChoice> wanted;
  for (const EngineChoice& choice : engines) {
    if (!options.wantsEngine(choice.engine, choice.setting)) continue;
    wanted.push_back(choice);
    wanted.back().make = [make = choice.make, sets = options.sets](const EngineUse& use) {
      std::unique_ptr<Engine> engine = make(use);
      for (const auto& [key, value] : sets) engine->set(key, value);
      return engine;
    };
  }
  return wanted;
}

std::vector<Key> withEngineKeys(std::vector<Key> keys) {
  const std::vector<Key> engineKeys = {
      {"stepper", "Limber's stepper", {"auto", "verlet", "midpoint", "newton"}},
      {"minSubsteps", "Limber's smallest number of substeps", 1, 10000},
      {"maxSubsteps", "Limber's largest number of substeps, 0: no limit", 0, 10000},
      {"periodTolerance", "Limber's tolerance of the fastest period", 1e-8, 1},
      {"relativeTolerance", "Limber's tolerance of the error, in sizes per second", 0, 1e6},
      {"searchDistance", "Limber's displacement between searches for contacts, in sizes of triangles", 0.01,
       0.25},
      {"collision", "Limber's kind of collision", {"surface", "points"}},
      {"iterations", "btSoftBody's iterations", 1, 1000},
      {"hardness", "btSoftBody's hardness of contacts, kKHR", 0, 1},
      {"links", "btSoftBody's links, see LinkStiffness", {"full", "calibrated"}}};
  keys.insert(keys.begin(), engineKeys.begin(), engineKeys.end());
  return keys;
}

}  // namespace limber::bench

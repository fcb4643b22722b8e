// SPDX-License-Identifier: Zlib
#include "engines/engines.h"

#include "bullet_soft/body_start.h"

#include <limber/contacts.h>
#include <limber/soft_body_system.h>

#include <cstdlib>
#include <map>
#include <stdexcept>
#include <utility>

namespace limber::bench {
namespace {

class LimberEngine final : public Engine {
 public:
  explicit LimberEngine(TuneSettings tune, ParallelFor parallelFor = {}) : tune_(std::move(tune)) {
    soft_.setParallelFor(std::move(parallelFor));
  }

  btDiscreteDynamicsWorld& world() override { return world_; }
  void set(const std::string& key, const std::string& value) override;
  std::size_t addBody(const BodySetup& setup) override;
  void tick(double dt) override { world_.stepSimulation(static_cast<btScalar>(dt), 0); }
  double stepMicroseconds() const override { return 1e3 * soft_.profile().stepMs; }
  double untoldImpulse() const override;
  Eigen::Matrix3Xd positions(std::size_t body) const override;
  Eigen::Matrix3Xd velocities(std::size_t body) const override;
  int substeps(std::size_t body) const { return soft_.body(body)->substeps(); }
  void setPinned(std::size_t body, std::uint32_t point, bool pinned) override {
    pinned ? soft_.body(body)->pin(point) : soft_.body(body)->unpin(point);
  }
  void addSpring(BodyPoint a, BodyPoint b, const SpringSettings& settings) override;

 private:
  TuneSettings tune_;
  std::vector<TuneSettings> changes_;  // after tune_
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  SoftBodySystem soft_{world_};
};

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

void LimberEngine::set(const std::string& key, const std::string& value) {
  const std::map<std::string, Stepper> steppers = {{"auto", Stepper::Auto},
                                                   {"verlet", Stepper::Verlet},
                                                   {"midpoint", Stepper::ImplicitMidpoint},
                                                   {"newton", Stepper::BandedNewton}};
  const auto change = [&](TuneSettings tune) { changes_.push_back(std::move(tune)); };
  if (key == "stepper")
    return change([s = steppers.at(value)](SoftBodySettings& b) { b.stepping.stepper = s; });
  if (key == "collision") {
    const Collision kind = value == "points" ? Collision::Points : Collision::Surface;
    return change([kind](SoftBodySettings& b) { b.collision = kind; });
  }
  const double number = std::strtod(value.c_str(), nullptr);
  const int whole = static_cast<int>(number);
  if (key == "minSubsteps") change([whole](SoftBodySettings& b) { b.stepping.minSubsteps = whole; });
  if (key == "maxSubsteps") change([whole](SoftBodySettings& b) { b.stepping.maxSubsteps = whole; });
  if (key == "periodTolerance")
    change([number](SoftBodySettings& b) { b.stepping.periodTolerance = number; });
  if (key == "relativeTolerance")
    change([number](SoftBodySettings& b) { b.stepping.relativeTolerance = number; });
}

std::size_t LimberEngine::addBody(const BodySetup& setup) {
  SoftBodySettings settings = setup.settings;
  // scenes and reference solutions have springs only and no air, as all other engines
  settings.volumeModulus = 0.0;
  settings.flow.drag = settings.flow.linearDrag = 0.0;
  if (tune_) tune_(settings);
  for (const TuneSettings& change : changes_) change(settings);
  Result<SoftBody*> body = soft_.createBody(setup.network, settings);
  if (!body) throw std::runtime_error(body.error());
  setInitialState(**body, setup);
  if (!setup.maySleep) keepAwake(**body);
  for (const std::uint32_t pin : setup.pins) (*body)->pin(pin);
  return soft_.bodyCount() - 1;
}

void LimberEngine::addSpring(BodyPoint a, BodyPoint b, const SpringSettings& settings) {
  const auto end = [&](BodyPoint p) { return SpringEnd{soft_.body(p.body)->point(p.point)}; };
  const Result<SpringConstraint*> spring = soft_.addSpring(end(a), end(b), settings);
  if (!spring) throw std::runtime_error(spring.error());
}

double LimberEngine::untoldImpulse() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < soft_.bodyCount(); ++i)
    if (soft_.body(i)->surfaceObject())
      for (const SoftContact& contact : soft_.body(i)->contacts()) sum += contact.normalImpulse;
  return sum;
}

Eigen::Matrix3Xd LimberEngine::positions(std::size_t body) const {
  const SoftBody& soft = *soft_.body(body);
  Eigen::Matrix3Xd all(3, soft.pointCount());
  for (std::uint32_t i = 0; i < soft.pointCount(); ++i) all.col(i) = soft.position(i);
  return all;
}

Eigen::Matrix3Xd LimberEngine::velocities(std::size_t body) const {
  const SoftBody& soft = *soft_.body(body);
  Eigen::Matrix3Xd all(3, soft.pointCount());
  for (std::uint32_t i = 0; i < soft.pointCount(); ++i) all.col(i) = soft.velocity(i);
  return all;
}

}  // namespace

std::unique_ptr<Engine> makeLimberEngine(TuneSettings tune) {
  return std::make_unique<LimberEngine>(std::move(tune));
}

std::unique_ptr<Engine> makeLimberEngine(ParallelFor parallelFor) {
  return std::make_unique<LimberEngine>(TuneSettings(), std::move(parallelFor));
}

std::unique_ptr<Engine> makeLimberEngine(Stepper stepper) {
  return makeLimberEngine([stepper](SoftBodySettings& s) { s.stepping.stepper = stepper; });
}

int stableSubsteps(const BodySetup& setup, double dt) {
  LimberEngine engine([](SoftBodySettings& s) { s.stepping.stepper = Stepper::Verlet; });
  const std::size_t body = engine.addBody(setup);
  engine.tick(dt);
  return engine.substeps(body);
}

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#include "accuracy/stage.h"

#include "bullet_soft/body_start.h"

#include <chrono>
#include <cstring>

namespace limber::bench {
namespace {

using Clock = std::chrono::steady_clock;  // a tick can take a microsecond, so the clock must be fast

constexpr double kMaxDistance = 1e4;  // m, larger than any scene

void addToHash(std::uint64_t& hash, const Eigen::Matrix3Xd& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, values.data() + i, sizeof bits);
    hash = (hash ^ bits) * 1099511628211ull;  // FNV-1a
  }
}

BodySetup shifted(BodySetup body, int copy) {
  const Eigen::Vector3d offset(0, 0, 20.0 * copy);
  body.settings.position += offset;
  if (body.positions.size()) body.positions.colwise() += offset;
  return body;
}

bool isLost(const Frame& frame) {
  for (const Eigen::Matrix3Xd& points : frame.positions)
    if (!points.allFinite() || points.cwiseAbs().maxCoeff() > kMaxDistance) return true;
  return false;
}

double manifoldImpulse(const btDiscreteDynamicsWorld& world) {
  const btDispatcher& dispatcher = *world.getDispatcher();
  double impulse = 0.0;
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& manifold =
        *const_cast<btDispatcher&>(dispatcher).getManifoldByIndexInternal(m);
    for (int p = 0; p < manifold.getNumContacts(); ++p)
      impulse += double(manifold.getContactPoint(p).getAppliedImpulse());
  }
  return impulse;
}

}  // namespace

Stage::Stage(const Scene& scene, const EngineChoice& choice, double dt)
    : scene_(scene),
      engine_(choice.make(dt)),
      dt_(dt),
      ticks_(static_cast<int>(std::lround(scene.seconds / dt))) {
  engine_->world().setGravity(toBullet(scene.gravity));
  if (scene.addRigidBodies) scene.addRigidBodies(rigid_, engine_->world());
  for (int copy = 0; copy < scene.copies; ++copy)
    for (const BodySetup& body : scene.bodies) engine_->addBody(shifted(body, copy));
  trace_.dt = dt;
  record();
}

void Stage::advance(int ticks) {
  for (; ticks > 0 && !over(); --ticks) {
    const auto start = Clock::now();
    engine_->tick(dt_);
    const double tick = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
    tickMicroseconds_.push_back(tick / scene_.copies);
    if (engine_->stepMicroseconds() >= 0.0)
      stepMicroseconds_.push_back(engine_->stepMicroseconds() / scene_.copies);
    ++tick_;
    record();
  }
}

Frame Stage::currentFrame() const {
  Frame frame;
  for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
    frame.positions.push_back(engine_->positions(i));
    frame.velocities.push_back(engine_->velocities(i));
  }
  for (const auto& body : rigid_.bodies)
    if (!body->isStaticObject()) frame.boxes.push_back(fromBullet(body->getWorldTransform().getOrigin()));
  frame.contactImpulse = manifoldImpulse(engine_->world()) + engine_->untoldImpulse();
  return frame;
}

void Stage::record() {
  Frame frame = currentFrame();
  lost_ = isLost(frame);
  const double remaining = (ticks_ - tick_ + 1) * dt_;  // s, from the previous frame to the scene's end
  if (remaining > scene_.keepSeconds + 0.5 * dt_) trace_.frames.clear();
  trace_.frames.push_back(std::move(frame));
}

std::uint64_t Stage::hash() const {
  std::uint64_t hash = 14695981039346656037ull;
  for (const auto& points : trace_.last().positions) addToHash(hash, points);
  for (const auto& speeds : trace_.last().velocities) addToHash(hash, speeds);
  return hash;
}

}  // namespace limber::bench

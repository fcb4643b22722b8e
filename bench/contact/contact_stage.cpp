// SPDX-License-Identifier: Zlib
#include "contact/contact_stage.h"

#include "results.h"
#include "scenes/overlap.h"
#include "timing.h"

#include <algorithm>
#include <cmath>

namespace limber::bench {
namespace {

constexpr double kFar = 1e3;  // m, from the origin

/// s of the thread per tick after the first, which initialises. Engines a hundred times too slow are stopped.
constexpr double kTooSlow = 2.0;

std::vector<Eigen::Matrix3Xd> allPositions(const Engine& engine, std::size_t count) {
  std::vector<Eigen::Matrix3Xd> all;
  for (std::size_t b = 0; b < count; ++b) all.push_back(engine.positions(b));
  return all;
}

}  // namespace

ContactStage::ContactStage(const ContactScene& scene, const EngineChoice& choice)
    : scene_(scene), solids_(choice.engine != kLooseSpheres) {
  engine_ = open(scene, choice, {kContactTick, scene.role == Role::Pile}, rigid_);
  for (const BodySetup& body : scene.bodies) points_ += body.network->restPoints.size();
}

ContactStage::~ContactStage() {
  for (auto& body : rigid_.bodies) engine_->world().removeRigidBody(body.get());
}

void ContactStage::tick() {
  if (done_ + 1 == scene_.settleTicks + scene_.measuredTicks)
    before_ = allPositions(*engine_, scene_.bodies.size());
  const Stopwatch watch;
  engine_->tick(kContactTick);
  const WorkTime time = watch.time();
  seconds_ += 1e-3 * time.cpuMs;
  if (done_ > 0) laterSeconds_ += 1e-3 * time.cpuMs;
  if (done_++ < scene_.settleTicks) return;
  ticks_.push_back(time.cpuMs);
  wallTicks_.push_back(time.wallMs);
}

/// Fails a scene whose bodies have left it: their times are meaningless.
void ContactStage::checkPlaces() {
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Eigen::Matrix3Xd x = engine_->positions(b);
    if (!x.allFinite() || x.cwiseAbs().maxCoeff() > kFar) error_ = "flies apart";
    for (Eigen::Index i = 0; error_.empty() && i < x.cols(); ++i)
      if (scene_.distance(x.col(i)) < -scene_.size) error_ = "goes through what it should lie on";
  }
}

void ContactStage::advance(int ticks, double timeLimit) {
  for (int i = 0; i < ticks && !over(); ++i) {
    tick();
    const bool tooSlow = laterSeconds_ > kTooSlow * std::max(1, done_ - 1);
    if ((tooSlow || seconds_ > timeLimit) && !over())
      error_ = format("given up after %d ticks: %.0f ms each", done_, 1e3 * seconds_ / done_);
  }
  if (error_.empty()) checkPlaces();
}

double ContactStage::deepestPenetration() const {
  double deepest = 0.0;
  std::vector<scenes::PosedSurface> surfaces;
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const BodySetup& body = scene_.bodies[b];
    const Eigen::Matrix3Xd x = engine_->positions(b);
    const double radius = pointRadius(*body.network, body.settings);
    for (Eigen::Index i = 0; i < x.cols(); ++i)
      deepest = std::max(deepest, radius - scene_.distance(x.col(i)));
    if (solids_ && scene_.role == Role::Pile) surfaces.push_back(scenes::posed(x, body.network->surface));
  }
  return std::max(deepest, scenes::deepestOverlap(surfaces).depth);
}

double ContactStage::stretch() const {
  double sum = 0.0, count = 0.0;
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const SpringNetwork& network = *scene_.bodies[b].network;
    const Eigen::Vector3d& scale = scene_.bodies[b].settings.scale;
    const Eigen::Matrix3Xd x = engine_->positions(b);
    for (const NetworkSpring& spring : network.springs) {
      if (spring.kind != SpringKind::Structural) continue;
      const Eigen::Vector3d rest = network.restPoints[spring.b] - network.restPoints[spring.a];
      const double strain =
          (x.col(spring.b) - x.col(spring.a)).norm() / rest.cwiseProduct(scale).norm() - 1.0;
      sum += strain * strain, ++count;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

double ContactStage::residualSpeed() const {
  double sum = 0.0;
  for (std::size_t b = 0; b < before_.size(); ++b) sum += (engine_->positions(b) - before_[b]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(points_)) / kContactTick;
}

}  // namespace limber::bench

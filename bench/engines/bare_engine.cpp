// SPDX-License-Identifier: Zlib
#include "engines/engines.h"

#include "bullet_soft/body_start.h"

#include <map>

namespace limber::bench {
namespace {

using Spheres = std::vector<std::unique_ptr<btRigidBody>>;

class BareEngine final : public Engine {
 public:
  btDiscreteDynamicsWorld& world() override { return world_; }
  void set(const std::string&, const std::string&) override {}
  std::size_t addBody(const BodySetup& setup) override;
  void tick(double dt) override { world_.stepSimulation(static_cast<btScalar>(dt), 0); }
  double stepMicroseconds() const override { return 0.0; }
  Eigen::Matrix3Xd positions(std::size_t body) const override;
  Eigen::Matrix3Xd velocities(std::size_t body) const override;
  void setPinned(std::size_t body, std::uint32_t point, bool pinned) override;

 private:
  btSphereShape& shapeOf(double radius);

  // the world is the last member, so it is destroyed first, while its objects still exist
  std::map<double, std::unique_ptr<btSphereShape>> shapes_;
  std::vector<Spheres> bodies_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
};

btSphereShape& BareEngine::shapeOf(double radius) {
  std::unique_ptr<btSphereShape>& shape = shapes_[radius];
  if (!shape) shape = std::make_unique<btSphereShape>(static_cast<btScalar>(radius));
  return *shape;
}

std::unique_ptr<btRigidBody> makeSphere(btSphereShape& shape, double mass, const SoftBodySettings& settings) {
  btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, &shape);
  info.m_friction = static_cast<btScalar>(settings.friction);
  info.m_restitution = static_cast<btScalar>(settings.restitution);
  auto sphere = std::make_unique<btRigidBody>(info);
  sphere->setAngularFactor(btScalar(0));
  sphere->setFlags(sphere->getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
  return sphere;
}

std::size_t BareEngine::addBody(const BodySetup& setup) {
  const BodyStart start = startOf(setup);
  btSphereShape& shape = shapeOf(pointRadius(*setup.network, setup.settings));
  Spheres& spheres = bodies_.emplace_back();
  for (Eigen::Index i = 0; i < start.positions.cols(); ++i) {
    spheres.push_back(makeSphere(shape, start.masses[i], setup.settings));
    btRigidBody& sphere = *spheres.back();
    sphere.setWorldTransform(btTransform(btQuaternion::getIdentity(), toBullet(start.positions.col(i))));
    sphere.setLinearVelocity(toBullet(start.velocities.col(i)));
    if (!setup.maySleep) sphere.setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(&sphere);
  }
  for (const std::uint32_t pin : setup.pins) setPinned(bodies_.size() - 1, pin, true);
  return bodies_.size() - 1;
}

Eigen::Matrix3Xd BareEngine::positions(std::size_t body) const {
  const Spheres& spheres = bodies_[body];
  Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(spheres.size()));
  for (std::size_t i = 0; i < spheres.size(); ++i)
    all.col(static_cast<Eigen::Index>(i)) = fromBullet(spheres[i]->getWorldTransform().getOrigin());
  return all;
}

Eigen::Matrix3Xd BareEngine::velocities(std::size_t body) const {
  const Spheres& spheres = bodies_[body];
  Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(spheres.size()));
  for (std::size_t i = 0; i < spheres.size(); ++i)
    all.col(static_cast<Eigen::Index>(i)) = fromBullet(spheres[i]->getLinearVelocity());
  return all;
}

void BareEngine::setPinned(std::size_t body, std::uint32_t point, bool pinned) {
  btRigidBody& sphere = *bodies_[body][point];
  const btScalar free = pinned ? btScalar(0) : btScalar(1);
  sphere.setLinearFactor(btVector3(free, free, free));
  if (pinned) sphere.setLinearVelocity(btVector3(0, 0, 0));
}

}  // namespace

std::unique_ptr<Engine> makeBareEngine() { return std::make_unique<BareEngine>(); }

}  // namespace limber::bench

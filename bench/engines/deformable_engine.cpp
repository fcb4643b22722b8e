// SPDX-License-Identifier: Zlib
#include "bullet_soft/bullet_soft_body.h"
#include "engines/bullet_soft_engines.h"

#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <stdexcept>

namespace limber::bench {
namespace {

class DeformableEngine final : public Engine {
 public:
  explicit DeformableEngine(bool implicit);
  ~DeformableEngine() override;

  btDiscreteDynamicsWorld& world() override { return world_; }
  void set(const std::string&, const std::string&) override {}
  std::size_t addBody(const BodySetup& setup) override;
  void tick(double dt) override { world_.stepSimulation(static_cast<btScalar>(dt), 0); }
  double stepMicroseconds() const override { return -1.0; }
  Eigen::Matrix3Xd positions(std::size_t body) const override { return nodePositions(bodies_[body]); }
  Eigen::Matrix3Xd velocities(std::size_t body) const override { return nodeVelocities(bodies_[body]); }
  void setPinned(std::size_t body, std::uint32_t point, bool pinned) override {
    pinNode(bodies_[body], point, pinned);
  }

 private:
  void addForce(btSoftBody& body, std::unique_ptr<btDeformableLagrangianForce> force);

  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btDeformableBodySolver bodySolver_;
  btDeformableMultiBodyConstraintSolver solver_;
  btDeformableMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_,
                                            &bodySolver_};
  std::vector<BulletSoftBody> bodies_;
  std::vector<std::unique_ptr<btDeformableLagrangianForce>> forces_;
};

DeformableEngine::DeformableEngine(bool implicit) {
  solver_.setDeformableSolver(&bodySolver_);
  world_.setImplicit(implicit);
  world_.setUseProjection(implicit);  // its implicit step supports projected constraints only
  bodySolver_.setImplicit(implicit);
  world_.getSolverInfo().m_splitImpulse = 0;  // with it, bodies resting on a floor are thrown through it
}

DeformableEngine::~DeformableEngine() {
  for (const BulletSoftBody& soft : bodies_) world_.removeSoftBody(soft.body.get());
}

void DeformableEngine::addForce(btSoftBody& body, std::unique_ptr<btDeformableLagrangianForce> force) {
  world_.addForce(&body, force.get());
  forces_.push_back(std::move(force));
}

/// Returns the spring constant of the bending springs or of all others. They must all have the same.
double commonStiffness(const BodySetup& setup, const BodyStart& start, bool bending) {
  double common = -1.0;
  for (Eigen::Index s = 0; s < start.stiffnesses.size(); ++s) {
    const bool isBending = setup.network->springs[static_cast<std::size_t>(s)].kind == SpringKind::Bending;
    if (isBending != bending) continue;
    if (common >= 0.0 && start.stiffnesses[s] != common)
      throw std::runtime_error("btDeformable has no spring constant of its own for each spring");
    common = start.stiffnesses[s];
  }
  return std::max(common, 0.0);
}

std::size_t DeformableEngine::addBody(const BodySetup& setup) {
  const BodyStart start = startOf(setup);
  const double stiffness = commonStiffness(setup, start, false),
               bending = commonStiffness(setup, start, true);
  BulletSoftBody soft = makeBulletSoftBody(setup, start, world_.getWorldInfo());
  world_.getWorldInfo().m_gravity = world_.getGravity();
  soft.body->m_cfg.collisions = btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN;
  if (soft.body->m_faces.size()) soft.body->m_cfg.collisions |= btSoftBody::fCollision::VF_DD;
  if (!setup.maySleep) soft.body->m_sleepingThreshold = 0;
  world_.addSoftBody(soft.body.get());
  addForce(*soft.body, std::make_unique<btDeformableMassSpringForce>(
                           static_cast<btScalar>(stiffness), static_cast<btScalar>(setup.settings.damping),
                           true, bending));
  addForce(*soft.body, std::make_unique<btDeformableGravityForce>(world_.getGravity()));
  bodies_.push_back(std::move(soft));
  return bodies_.size() - 1;
}

}  // namespace

std::unique_ptr<Engine> makeDeformableEngine(bool implicit) {
  return std::make_unique<DeformableEngine>(implicit);
}

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#include "engines/engines.h"

#include "bullet_soft/bullet_soft_body.h"

#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <cmath>
#include <cstdlib>
#include <stdexcept>

namespace limber::bench {
namespace {

/// What Bullet's two worlds with soft bodies have in common.
class BulletSoftEngine : public Engine {
 public:
  Eigen::Matrix3Xd positions(std::size_t body) const override { return nodePositions(bodies_[body]); }
  Eigen::Matrix3Xd velocities(std::size_t body) const override { return nodeVelocities(bodies_[body]); }
  void setPinned(std::size_t body, std::uint32_t point, bool pinned) override {
    pinNode(bodies_[body], point, pinned);
  }

 protected:
  std::vector<BulletSoftBody> bodies_;
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
};

// --- btSoftBody ---

void setContacts(btSoftBody& body, SoftContacts contacts) {
  using Flags = btSoftBody::fCollision;
  constexpr int kClusters = 8;
  if (contacts != SoftContacts::PointsAndFaces) body.m_fdbvt.clear();  // else updated in every tick
  if (contacts == SoftContacts::Points || body.m_faces.size() == 0) {
    body.m_cfg.collisions = Flags::SDF_RS;
  } else if (contacts == SoftContacts::PointsAndFaces) {
    body.m_cfg.collisions = Flags::SDF_RS | Flags::VF_SS;
  } else {
    body.generateClusters(kClusters);
    body.m_cfg.collisions =
        (contacts == SoftContacts::Clusters ? Flags::CL_RS : Flags::SDF_RS) | Flags::CL_SS;
  }
}

class SoftBodyEngine final : public BulletSoftEngine {
 public:
  SoftBodyEngine(double dt, int iterations, LinkStiffness stiffness, SoftContacts contacts, double hardness)
      : dt_(dt), iterations_(iterations), stiffness_(stiffness), contacts_(contacts), hardness_(hardness) {}
  ~SoftBodyEngine() override {
    for (const BulletSoftBody& soft : bodies_) world_.removeSoftBody(soft.body.get());
  }

  btDiscreteDynamicsWorld& world() override { return world_; }
  void set(const std::string& key, const std::string& value) override {
    if (key == "iterations") iterations_ = static_cast<int>(std::strtod(value.c_str(), nullptr));
    if (key == "hardness") hardness_ = std::strtod(value.c_str(), nullptr);
    if (key == "links") stiffness_ = value == "full" ? LinkStiffness::Full : LinkStiffness::Calibrated;
  }
  std::size_t addBody(const BodySetup& setup) override {
    const BodyStart start = startOf(setup);
    world_.getWorldInfo().m_gravity = world_.getGravity();
    BulletSoftBody soft = makeBulletSoftBody(setup, start, world_.getWorldInfo());
    if (stiffness_ == LinkStiffness::Calibrated)
      calibrateLinks(soft, *setup.network, start, iterations_, dt_);
    soft.body->m_cfg.piterations = iterations_;
    soft.body->m_cfg.kKHR = static_cast<btScalar>(hardness_);
    setContacts(*soft.body, contacts_);
    soft.body->m_cfg.kDP = static_cast<btScalar>(1.0 - std::exp(-setup.drag * dt_));
    world_.addSoftBody(soft.body.get());
    bodies_.push_back(std::move(soft));
    return bodies_.size() - 1;
  }
  void tick(double dt) override {
    world_.getWorldInfo().m_gravity = world_.getGravity();
    world_.stepSimulation(static_cast<btScalar>(dt), 0);
  }

 private:
  double dt_;
  int iterations_;
  LinkStiffness stiffness_;
  SoftContacts contacts_;
  double hardness_;
  btSequentialImpulseConstraintSolver solver_;
  btSoftRigidDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
};

// --- btDeformable ---

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

class DeformableEngine final : public BulletSoftEngine {
 public:
  explicit DeformableEngine(bool implicit) {
    solver_.setDeformableSolver(&bodySolver_);
    world_.setImplicit(implicit);
    world_.setUseProjection(implicit);  // its implicit step supports projected constraints only
    bodySolver_.setImplicit(implicit);
    world_.getSolverInfo().m_splitImpulse = 0;  // with it, bodies resting on a floor are thrown through it
  }
  ~DeformableEngine() override {
    for (const BulletSoftBody& soft : bodies_) world_.removeSoftBody(soft.body.get());
  }

  btDiscreteDynamicsWorld& world() override { return world_; }
  std::size_t addBody(const BodySetup& setup) override {
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
  void tick(double dt) override { world_.stepSimulation(static_cast<btScalar>(dt), 0); }

 private:
  void addForce(btSoftBody& body, std::unique_ptr<btDeformableLagrangianForce> force) {
    world_.addForce(&body, force.get());
    forces_.push_back(std::move(force));
  }

  btDeformableBodySolver bodySolver_;
  btDeformableMultiBodyConstraintSolver solver_;
  btDeformableMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_,
                                            &bodySolver_};
  std::vector<std::unique_ptr<btDeformableLagrangianForce>> forces_;
};

}  // namespace

std::unique_ptr<Engine> makeSoftBodyEngine(double dt, int iterations, LinkStiffness stiffness,
                                           SoftContacts contacts, double hardness) {
  return std::make_unique<SoftBodyEngine>(dt, iterations, stiffness, contacts, hardness);
}

std::unique_ptr<Engine> makeDeformableEngine(bool implicit) {
  return std::make_unique<DeformableEngine>(implicit);
}

}  // namespace limber::bench

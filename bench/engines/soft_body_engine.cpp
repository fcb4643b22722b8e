// SPDX-License-Identifier: Zlib
#include "bullet_soft/bullet_soft_body.h"
#include "engines/bullet_soft_engines.h"

#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <cmath>
#include <cstdlib>

namespace limber::bench {
namespace {

class SoftBodyEngine final : public Engine {
 public:
  SoftBodyEngine(double dt, int iterations, LinkStiffness stiffness, SoftContacts contacts, double hardness)
      : dt_(dt), iterations_(iterations), stiffness_(stiffness), contacts_(contacts), hardness_(hardness) {}
  ~SoftBodyEngine() override;

  btDiscreteDynamicsWorld& world() override { return world_; }
  void set(const std::string& key, const std::string& value) override;
  std::size_t addBody(const BodySetup& setup) override;
  void tick(double dt) override;
  double stepMicroseconds() const override { return -1.0; }
  Eigen::Matrix3Xd positions(std::size_t body) const override { return nodePositions(bodies_[body]); }
  Eigen::Matrix3Xd velocities(std::size_t body) const override { return nodeVelocities(bodies_[body]); }
  void setPinned(std::size_t body, std::uint32_t point, bool pinned) override {
    pinNode(bodies_[body], point, pinned);
  }

 private:
  double dt_;
  int iterations_;
  LinkStiffness stiffness_;
  SoftContacts contacts_;
  double hardness_;
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btSoftRigidDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<BulletSoftBody> bodies_;
};

SoftBodyEngine::~SoftBodyEngine() {
  for (const BulletSoftBody& soft : bodies_) world_.removeSoftBody(soft.body.get());
}

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

std::size_t SoftBodyEngine::addBody(const BodySetup& setup) {
  const BodyStart start = startOf(setup);
  world_.getWorldInfo().m_gravity = world_.getGravity();
  BulletSoftBody soft = makeBulletSoftBody(setup, start, world_.getWorldInfo());
  if (stiffness_ == LinkStiffness::Calibrated) calibrateLinks(soft, *setup.network, start, iterations_, dt_);
  soft.body->m_cfg.piterations = iterations_;
  soft.body->m_cfg.kKHR = static_cast<btScalar>(hardness_);
  setContacts(*soft.body, contacts_);
  soft.body->m_cfg.kDP = static_cast<btScalar>(1.0 - std::exp(-setup.drag * dt_));
  world_.addSoftBody(soft.body.get());
  bodies_.push_back(std::move(soft));
  return bodies_.size() - 1;
}

void SoftBodyEngine::set(const std::string& key, const std::string& value) {
  if (key == "iterations") iterations_ = static_cast<int>(std::strtod(value.c_str(), nullptr));
  if (key == "hardness") hardness_ = std::strtod(value.c_str(), nullptr);
  if (key == "links") stiffness_ = value == "full" ? LinkStiffness::Full : LinkStiffness::Calibrated;
}

void SoftBodyEngine::tick(double dt) {
  world_.getWorldInfo().m_gravity = world_.getGravity();
  world_.stepSimulation(static_cast<btScalar>(dt), 0);
}

}  // namespace

std::unique_ptr<Engine> makeSoftBodyEngine(double dt, int iterations, LinkStiffness stiffness,
                                           SoftContacts contacts, double hardness) {
  return std::make_unique<SoftBodyEngine>(dt, iterations, stiffness, contacts, hardness);
}

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
// Plays a story frame by frame and checks the world after each.
#include "fuzz/player.h"

#include "fuzz/networks.h"
#include "fuzz/world_player.h"

#include "mesh/random.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace limber::fuzz {
namespace {

using Eigen::Vector3d;

/// Above this speed a body has exploded. The fastest velocities in stories are about 50 m/s, and falls last a
/// few seconds. Light points between heavy objects get faster, but not by a factor of 100.
const double kExplosion = 1e4;  ///< m/s

/// Adds the bytes of numbers to a hash (FNV-1a).
struct Hash {
  std::uint64_t value = 1469598103934665603u;
  void add(const double* numbers, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      std::uint64_t bits;
      std::memcpy(&bits, &numbers[i], sizeof bits);
      for (int byte = 0; byte < 8; ++byte) value = (value ^ (bits >> (8 * byte) & 255u)) * 1099511628211u;
    }
  }
  void add(const Vector3d& v) { add(v.data(), 3); }
};

std::string vectorText(const Vector3d& v) {
  char text[120];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g)", v.x(), v.y(), v.z());
  return text;
}

double kineticEnergy(const btRigidBody& body) {
  if (body.getInvMass() == btScalar(0)) return 0.0;
  const btVector3 w = body.getAngularVelocity();
  const btVector3 local = w * body.getWorldTransform().getBasis();
  const btVector3 inverse = body.getInvInertiaDiagLocal();
  double sum = 0.5 / double(body.getInvMass()) * double(body.getLinearVelocity().length2());
  for (int i = 0; i < 3; ++i)
    if (inverse[i] > btScalar(0)) sum += 0.5 * double(local[i]) * double(local[i]) / double(inverse[i]);
  return sum;
}

double elasticEnergy(const SpringConstraint& spring) {
  const double elongation = double(spring.length()) - *spring.settings().restLength;
  if (elongation < 0 && spring.settings().action == SpringAction::ExtensionOnly) return 0.0;
  if (elongation > 0 && spring.settings().action == SpringAction::CompressionOnly) return 0.0;
  return 0.5 * spring.settings().stiffness * elongation * elongation;
}

bool isFinite(const btRigidBody& body) {
  return std::isfinite(double(body.getWorldTransform().getOrigin().length2())) &&
         std::isfinite(double(body.getLinearVelocity().length2())) &&
         std::isfinite(double(body.getAngularVelocity().length2()));
}

}  // namespace

Run play(const Story& story, const PlayOptions& options) {
  WorldPlayer player(story, options);
  return player.run();
}

WorldPlayer::WorldPlayer(const Story& story, const PlayOptions& options)
    : story_(story),
      options_(options),
      settings_(story.first(Kind::World)),
      clock_(Kind::Clock),
      done_(story.steps.size(), 0) {
  makeWorld(settings_);
}

WorldPlayer::~WorldPlayer() {
  // after a failure no checks are needed
  softs_.clear();
  systems_.clear();
  if (world_) removeRest();
}

Run WorldPlayer::run() {
  const Step time = story_.first(Kind::Time);
  clock_.set("dt", time["dt"]).set("fixed", time["fixed"]).set("sub-steps", time["sub-steps"]);
  perform(Phase::Between);
  if (!settings_.is("action-first")) world_->addAction(action_.get());
  observe();
  for (int i = 0; i < time.whole("frames") && !result_.failure; ++i) step(i);
  if (!result_.failure) tearDown();
  return std::move(result_);
}

void WorldPlayer::step(int frame) {
  frame_ = frame;
  perform(Phase::Between);
  const double jitter = story_.first(Kind::Time)["jitter"];
  double dt = clock_["dt"];
  if (jitter > 0) dt *= 1.0 + jitter * (2.0 * Random(static_cast<std::uint64_t>(frame)).uniform() - 1.0);
  moveKinematics(dt);
  // the user's steps may have moved a body near another
  result_.frames.back().near = result_.frames.back().near || softIsNearRigid();
  rigidPairs_ = 0;
  world_->stepSimulation(toBt(dt), clock_.whole("sub-steps"), toBt(clock_["fixed"]));
  observe();
}

/// Moves kinematic bodies by their velocity and spin, directly or through their motion state.
void WorldPlayer::moveKinematics(double seconds) {
  for (auto& [id, object] : rigids_) {
    if (!object.moves || !object.body->isKinematicObject()) continue;
    btTransform to;
    if (object.body->getMotionState())
      object.body->getMotionState()->getWorldTransform(to);
    else
      to = object.body->getWorldTransform();
    to.setOrigin(to.getOrigin() + toBt(object.velocity * seconds));
    to.setBasis(btMatrix3x3(rotationOf(object.spin * seconds)) * to.getBasis());
    if (object.body->getMotionState())
      moveState(*object.body->getMotionState(), to);
    else
      object.body->setWorldTransform(to);
  }
}

// --- looking -----------------------------------------------------------------------------------------------

void WorldPlayer::fail(const std::string& law, const std::string& detail) {
  if (!result_.failure) result_.failure = Failure{law, "frame " + std::to_string(frame_) + ": " + detail};
}

void WorldPlayer::observe() {
  Frame frame;
  Hash hash;
  for (const auto& [id, object] : softs_) {
    // bodies that a listener has destroyed still exist until all its calls are over
    observeSoft(id, *object.body, frame);
    const Eigen::Matrix3Xd& points = frame.soft[id];
    hash.add(points.data(), static_cast<std::size_t>(points.size()));
    observeContacts(id, *object.body);
  }
  for (const auto& [id, object] : rigids_) {
    const btRigidBody& body = *object.body;
    if (!isFinite(body)) fail("finite", "rigid body " + std::to_string(id));
    if (double(body.getLinearVelocity().length()) > kExplosion)
      fail("explodes", "rigid body " + std::to_string(id) + " with " +
                           std::to_string(body.getLinearVelocity().length()) + " m/s");
    const btQuaternion q = body.getWorldTransform().getRotation();
    RigidPose pose{fromBt(body.getWorldTransform().getOrigin()),
                   Eigen::Quaterniond(double(q.w()), double(q.x()), double(q.y()), double(q.z())),
                   !body.isStaticOrKinematicObject()};
    hash.add(pose.position);
    hash.add(pose.rotation.coeffs().data(), 4);
    hash.add(fromBt(body.getLinearVelocity()));
    hash.add(fromBt(body.getAngularVelocity()));
    frame.rigid[id] = pose;
  }
  frame.energy = energy();
  frame.near = softIsNearRigid();
  frame.rigidPairs = std::max(rigidPairs_, touchingRigidPairs());
  frame.hash = hash.value;
  result_.frames.push_back(std::move(frame));
}

void WorldPlayer::observeSoft(int id, const SoftBody& body, Frame& frame) {
  Eigen::Matrix3Xd points(3, body.pointCount());
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
    points.col(i) = body.position(i);
    const Vector3d velocity = body.velocity(i);
    if (!points.col(i).allFinite() || !velocity.allFinite())
      return fail("finite", "point " + std::to_string(i) + " of soft body " + std::to_string(id) + " at " +
                                vectorText(points.col(i)) + ", " + vectorText(velocity) + " m/s");
    if (velocity.norm() > kExplosion)
      fail("explodes", "point " + std::to_string(i) + " of soft body " + std::to_string(id) + " with " +
                           vectorText(velocity) + " m/s");
  }
  if (!std::isfinite(body.errorPerSecond())) fail("finite", "the error of soft body " + std::to_string(id));
  if (const btRigidBody* object = body.surfaceObject()) {
    btVector3 low, high;
    object->getAabb(low, high);
    if (body.alive() && !(std::isfinite(low.length2()) && std::isfinite(high.length2())))
      fail("finite", "the box of soft body " + std::to_string(id));
  }
  frame.soft[id] = std::move(points);
}

void WorldPlayer::observeContacts(int id, SoftBody& body) {
  const std::string name = "a contact of soft body " + std::to_string(id);
  for (const SoftContact& contact : body.contacts()) {
    const Vector3d position = fromBt(contact.position), normal = fromBt(contact.normal),
                   impulse = fromBt(contact.impulse);
    if (!position.allFinite() || !normal.allFinite() || !impulse.allFinite() ||
        !std::isfinite(contact.distance))
      return fail("contacts", name + " is not finite");
    // float precision of a unit vector
    if (std::abs(normal.norm() - 1.0) > 1e-3)
      return fail("contacts", name + " has the normal " + vectorText(normal));
    if (contact.normalImpulse < -1e-4 * (1e-3 + impulse.norm()))
      return fail("contacts", name + " pulls with " + std::to_string(contact.normalImpulse) + " N s");
    for (const ContactSide* side : {&contact.side, &contact.otherSide}) {
      const double sum = side->weights.sum();
      const bool none = sum == 0.0 && side == &contact.otherSide && !contact.otherBody;
      if (!none && (side->weights.minCoeff() < -1e-6 || std::abs(sum - 1.0) > 1e-6))
        return fail("contacts", name + " has the weights " + vectorText(side->weights));
    }
  }
}

double WorldPlayer::energy() const {
  const Vector3d gravity = fromBt(world_->getGravity());
  double sum = 0.0;
  for (const auto& [id, object] : rigids_) {
    const btRigidBody& body = *object.body;
    if (!body.isInWorld() || body.isStaticOrKinematicObject()) continue;
    sum += kineticEnergy(body);
    sum -= gravity.dot(fromBt(body.getWorldTransform().getOrigin())) / double(body.getInvMass());
  }
  for (const auto& [id, object] : softs_) {
    const SoftBody& body = *object.body;
    if (!body.alive()) continue;
    sum += body.kineticEnergy() + body.elasticEnergy() - body.totalMass() * gravity.dot(body.centerOfMass());
  }
  for (const auto& [id, spring] : springs_) sum += elasticEnergy(*spring.spring);
  return sum;
}

/// Whether a soft body is so near a rigid one that they may touch in the next frame.
bool WorldPlayer::softIsNearRigid() const {
  const double dt = clock_["dt"];
  for (const auto& [softId, object] : softs_) {
    const SoftBody& soft = *object.body;
    Eigen::AlignedBox3d box;
    double speed = 0.0;
    for (std::uint32_t i = 0; i < soft.pointCount(); ++i) {
      box.extend(soft.position(i));
      speed = std::max(speed, soft.velocity(i).norm());
    }
    for (const auto& [id, rigidObject] : rigids_) {
      const btRigidBody& body = *rigidObject.body;
      if (body.isStaticOrKinematicObject() || !body.isInWorld()) continue;
      btVector3 low, high;
      body.getAabb(low, high);
      const double relativeSpeed = speed + double(body.getLinearVelocity().length());
      // the distance that both may move, and Bullet's margins of broadphase boxes
      if (box.squaredExteriorDistance(Eigen::AlignedBox3d(fromBt(low), fromBt(high))) <
          std::pow(0.25 + 2.0 * dt * (relativeSpeed + 10.0 * dt), 2))
        return true;
    }
  }
  return false;
}

int WorldPlayer::touchingRigidPairs() const {
  const auto isSoft = [](const btCollisionObject* object) {
    return findSurface(object).body || findPoint(object).body;
  };
  int count = 0;
  for (int i = 0; i < dispatcher_->getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher_->getManifoldByIndexInternal(i);
    if (manifold.getNumContacts() > 0 && !isSoft(manifold.getBody0()) && !isSoft(manifold.getBody1()))
      ++count;
  }
  return count;
}

// --- finding -----------------------------------------------------------------------------------------------

RigidObject* WorldPlayer::rigid(int id) {
  const auto it = rigids_.find(id);
  return it == rigids_.end() ? nullptr : &it->second;
}

SoftObject* WorldPlayer::soft(int id) {
  const auto it = softs_.find(id);
  return it == softs_.end() ? nullptr : &it->second;
}

SoftBody* WorldPlayer::livingSoft(int id) {
  SoftObject* object = soft(id);
  return object && object->body->alive() ? object->body : nullptr;
}

SoftBodySystem* WorldPlayer::systemOf(std::size_t index) {
  return index < systems_.size() ? systems_[index].get() : nullptr;
}

}  // namespace limber::fuzz

// SPDX-License-Identifier: Zlib
#include "bullet/step_sentinel.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// N; anything but 0.
const btVector3 kMark(1, 0, 0);

int sentinelMark;  // see pointMassMark

}  // namespace

class StepSentinel::State final : public btMotionState {
 public:
  explicit State(StepSentinel* owner) : owner_(owner) {}
  ~State() override {
    if (owner_) owner_->state_ = nullptr;
  }
  void disown() { owner_ = nullptr; }
  void getWorldTransform(btTransform& pose) const override { pose.setIdentity(); }
  void setWorldTransform(const btTransform&) override {
    if (owner_) owner_->listener_->motionStatesAsked();
  }

 private:
  StepSentinel* owner_;
};

class StepSentinel::Body final : public btRigidBody {
 public:
  Body(StepSentinel* owner, State* state, btCollisionShape* shape)
      : btRigidBody(btRigidBodyConstructionInfo(0, state, shape)), owner_(owner) {
    internalSetExtensionPointer(&sentinelMark);
    // dynamic to Bullet, or it would neither be in the list whose forces are cleared nor be asked
    setCollisionFlags(CF_NO_CONTACT_RESPONSE | CF_DISABLE_VISUALIZE_OBJECT);
    forceActivationState(DISABLE_DEACTIVATION);
  }
  ~Body() override {
    if (owner_) owner_->body_ = nullptr;
  }
  void disown() { owner_ = nullptr; }

 private:
  StepSentinel* owner_;
};

StepSentinel::StepSentinel(btDiscreteDynamicsWorld& world, StepListener& listener)
    : world_(&world), listener_(&listener), state_(new State(this)) {
  body_ = new Body(this, state_, &shape_);
  world.addRigidBody(body_, 0, 0);
}

StepSentinel::~StepSentinel() {
  if (body_) {
    if (isInWorld()) world_->removeRigidBody(body_);
    body_->disown();
    body_->setMotionState(nullptr);
    delete body_;
  }
  if (state_) {
    state_->disown();
    delete state_;
  }
}

bool StepSentinel::stepHasEnded() {
  if (!isInWorld()) return true;
  const bool ended = body_->getTotalForce() != kMark;
  body_->clearForces();
  body_->applyCentralForce(kMark);
  return ended;
}

bool StepSentinel::isOne(const btCollisionObject* object) {
  return object && object->internalGetExtensionPointer() == &sentinelMark;
}

bool StepSentinel::isInWorld() const { return body_ && body_->isInWorld(); }

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

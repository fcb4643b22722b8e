// SPDX-License-Identifier: Zlib
// The actions of the user of a story, except removals (user_removes.cpp).
#include "fuzz/world_player.h"

#include <limber/contacts.h>

namespace limber::fuzz {
namespace {

using Eigen::Vector3d;

std::uint32_t pointOf(const SoftBody& body, int point) {
  return static_cast<std::uint32_t>(std::abs(point)) % body.pointCount();
}

/// Draws nothing, but reads all lines.
struct CountingDrawer : btIDebugDraw {
  void drawLine(const btVector3& a, const btVector3& b, const btVector3&) override {
    sum += double(a.x() + b.y());
  }
  void drawContactPoint(const btVector3&, const btVector3&, btScalar, int, const btVector3&) override {}
  void reportErrorWarning(const char*) override {}
  void draw3dText(const btVector3&, const char*) override {}
  void setDebugMode(int) override {}
  int getDebugMode() const override {
    return DBG_DrawWireframe | DBG_DrawAabb | DBG_DrawContactPoints | DBG_DrawConstraints;
  }
  double sum = 0.0;
};

/// Bullet's masks, and optionally no pair of objects whose unique ids differ in parity.
struct ParityFilter : btOverlapFilterCallback {
  explicit ParityFilter(bool byParity) : byParity_(byParity) {}
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    if (byParity_ && (a->m_uniqueId + b->m_uniqueId) % 2) return false;
    return (a->m_collisionFilterGroup & b->m_collisionFilterMask) &&
           (b->m_collisionFilterGroup & a->m_collisionFilterMask);
  }
  bool byParity_;
};

bool isScene(Kind kind) { return kind <= Kind::Vehicle; }

/// Actions that a contact listener may perform.
bool allowedInListener(Kind kind) {
  switch (kind) {
    case Kind::Push:
    case Kind::Destroy:
    case Kind::Leave:
    case Kind::Look:
    case Kind::Ray:
    case Kind::Change:
      return true;
    default:
      return false;
  }
}

}  // namespace

void WorldPlayer::perform(Phase phase) {
  const Phase outer = phase_;
  phase_ = phase;
  for (std::size_t i = 0; i < story_.steps.size(); ++i) {
    const Step& step = story_.steps[i];
    if (done_[i] || step.at != frame_ || step.phase != phase) continue;
    if (phase == Phase::Listener && !allowedInListener(step.kind)) continue;
    done_[i] = 1;
    act(step);
  }
  phase_ = outer;
}

void WorldPlayer::act(const Step& s) {
  if (isScene(s.kind)) return build(s);
  switch (s.kind) {
    case Kind::Spring:
    case Kind::ChangeSpring:
    case Kind::Attach:
    case Kind::Detach:
    case Kind::Forget:
      return touchSprings(s);
    case Kind::Pin:
    case Kind::MovePin:
    case Kind::Unpin:
      return touchPoints(s);
    case Kind::Push:
      return push(s);
    case Kind::Velocity:
      return setVelocity(s);
    case Kind::Teleport:
      return teleport(s);
    case Kind::Destroy:
      return destroy(s);
    case Kind::Leave:
      return leave(s);
    case Kind::Enter:
      return enter(s);
    case Kind::Flags:
      return changeFlags(s);
    case Kind::Mass:
    case Kind::Material:
    case Kind::Shape:
    case Kind::Scaling:
      return changeRigid(s);
    case Kind::Filter:
    case Kind::OverlapFilter:
      return changeFilter(s);
    case Kind::Gravity:
      if (RigidObject* object = rigid(s.whole("of")))
        object->body->setGravity(toBt(s.vec("gravity")));
      else
        world_->setGravity(toBt(s.vec("gravity")));
      return;
    case Kind::Look:
      return look(s);
    case Kind::Ray:
      return castRay(s);
    case Kind::Sleep:
      return changeSleep(s);
    case Kind::Sync:
      return synchronize(s);
    case Kind::Clock:
      clock_ = s;
      return;
    case Kind::Surround:
      return surround(s);
    case Kind::Change:
      return changeSoft(s);
    default:
      return changeSystem(s);
  }
}

void WorldPlayer::build(const Step& s) {
  switch (s.kind) {
    case Kind::Floor:
      return addFloor(s);
    case Kind::Rigid:
      return addRigid(s);
    case Kind::Soft:
      return addSoft(s);
    case Kind::Joint:
      return addJoint(s);
    case Kind::MultiBody:
      return addMultiBody(s);
    case Kind::Ghost:
      return addGhost(s);
    case Kind::Character:
      return addCharacter(s);
    case Kind::Vehicle:
      return addVehicle(s);
    default:
      return;
  }
}

/// Returns a rigid body, or point `point` of a soft one; for a negative `point` its surface object.
btRigidBody* WorldPlayer::bodyOf(int id, int point) {
  if (RigidObject* object = rigid(id)) return object->body.get();
  SoftBody* body = livingSoft(id);
  if (!body) return nullptr;
  if (point < 0 && body->surfaceObject()) return body->surfaceObject();
  return body->point(pointOf(*body, point));
}

// --- springs, anchors, pins --------------------------------------------------------------------------------

void WorldPlayer::touchSprings(const Step& s) {
  SpringSettings settings;
  if (s.kind == Kind::Spring || s.kind == Kind::ChangeSpring) {
    if (s["rest"] >= 0.0) settings.restLength = s["rest"];
    settings.stiffness = s["stiffness"];
    settings.damping = s["damping"];
    settings.action = static_cast<SpringAction>(s.whole("action"));
  }
  if (s.kind == Kind::Spring) {
    SoftBodySystem* system = systemOf(static_cast<std::size_t>(s.whole("system")));
    if (!system || springs_.count(s.id)) return;
    SpringObject made;
    made.system = static_cast<std::size_t>(s.whole("system"));
    SpringEnd ends[2];
    for (int i = 0; i < 2; ++i) {
      const char* names[2][3] = {{"a", "point-a", "pivot-a"}, {"b", "point-b", "pivot-b"}};
      made.ends[i] = s.whole(names[i][0]);
      if (const SoftBody* body = livingSoft(made.ends[i]))
        made.points[i] = pointOf(*body, s.whole(names[i][1]));
      ends[i] = {bodyOf(made.ends[i], static_cast<int>(made.points[i])), toBt(s.vec(names[i][2]))};
      // a point mass has no extent, so its pivot is 0
      if (livingSoft(made.ends[i])) ends[i].pivot.setZero();
      if (made.ends[i] && !ends[i].body) return;
    }
    Result<SpringConstraint*> spring = system->addSpring(ends[0], ends[1], settings);
    if (!spring) return;
    made.spring = *spring;
    springs_[s.id] = made;
    return;
  }
  if (s.kind == Kind::Forget) {
    if (RigidObject* object = rigid(s.whole("of"))) forgetEverywhere(*object->body);
    forgetSpringsOn(s.whole("of"));
    return;
  }
  if (s.kind == Kind::ChangeSpring) {
    const auto it = springs_.find(s.whole("of"));
    if (it != springs_.end()) (void)systemOf(it->second.system)->changeSpring(it->second.spring, settings);
    return;
  }
  SoftObject* object = soft(s.whole("of"));
  if (!object || !object->body->alive()) return;
  const std::uint32_t point = pointOf(*object->body, s.whole("point"));
  SoftBodySystem* system = systemOf(object->system);
  if (s.kind == Kind::Detach) {
    (void)system->detach(object->body, point);
    return;
  }
  RigidObject* partner = rigid(s.whole("to"));
  if (!partner) return;
  if (s.is("pivoted"))
    (void)system->attach(object->body, point, *partner->body, toBt(s.vec("pivot")), s["break"]);
  else
    (void)system->attach(object->body, point, *partner->body, s["break"]);
}

void WorldPlayer::touchPoints(const Step& s) {
  SoftBody* body = livingSoft(s.whole("of"));
  if (!body) return;
  const std::uint32_t point = pointOf(*body, s.whole("point"));
  if (!body->point(point)) return;
  if (s.kind == Kind::Pin)
    body->pin(point);
  else if (s.kind == Kind::Unpin)
    body->unpin(point);
  else if (body->pinned(point))
    body->movePin(point, toBt(body->position(point) + s.vec("by")));
}

// --- motion ------------------------------------------------------------------------------------------------

void WorldPlayer::push(const Step& s) {
  btRigidBody* body = bodyOf(s.whole("of"), s.whole("point"));
  if (!body || body->isStaticOrKinematicObject()) return;
  const btVector3 push = toBt(s.vec("push")), off = toBt(s.vec("off"));
  const std::string& kind = s.choice("kind");
  body->activate();
  if (kind == "impulse") body->applyImpulse(push, off);
  // a force that gives the same impulse in 1/60 s
  else if (kind == "force")
    body->applyForce(push * btScalar(60), off);
  else if (kind == "torque")
    body->applyTorque(push * btScalar(60));
  else
    body->applyTorqueImpulse(push);
}

void WorldPlayer::setVelocity(const Step& s) {
  if (RigidObject* object = rigid(s.whole("of"))) {
    object->velocity = s.vec("velocity");
    object->spin = s.vec("spin");
    if (object->body->isStaticOrKinematicObject()) return;
  }
  btRigidBody* body = bodyOf(s.whole("of"), s.whole("point"));
  if (!body) return;
  body->activate();
  body->setLinearVelocity(toBt(s.vec("velocity")));
  body->setAngularVelocity(toBt(s.vec("spin")));
}

void WorldPlayer::teleport(const Step& s) {
  const btTransform by(rotationOf(s.vec("rotation")), toBt(s.vec("by")));
  const auto move = [&](btRigidBody& body) {
    btTransform to = body.getWorldTransform();
    to.setOrigin(to.getOrigin() + by.getOrigin());
    to.setBasis(by.getBasis() * to.getBasis());
    if (s.choice("how") == "motion-state")
      body.setCenterOfMassTransform(to);
    else
      body.setWorldTransform(to);
    if (s.choice("how") == "both-poses") body.setInterpolationWorldTransform(to);
    body.activate();
  };
  SoftBody* soft = livingSoft(s.whole("of"));
  const int point = s.whole("point");
  if (!soft || point >= 0 || s.choice("how") == "surface") {
    if (btRigidBody* body = bodyOf(s.whole("of"), point)) move(*body);
    return;
  }
  for (std::uint32_t i = 0; i < soft->pointCount(); ++i)
    if (btRigidBody* body = soft->point(i)) move(*body);
}

// --- properties --------------------------------------------------------------------------------------------

void WorldPlayer::changeRigid(const Step& s) {
  btRigidBody* body = bodyOf(s.whole("of"), s.kind == Kind::Mass ? s.whole("point") : 0);
  if (!body) return;
  if (s.kind == Kind::Material) {
    body->setFriction(toBt(s["friction"]));
    body->setRestitution(toBt(s["restitution"]));
    body->setRollingFriction(toBt(s["rolling"]));
    return;
  }
  RigidObject* object = rigid(s.whole("of"));
  if (s.kind == Kind::Mass) {
    if (body->getInvMass() == btScalar(0)) return;
    btVector3 inertia(0, 0, 0);
    if (object) body->getCollisionShape()->calculateLocalInertia(toBt(s["mass"]), inertia);
    body->setMassProps(toBt(s["mass"]), inertia);
    body->updateInertiaTensor();
    return;
  }
  // Bullet caches data of the old shape in the pairs, so the body is removed and added again
  if (!object || phase_ == Phase::Listener || vehicles_.count(s.whole("of"))) return;
  const bool inWorld = body->isInWorld();
  if (s.kind == Kind::Scaling && object->shape.shape) {
    object->shape.shape->setLocalScaling(toBt(s.vec("scale")));
    if (inWorld) world_->updateSingleAabb(body);
    return;
  }
  OwnedShape shape = makeShape(s.choice("shape"), s.vec("size"), s.whole("variant"));
  if (shape.fixed && !body->isStaticOrKinematicObject()) return;
  if (inWorld) world_->removeRigidBody(body);
  body->setCollisionShape(shape.shape.get());
  object->shape = std::move(shape);
  if (inWorld && object->group)
    world_->addRigidBody(body, object->group, object->mask);
  else if (inWorld)
    world_->addRigidBody(body);
}

void WorldPlayer::changeFilter(const Step& s) {
  if (s.kind == Kind::OverlapFilter) {
    filter_ = s.is("on") ? std::make_unique<ParityFilter>(s.is("parity")) : nullptr;
    broadphase_->getOverlappingPairCache()->setOverlapFilterCallback(filter_.get());
    return;
  }
  btRigidBody* body = bodyOf(s.whole("of"), -1);
  if (!body || !body->getBroadphaseHandle()) return;
  RigidObject* object = rigid(s.whole("of"));
  if (s.is("in-place") || !object || !body->isInWorld()) {
    body->getBroadphaseHandle()->m_collisionFilterGroup = s.whole("group");
    body->getBroadphaseHandle()->m_collisionFilterMask = s.whole("mask");
    return;
  }
  world_->removeRigidBody(body);
  world_->addRigidBody(body, s.whole("group"), s.whole("mask"));
}

void WorldPlayer::changeFlags(const Step& s) {
  btRigidBody* body = bodyOf(s.whole("of"), -1);
  RigidObject* object = rigid(s.whole("of"));
  if (!body) return;
  const std::string& name = s.choice("flag");
  // changing these flags of a body with a vehicle or a joint is the user's error
  if (name != "no-response" && (!object || vehicles_.count(s.whole("of")))) return;
  int flag = btCollisionObject::CF_NO_CONTACT_RESPONSE;
  if (name == "static") flag = btCollisionObject::CF_STATIC_OBJECT;
  if (name.rfind("kinematic", 0) == 0) flag = btCollisionObject::CF_KINEMATIC_OBJECT;
  const int old = body->getCollisionFlags();
  if (s.is("on"))
    body->setCollisionFlags(old | flag);
  else if (flag != btCollisionObject::CF_STATIC_OBJECT || body->getInvMass() > 0)
    body->setCollisionFlags(old & ~flag);
  body->activate(true);
}

void WorldPlayer::changeSleep(const Step& s) {
  const std::string& state = s.choice("state");
  SoftBody* soft = livingSoft(s.whole("of"));
  if (soft && state == "wake") return soft->wake();
  btRigidBody* body = bodyOf(s.whole("of"), -1);
  if (!body || (!soft && body->isStaticOrKinematicObject())) return;
  if (state == "wake")
    body->activate();
  else if (state == "sleep")
    body->setActivationState(ISLAND_SLEEPING);
  else if (state == "never-sleep")
    body->setActivationState(DISABLE_DEACTIVATION);
  else
    body->forceActivationState(ACTIVE_TAG);
}

// --- reading -----------------------------------------------------------------------------------------------

void WorldPlayer::look(const Step& s) {
  CountingDrawer drawer;
  if (s.choice("what") == "draw") {
    for (const auto& system : systems_)
      if (system) system->debugDraw(drawer);
    return;
  }
  if (const SoftBody* body = livingSoft(s.whole("of"))) lookAt(*body, s);
}

void WorldPlayer::lookAt(const SoftBody& body, const Step& s) {
  const std::string& what = s.choice("what");
  std::vector<float> xyz(3 * std::max(body.pointCount(), body.skinnedPointCount()));
  if (what == "positions")
    body.writePositions(xyz.data(), s["fraction"]);
  else if (what == "places")
    body.writeSkinnedPositions(xyz.data(), s["fraction"]);
  else if (what == "contacts")
    (void)body.contacts();
  else
    xyz.push_back(static_cast<float>(body.centerOfMass().x() + body.kineticEnergy() + body.elasticEnergy() +
                                     body.angularMomentum().y() + body.totalMass()));
  for (const float value : xyz)
    if (!std::isfinite(value)) return fail("finite", "what is written of a soft body, " + what);
}

void WorldPlayer::castRay(const Step& s) {
  const btVector3 from = toBt(s.vec("from")), to = toBt(s.vec("to"));
  const std::string& what = s.choice("what");
  if (what == "ray" || what == "all") {
    btCollisionWorld::ClosestRayResultCallback hit(from, to);
    world_->rayTest(from, to, hit);
    if (hit.hasHit() && findSurface(hit.m_collisionObject).body)
      (void)surfaceHit(hit.m_collisionObject, 0, hit.m_hitPointWorld);
  }
  if (what == "sweep" || what == "all") {
    const btSphereShape ball(btScalar(0.2));
    btCollisionWorld::ClosestConvexResultCallback hit(from, to);
    world_->convexSweepTest(&ball, btTransform(btQuaternion::getIdentity(), from),
                            btTransform(btQuaternion::getIdentity(), to), hit);
  }
  if (what == "contact" || what == "all") {
    struct Ignore : btCollisionWorld::ContactResultCallback {
      btScalar addSingleResult(btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                               const btCollisionObjectWrapper*, int, int) override {
        return 0;
      }
    } ignore;
    btRigidBody* body = bodyOf(s.whole("of"), -1);
    if (body && body->isInWorld()) world_->contactTest(body, ignore);
  }
}

void WorldPlayer::synchronize(const Step& s) {
  const std::string& what = s.choice("what");
  if (what == "motion-states")
    world_->synchronizeMotionStates();
  else if (what == "clear-forces")
    world_->clearForces();
  else if (what == "apply-gravity")
    world_->applyGravity();
  else if (what == "aabbs")
    world_->updateAabbs();
  else if (what == "no-step" && phase_ == Phase::Between)
    world_->stepSimulation(0, 10);
  else if (what == "reset-caches" && phase_ == Phase::Between)
    for (auto& [id, object] : rigids_)
      if (object.body->getBroadphaseHandle())
        broadphase_->getOverlappingPairCache()->cleanProxyFromPairs(object.body->getBroadphaseHandle(),
                                                                    dispatcher_.get());
}

}  // namespace limber::fuzz

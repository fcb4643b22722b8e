// SPDX-License-Identifier: Zlib
// Removal of objects by the user of a story, and destruction of the world.
#include "fuzz/world_player.h"

namespace limber::fuzz {

btInternalTickCallback preTickSlot(const btDynamicsWorld& world) {
  struct Slots : btDynamicsWorld {
    static btInternalTickCallback of(const btDynamicsWorld& w) {
      return w.*(&Slots::m_internalPreTickCallback);
    }
  };
  return Slots::of(world);
}

void WorldPlayer::forgetEverywhere(btRigidBody& body) {
  for (auto& system : systems_)
    if (system) system->forget(body);
}

/// Forgets springs of a removed body; Limber has deleted them.
void WorldPlayer::forgetSpringsOn(int id) {
  for (auto it = springs_.begin(); it != springs_.end();)
    if (it->second.ends[0] == id || it->second.ends[1] == id)
      it = springs_.erase(it);
    else
      ++it;
}

void WorldPlayer::removeJointsOn(int id) {
  for (auto it = joints_.begin(); it != joints_.end();) {
    if (it->second.a == id || it->second.b == id) {
      world_->removeConstraint(it->second.joint.get());
      it = joints_.erase(it);
    } else {
      ++it;
    }
  }
}

void WorldPlayer::removeVehicle(int id) {
  const auto it = vehicles_.find(id);
  if (it == vehicles_.end()) return;
  world_->removeVehicle(it->second.vehicle.get());
  vehicles_.erase(it);
}

// --- single objects ----------------------------------------------------------------------------------------

void WorldPlayer::destroy(const Step& s) {
  const int id = s.whole("of");
  if (softs_.count(id)) return destroySoft(id, s.choice("how"), 0);
  if (rigids_.count(id)) return destroyRigid(id);
  if (const auto joint = joints_.find(id); joint != joints_.end() && phase_ != Phase::Listener) {
    world_->removeConstraint(joint->second.joint.get());
    joints_.erase(joint);
  }
  if (const auto spring = springs_.find(id); spring != springs_.end() && phase_ != Phase::Listener) {
    systemOf(spring->second.system)->removeSpring(spring->second.spring);
    springs_.erase(spring);
  }
  // characters are actions, and Bullet is iterating over its actions in the other phases
  if (phase_ != Phase::Between) return;
  if (const auto ghost = ghosts_.find(id); ghost != ghosts_.end()) {
    if (ghost->second.character) world_->removeAction(ghost->second.character.get());
    world_->removeCollisionObject(ghost->second.ghost.get());
    ghosts_.erase(ghost);
  }
}

void WorldPlayer::destroySoft(int id, const std::string& how, std::uint32_t point) {
  SoftObject object = softs_[id];
  removeJointsOn(id);
  if (how == "properly" || !object.body->alive()) {
    systemOf(object.system)->destroyBody(object.body);
    softs_.erase(id);
    forgetSpringsOn(id);
    return;
  }
  // a listener may only remove rigid bodies and destroy soft ones
  if (phase_ == Phase::Listener) return;
  btRigidBody* removed = how == "delete-object" ? object.body->surfaceObject() : nullptr;
  if (!removed) removed = object.body->point(point);
  if (!removed) return;
  const bool isPoint = removed != object.body->surfaceObject();
  if (removed->isInWorld()) world_->removeRigidBody(removed);
  delete removed;
  for (auto it = springs_.begin(); isPoint && it != springs_.end();) {
    const SpringObject& spring = it->second;
    const bool onPoint = (spring.ends[0] == id && spring.points[0] == point) ||
                         (spring.ends[1] == id && spring.points[1] == point);
    it = onPoint ? springs_.erase(it) : std::next(it);
  }
}

void WorldPlayer::destroyRigid(int id) {
  if (phase_ == Phase::Action && vehicles_.count(id)) return;
  RigidObject& object = rigids_[id];
  if (phase_ == Phase::Listener) {
    if (object.body->isInWorld() && !vehicles_.count(id)) {
      removeJointsOn(id);
      world_->removeRigidBody(object.body.get());
    }
    return;
  }
  removeVehicle(id);
  removeJointsOn(id);
  forgetEverywhere(*object.body);
  forgetSpringsOn(id);
  if (object.body->isInWorld()) world_->removeRigidBody(object.body.get());
  rigids_.erase(id);
}

void WorldPlayer::leave(const Step& s) {
  const int id = s.whole("of");
  btRigidBody* body = bodyOf(id, s.whole("point"));
  if (!body || !body->isInWorld() || vehicles_.count(id)) return;
  if (phase_ == Phase::Listener && !rigid(id)) return;
  removeJointsOn(id);
  world_->removeRigidBody(body);
}

void WorldPlayer::enter(const Step& s) {
  RigidObject* object = rigid(s.whole("of"));
  if (!object || object->body->isInWorld()) return;
  if (object->group)
    world_->addRigidBody(object->body.get(), object->group, object->mask);
  else
    world_->addRigidBody(object->body.get());
}

/// Performs steps on the systems, their listener or their callback.
void WorldPlayer::surround(const Step& s) {
  SoftBodySystem* system = systemOf(static_cast<std::size_t>(s.whole("system")));
  if (!system || !options_.softBodies) return;
  const std::string& what = s.choice("what");
  const Eigen::Vector3d flow = s.vec("flow");
  Air air;
  air.wind = flow;
  if (what == "gusts") air.windAt = gusts(flow, 3.0 + flow.norm(), 0.7);
  if (what == "vacuum") air.density = 0.0;
  if (what == "air" || what == "gusts" || what == "vacuum") static_cast<void>(system->setAir(air));
  Water water;
  water.level = s["level"];
  water.flow = flow;
  if (what == "water") static_cast<void>(system->setWater(water));
  if (what == "dry") static_cast<void>(system->setWater(std::nullopt));
  const ForceField vortex = [flow](const FieldPoints& p) {
    for (std::size_t i = 0; i < p.count; ++i) {
      const Eigen::Map<const Eigen::Vector3d> x(p.positions + 3 * i), v(p.velocities + 3 * i);
      Eigen::Map<Eigen::Vector3d>(p.accelerations + 3 * i) +=
          flow.cross(Eigen::Vector3d(x / (1.0 + x.norm()))) - v;
    }
  };
  if (what == "field")
    if (const auto field = system->addField(vortex, livingSoft(s.whole("of")))) fields_.push_back(*field);
  if (what == "no-field" && !fields_.empty()) static_cast<void>(system->removeField(fields_.back()));
}

void WorldPlayer::changeSystem(const Step& s) {
  if (s.kind == Kind::Hook) {
    if (s.choice("what") == "overwrite") {
      slot_ = [](btDynamicsWorld* world, btScalar tick) {
        static_cast<WorldPlayer*>(world->getWorldUserInfo())->preTick(tick);
      };
      world_->setInternalTickCallback(slot_, this, true);
    }
    for (auto& system : systems_)
      if (system && s.choice("what") == "rehook") system->rehook();
    return;
  }
  if (s.kind == Kind::Listener || s.kind == Kind::Report) {
    for (auto& system : systems_) {
      if (system && s.kind == Kind::Listener)
        system->setContactListener(s.is("on") ? listener_.get() : nullptr);
      if (system && s.kind == Kind::Report) system->reportManifolds(s.is("on"));
    }
    return;
  }
  if (s.kind != Kind::System || phase_ != Phase::Between || !options_.softBodies) return;
  if (s.choice("what") == "add") return addSystem();
  const auto index = static_cast<std::size_t>(s.whole("system"));
  SoftBodySystem* system = systemOf(index);
  if (!system) return;
  for (const auto& [id, object] : softs_)
    if (object.system == index) removeJointsOn(id);
  if (s.choice("what") == "destroy")
    systems_[index].reset();
  else
    system->removeAll();
  const auto isRemoved = [&](const auto& entry) { return entry.second.system == index; };
  std::vector<int> removed;
  for (const auto& entry : softs_)
    if (isRemoved(entry)) removed.push_back(entry.first);
  for (const int id : removed) softs_.erase(id);
  // springs of other systems that were attached to the removed bodies
  for (auto it = springs_.begin(); it != springs_.end();) {
    const auto& ends = it->second.ends;
    const bool wasAttached = std::find_first_of(std::begin(ends), std::end(ends), removed.begin(),
                                                removed.end()) != std::end(ends);
    it = isRemoved(*it) || wasAttached ? springs_.erase(it) : std::next(it);
  }
}

// --- everything --------------------------------------------------------------------------------------------

void WorldPlayer::tearDown() {
  // steps that are not performed yet are dropped
  done_.assign(done_.size(), 1);
  for (const auto& [id, object] : softs_) removeJointsOn(id);
  const std::string& order = settings_.choice("teardown");
  if (order == "hello-world" || order == "hello-system") {
    helloWorldLoop();
    if (order == "hello-world") {
      world_.reset();
      systems_.clear();
    } else {
      systems_.clear();
      checkPlainTicks();
      world_.reset();
    }
    softs_.clear();
    springs_.clear();
    return;
  }
  softs_.clear();
  springs_.clear();
  if (order == "world") {
    vehicles_.clear();
    for (auto& [id, joint] : joints_) world_->removeConstraint(joint.joint.get());
    joints_.clear();
    world_.reset();
    systems_.clear();
    return;
  }
  if (order == "one-by-one")
    for (auto& system : systems_)
      while (system && system->bodyCount() > 0) {
        system->destroyBody(system->body(system->bodyCount() / 2));
        world_->stepSimulation(btScalar(1.0 / 60), 0);
      }
  if (order != "system")
    for (auto& system : systems_)
      if (system) system->removeAll();
  if (order == "system" || order == "one-by-one") systems_.clear();
  checkEmptied();
  if (order == "broadphase") {
    removeRest();
    broadphase_.reset();
    world_.reset();
    systems_.clear();
    return;
  }
  checkPlainTicks();
  systems_.clear();
  removeRest();
  world_.reset();
}

/// Runs the clean-up loop of Bullet's HelloWorld and CommonRigidBodyBase, which deletes every collision
/// object.
void WorldPlayer::helloWorldLoop() {
  for (auto& [id, joint] : joints_) world_->removeConstraint(joint.joint.get());
  joints_.clear();
  for (auto& [id, vehicle] : vehicles_) world_->removeVehicle(vehicle.vehicle.get());
  vehicles_.clear();
  for (auto& [id, ghost] : ghosts_)
    if (ghost.character) world_->removeAction(ghost.character.get());
  // springs must be removed before the bodies at their ends
  for (auto& [id, object] : rigids_) forgetEverywhere(*object.body);
  if (auto* world = dynamic_cast<btMultiBodyDynamicsWorld*>(world_.get()))
    for (auto& [id, object] : multiBodies_) world->removeMultiBody(object.body.get());
  for (int i = world_->getNumCollisionObjects() - 1; i >= 0; --i) {
    btCollisionObject* object = world_->getCollisionObjectArray()[i];
    world_->removeCollisionObject(object);
    bool ours = false;
    for (auto& [id, ghost] : ghosts_) ours = ours || ghost.ghost.get() == object;
    for (auto& [id, multi] : multiBodies_)
      for (auto& collider : multi.colliders) ours = ours || collider.get() == object;
    for (auto& [id, rigidObject] : rigids_)
      if (rigidObject.body.get() == object) (void)rigidObject.body.release();
    if (!ours) delete object;
  }
  for (auto it = rigids_.begin(); it != rigids_.end();)
    it = it->second.body ? std::next(it) : rigids_.erase(it);
}

void WorldPlayer::removeRest() {
  for (auto& [id, joint] : joints_) world_->removeConstraint(joint.joint.get());
  joints_.clear();
  for (auto& [id, vehicle] : vehicles_) world_->removeVehicle(vehicle.vehicle.get());
  vehicles_.clear();
  for (auto& [id, ghost] : ghosts_) {
    if (ghost.character) world_->removeAction(ghost.character.get());
    world_->removeCollisionObject(ghost.ghost.get());
  }
  if (auto* world = dynamic_cast<btMultiBodyDynamicsWorld*>(world_.get()))
    for (auto& [id, object] : multiBodies_) {
      world->removeMultiBody(object.body.get());
      for (auto& collider : object.colliders) world->removeCollisionObject(collider.get());
    }
  for (auto& [id, object] : rigids_)
    if (object.body->isInWorld()) world_->removeRigidBody(object.body.get());
  if (world_->getNumCollisionObjects() > 0)
    fail("emptied", std::to_string(world_->getNumCollisionObjects()) + " objects are left in the world");
}

/// Checks that the world without soft bodies and springs is as before Limber.
void WorldPlayer::checkEmptied() {
  int objects = static_cast<int>(ghosts_.size());
  for (auto& [id, object] : rigids_) objects += object.body->isInWorld();
  for (auto& [id, object] : multiBodies_) objects += static_cast<int>(object.colliders.size());
  if (world_->getNumCollisionObjects() != objects)
    fail("emptied", "the world has " + std::to_string(world_->getNumCollisionObjects()) + " objects, not " +
                        std::to_string(objects));
  if (world_->getWorldUserInfo() != this) fail("callbacks", "the world's user info has changed");
  for (auto& system : systems_)
    if (system && system->hookState() != HookState::Idle)
      fail("callbacks", "an empty system is still hooked");
  // in a world without soft bodies the system notices only at a tick that it is not needed
  if (preTickSlot(*world_) != slot_) world_->stepSimulation(btScalar(1.0 / 60), 0);
  if (preTickSlot(*world_) != slot_)
    fail("callbacks", "the user's pre-tick callback is not back after a tick");
  for (int i = 0; i < dispatcher_->getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher_->getManifoldByIndexInternal(i);
    if (manifold.getContactProcessingThreshold() < btScalar(0))
      fail("callbacks", "a manifold of the emptied world keeps a processing threshold below 0");
  }
}

void WorldPlayer::checkPlainTicks() {
  for (int i = 0; i < 3; ++i) world_->stepSimulation(btScalar(1.0 / 60), 0);
  for (auto& [id, object] : rigids_)
    if (!std::isfinite(object.body->getWorldTransform().getOrigin().length2()))
      fail("finite", "rigid body " + std::to_string(id) + " after the soft bodies have gone");
}

}  // namespace limber::fuzz

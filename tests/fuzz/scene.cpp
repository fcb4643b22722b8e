// SPDX-License-Identifier: Zlib
// Builds the scene of a story.
#include "fuzz/networks.h"
#include "fuzz/world_player.h"

#include "mesh/random.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>

namespace limber::fuzz {
namespace {

using Eigen::Vector3d;

struct StoryListener : ContactListener {
  explicit StoryListener(WorldPlayer& player) : player_(player) {}
  void contactBegins(const ContactPair&) override { player_.perform(Phase::Listener); }
  void contactPersists(const ContactPair&) override { player_.perform(Phase::Listener); }
  WorldPlayer& player_;
};

struct StoryAction : btActionInterface {
  explicit StoryAction(WorldPlayer& player) : player_(player) {}
  void updateAction(btCollisionWorld*, btScalar) override { player_.perform(Phase::Action); }
  void debugDraw(btIDebugDraw*) override {}
  WorldPlayer& player_;
};

void onPreTick(btDynamicsWorld* world, btScalar tick) {
  static_cast<WorldPlayer*>(world->getWorldUserInfo())->preTick(tick);
}

void onTick(btDynamicsWorld* world, btScalar) {
  static_cast<WorldPlayer*>(world->getWorldUserInfo())->perform(Phase::Tick);
}

std::unique_ptr<btBroadphaseInterface> makeBroadphase(const std::string& kind) {
  const btVector3 low(-1000, -1000, -1000), high(1000, 1000, 1000);
  if (kind == "axis-sweep") return std::make_unique<btAxisSweep3>(low, high);
  if (kind == "simple") return std::make_unique<btSimpleBroadphase>();
  return std::make_unique<btDbvtBroadphase>();
}

/// A motion state for kinematic bodies that are moved through it.
struct MovingState : btMotionState {
  btTransform now;
  void getWorldTransform(btTransform& transform) const override { transform = now; }
  void setWorldTransform(const btTransform&) override {}
};

}  // namespace

void moveState(btMotionState& state, const btTransform& to) {
  if (auto* moving = dynamic_cast<MovingState*>(&state)) moving->now = to;
}

namespace {

bool isKinematic(const std::string& motion) { return motion.rfind("kinematic", 0) == 0; }

void setKinematicFlags(btRigidBody& body, const std::string& motion) {
  const int flag = btCollisionObject::CF_KINEMATIC_OBJECT;
  body.setCollisionFlags(motion == "kinematic" ? flag : body.getCollisionFlags() | flag);
  body.setActivationState(DISABLE_DEACTIVATION);
}

std::unique_ptr<btMotionState> makeState(const std::string& motion, int variant, const btTransform& at) {
  if (motion == "kinematic-state") {
    auto state = std::make_unique<MovingState>();
    state->now = at;
    return state;
  }
  if (motion == "dynamic" && variant % 2) return std::make_unique<btDefaultMotionState>(at);
  return nullptr;
}

}  // namespace

void WorldPlayer::makeWorld(const Step& s) {
  configuration_ = std::make_unique<btDefaultCollisionConfiguration>();
  dispatcher_ = std::make_unique<btCollisionDispatcher>(configuration_.get());
  btGImpactCollisionAlgorithm::registerAlgorithm(dispatcher_.get());
  broadphase_ = makeBroadphase(s.choice("broadphase"));
  ghostPairs_ = std::make_unique<btGhostPairCallback>();
  broadphase_->getOverlappingPairCache()->setInternalGhostPairCallback(ghostPairs_.get());
  if (s.choice("kind") == "multi-body") {
    auto solver = std::make_unique<btMultiBodyConstraintSolver>();
    world_ = std::make_unique<btMultiBodyDynamicsWorld>(dispatcher_.get(), broadphase_.get(), solver.get(),
                                                        configuration_.get());
    solver_ = std::move(solver);
  } else {
    if (s.choice("solver") == "mlcp") {
      lcp_ = std::make_unique<btDantzigSolver>();
      solver_ = std::make_unique<btMLCPSolver>(lcp_.get());
    } else if (s.choice("solver") == "nncg") {
      solver_ = std::make_unique<btNNCGConstraintSolver>();
    } else {
      solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
    }
    world_ = std::make_unique<btDiscreteDynamicsWorld>(dispatcher_.get(), broadphase_.get(), solver_.get(),
                                                       configuration_.get());
  }
  world_->setGravity(toBt(s.vec("gravity")));
  world_->setInternalTickCallback(onPreTick, this, true);
  slot_ = onPreTick;
  if (s.is("tick")) world_->setInternalTickCallback(onTick, this, false);
  world_->getDispatchInfo().m_deterministicOverlappingPairs = s.is("ordered-pairs");
  world_->getSolverInfo().m_splitImpulse = s.whole("split-impulse");
  if (s.is("no-latency")) world_->setLatencyMotionStateInterpolation(false);
  if (s.is("fast-spheres")) useFastSphereAlgorithms(*dispatcher_);
  action_ = std::make_unique<StoryAction>(*this);
  listener_ = std::make_unique<StoryListener>(*this);
  if (s.is("action-first")) world_->addAction(action_.get());
  if (!options_.softBodies) return;
  for (int i = 0; i < s.whole("systems"); ++i) addSystem();
}

void WorldPlayer::addSystem() {
  const auto kind = settings_.is("manual") ? SoftBodySystem::Hook::Manual : SoftBodySystem::Hook::PreTick;
  systems_.push_back(std::make_unique<SoftBodySystem>(*world_, kind));
  systems_.back()->onWarning([](const std::string&) {});
  if (options_.threads > 1) {
    if (!threads_) threads_ = std::make_unique<ThreadPool>(options_.threads);
    systems_.back()->setParallelFor(threads_->parallelFor(), 0);
  }
  if (settings_.is("listener")) systems_.back()->setContactListener(listener_.get());
  if (settings_.is("report")) systems_.back()->reportManifolds(true);
}

void WorldPlayer::preTick(btScalar tick) {
  // pairs of the previous tick
  rigidPairs_ = std::max(rigidPairs_, touchingRigidPairs());
  perform(Phase::PreTick);
  if (!settings_.is("manual")) return;
  for (std::size_t i = 0; i < systems_.size(); ++i)
    if (systems_[i]) systems_[i]->beforeTick(tick);
}

// --- rigid objects -----------------------------------------------------------------------------------------

void WorldPlayer::addFloor(const Step& s) {
  std::vector<FloorPiece> pieces = makeFloor(s.choice("kind"), s["extent"], s["cell"]);
  const btMatrix3x3 rotation(rotationOf(s.vec("rotation")));
  int id = s.id;
  Step rigid(Kind::Rigid);
  rigid.choose("motion", s.choice("motion"))
      .set("friction", s["friction"])
      .set("restitution", s["restitution"]);
  rigid.set("rotation", s.vec("rotation"));
  for (FloorPiece& piece : pieces) {
    const Vector3d position = s.vec("position") + fromBt(rotation * toBt(piece.position));
    addRigidObject(id, std::move(piece.shape), rigid, position);
    id = id == s.id ? s.id * 1000 : id + 1;
  }
}

void WorldPlayer::addRigid(const Step& s) {
  addRigidObject(s.id, makeShape(s.choice("shape"), s.vec("size"), s.whole("variant")), s, s.vec("position"));
}

void WorldPlayer::addRigidObject(int id, OwnedShape shape, const Step& s, const Vector3d& position) {
  if (rigids_.count(id)) return;
  RigidObject& made = rigids_[id];
  made.shape = std::move(shape);
  if (s["margin"] >= 0.0) made.shape.shape->setMargin(toBt(s["margin"]));
  std::string motion = s.choice("motion");
  if (made.shape.fixed && motion == "dynamic") motion = "static";
  const double mass = motion == "dynamic" ? s["mass"] : 0.0;
  btVector3 inertia(0, 0, 0);
  if (mass > 0) made.shape.shape->calculateLocalInertia(toBt(mass), inertia);
  const btTransform at(rotationOf(s.vec("rotation")), toBt(position));
  made.state = makeState(motion, s.whole("variant"), at);
  btRigidBody::btRigidBodyConstructionInfo info(toBt(mass), made.state.get(), made.shape.shape.get(),
                                                inertia);
  info.m_startWorldTransform = at;
  info.m_friction = toBt(s["friction"]);
  info.m_restitution = toBt(s["restitution"]);
  info.m_rollingFriction = toBt(s["rolling"]);
  info.m_linearDamping = info.m_angularDamping = toBt(s["damping"]);
  made.body = std::make_unique<btRigidBody>(info);
  made.velocity = s.vec("velocity");
  made.spin = s.vec("spin");
  made.moves = isKinematic(motion);
  btRigidBody& body = *made.body;
  if (made.moves) setKinematicFlags(body, motion);
  if (mass > 0) {
    body.setLinearVelocity(toBt(made.velocity));
    body.setAngularVelocity(toBt(made.spin));
  }
  if (s.is("no-response"))
    body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  if (s.is("no-sleep")) body.setActivationState(DISABLE_DEACTIVATION);
  if (s.is("ccd")) {
    body.setCcdMotionThreshold(toBt(0.1 * made.shape.radius));
    body.setCcdSweptSphereRadius(toBt(0.2 * made.shape.radius));
  }
  made.group = s.whole("group");
  made.mask = s.whole("mask");
  if (made.group)
    world_->addRigidBody(&body, made.group, made.mask);
  else
    world_->addRigidBody(&body);
}

// --- soft bodies -------------------------------------------------------------------------------------------

namespace {

SoftBodySettings softSettings(const Step& s) {
  SoftBodySettings made;
  made.position = s.vec("position");
  const btQuaternion rotation = rotationOf(s.vec("rotation"));
  made.rotation = Eigen::Quaterniond(double(rotation.w()), double(rotation.x()), double(rotation.y()),
                                     double(rotation.z()))
                      .normalized();
  made.scale = s.vec("scale");
  made.linearVelocity = s.vec("velocity");
  made.angularVelocity = s.vec("spin");
  made.extensionStiffness = s["extension"];
  made.compressionStiffness = s["compression"];
  made.damping = s["damping"];
  made.totalMass = s["mass"];
  if (s["volume"] >= 0.0) made.volumeModulus = s["volume"];
  made.pressure = s["pressure"];
  made.ambientPressure = s["ambient"];
  made.collision = s.choice("collision") == "points" ? Collision::Points : Collision::Surface;
  made.selfCollision = s.is("self");
  if (s["radius"] > 0.0) made.pointRadius = s["radius"];
  made.friction = s["friction"];
  made.restitution = s["restitution"];
  made.collisionGroup = s.whole("group");
  made.collisionMask = s.whole("mask");
  made.continuousCollision = s.is("ccd");
  made.sleepingSpeed = s["sleeping-speed"];
  made.stepping.stepper = static_cast<Stepper>(s.whole("stepper"));
  made.stepping.minSubsteps = s.whole("at-least");
  made.stepping.periodTolerance = s["period"];
  made.stepping.tolerance = s["tolerance"];
  made.stepping.relativeTolerance = s["relative"];
  made.stepping.maxSubsteps = s.whole("budget");
  made.stepping.searchDistance = s["search"];
  made.elasticLimit = {s["stiffen"], s["stiffen-factor"], s["yield"], s["yield-maximum"], s["break"]};
  made.elasticLimit.tear = s.is("tear");
  return made;
}

/// Returns the network with each point displaced by `by`, so that unstable shapes buckle.
SharedNetwork nudged(SpringNetwork network, double by, Random& random) {
  for (Vector3d& point : network.restPoints) point += by * random.direction();
  return std::make_shared<const SpringNetwork>(std::move(network));
}

}  // namespace

void WorldPlayer::addSoft(const Step& s) {
  const auto index = static_cast<std::size_t>(s.whole("system"));
  SoftBodySystem* system = systemOf(index);
  if (!system || softs_.count(s.id)) return;
  SoftBodySettings settings = softSettings(s);
  // the laws of these stories scale masses, lengths and times, but not the air
  if (settings_.choice("promise") != "wild") settings.flow.drag = settings.flow.linearDrag = 0.0;
  SharedNetwork network = networkNamed(s.choice("network"));
  if (options_.nudge > 0.0) {
    Random random(static_cast<std::uint64_t>(s.id + 1000 * options_.nudgeNumber));
    settings.position += options_.nudge * random.direction();
    network = nudged(*network, options_.nudge, random);
  }
  Result<SoftBody*> body = system->createBody(network, settings);
  // a body with invalid settings is not created; the laws are about valid ones
  if (!body) return;
  softs_[s.id] = {*body, index};
  if (s.is("shared")) (*body)->point(0);
}

// --- joints and other kinds of objects ---------------------------------------------------------------------

namespace {

std::unique_ptr<btTypedConstraint> makeJoint(const Step& s, btRigidBody& a, btRigidBody& b,
                                             const btTransform& inA, const btTransform& inB) {
  const std::string& kind = s.choice("kind");
  const btVector3 axis(0, 0, 1);
  if (kind == "point")
    return std::make_unique<btPoint2PointConstraint>(a, b, inA.getOrigin(), inB.getOrigin());
  if (kind == "hinge") {
    auto hinge = std::make_unique<btHingeConstraint>(a, b, inA, inB);
    if (s["low"] <= s["high"]) hinge->setLimit(toBt(s["low"]), toBt(s["high"]));
    if (s.is("motor")) hinge->enableAngularMotor(true, toBt(s["motor"]), toBt(1));
    return hinge;
  }
  if (kind == "slider") {
    auto slider = std::make_unique<btSliderConstraint>(a, b, inA, inB, true);
    slider->setLowerLinLimit(toBt(std::min(s["low"], 0.0)));
    slider->setUpperLinLimit(toBt(std::max(s["high"], 0.0)));
    return slider;
  }
  if (kind == "cone-twist") return std::make_unique<btConeTwistConstraint>(a, b, inA, inB);
  if (kind == "fixed") return std::make_unique<btFixedConstraint>(a, b, inA, inB);
  if (kind == "gear") return std::make_unique<btGearConstraint>(a, b, axis, axis, toBt(1.5));
  if (kind == "dof6") return std::make_unique<btGeneric6DofConstraint>(a, b, inA, inB, true);
  auto springs = std::make_unique<btGeneric6DofSpring2Constraint>(a, b, inA, inB);
  springs->enableSpring(1, true);
  springs->setStiffness(1, 50);
  springs->setDamping(1, 1);
  return springs;
}

}  // namespace

/// Joints are between rigid bodies and the surface objects of soft ones.
void WorldPlayer::addJoint(const Step& s) {
  const auto end = [&](const char* name) -> btRigidBody* {
    if (const RigidObject* object = rigid(s.whole(name))) return object->body.get();
    const SoftBody* body = livingSoft(s.whole(name));
    return body ? body->surfaceObject() : nullptr;
  };
  btRigidBody *a = end("a"), *b = end("b");
  if (!a || a->isStaticOrKinematicObject() || joints_.count(s.id)) return;
  if (a == b || !a->isInWorld() || (b && !b->isInWorld())) return;
  btRigidBody& other = b ? *b : btTypedConstraint::getFixedBody();
  const btTransform inA(btQuaternion::getIdentity(), toBt(s.vec("pivot-a")));
  btTransform inB = other.getWorldTransform().inverse() * a->getWorldTransform() * inA;
  inB.setOrigin(inB.getOrigin() + toBt(s.vec("pivot-b")));
  JointObject& made = joints_[s.id];
  made.joint = makeJoint(s, *a, other, inA, inB);
  made.a = s.whole("a");
  made.b = s.whole("b");
  if (s["break"] > 0) made.joint->setBreakingImpulseThreshold(toBt(s["break"]));
  world_->addConstraint(made.joint.get(), !s.is("collide"));
}

void WorldPlayer::addMultiBody(const Step& s) {
  auto* world = dynamic_cast<btMultiBodyDynamicsWorld*>(world_.get());
  if (!world || multiBodies_.count(s.id)) return;
  MultiBodyObject& made = multiBodies_[s.id];
  const int links = s.whole("links");
  const Vector3d size = s.vec("size");
  for (int i = 0; i <= links; ++i) made.shapes.push_back(makeShape(i % 2 ? "capsule-y" : "box", size, 0));
  btVector3 inertia;
  made.shapes[0].shape->calculateLocalInertia(toBt(s["mass"]), inertia);
  made.body = std::make_unique<btMultiBody>(links, toBt(s["mass"]), inertia, s.is("fixed-base"), true);
  btMultiBody& body = *made.body;
  body.setBasePos(toBt(s.vec("position")));
  body.setWorldToBaseRot(rotationOf(s.vec("rotation")).inverse());
  const btVector3 half = toBt(Vector3d(0, -1.6 * size.y(), 0));
  const btQuaternion straight = btQuaternion::getIdentity();
  for (int i = 0; i < links; ++i) {
    const std::string& joint = s.choice("joint");
    const btScalar mass = toBt(0.5 * s["mass"]);
    made.shapes[static_cast<std::size_t>(i) + 1].shape->calculateLocalInertia(mass, inertia);
    if (joint == "revolute")
      body.setupRevolute(i, mass, inertia, i - 1, straight, btVector3(toBt(i % 2), 0, toBt(1 - i % 2)), half,
                         half, true);
    else if (joint == "prismatic")
      body.setupPrismatic(i, mass, inertia, i - 1, straight, btVector3(0, 1, 0), half, half, true);
    else if (joint == "spherical")
      body.setupSpherical(i, mass, inertia, i - 1, straight, half, half, true);
    else
      body.setupFixed(i, mass, inertia, i - 1, straight, half, half);
  }
  body.finalizeMultiDof();
  world->addMultiBody(&body);
  btAlignedObjectArray<btQuaternion> rotations;
  btAlignedObjectArray<btVector3> positions;
  body.forwardKinematics(rotations, positions);
  for (int i = -1; i < links; ++i) {
    auto collider = std::make_unique<btMultiBodyLinkCollider>(&body, i);
    collider->setCollisionShape(made.shapes[static_cast<std::size_t>(i + 1)].shape.get());
    const bool fixed = i < 0 && s.is("fixed-base");
    world->addCollisionObject(collider.get(), fixed ? 2 : 1, fixed ? -1 ^ 2 : -1);
    if (i < 0)
      body.setBaseCollider(collider.get());
    else
      body.getLink(i).m_collider = collider.get();
    made.colliders.push_back(std::move(collider));
  }
  body.updateCollisionObjectWorldTransforms(rotations, positions);
}

void WorldPlayer::addGhost(const Step& s) {
  if (ghosts_.count(s.id)) return;
  GhostObject& made = ghosts_[s.id];
  made.shape = makeShape("box", s.vec("size"), 0);
  if (s.is("pairs"))
    made.ghost = std::make_unique<btPairCachingGhostObject>();
  else
    made.ghost = std::make_unique<btGhostObject>();
  made.ghost->setCollisionShape(made.shape.shape.get());
  made.ghost->setCollisionFlags(made.ghost->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  made.ghost->setWorldTransform(btTransform(btQuaternion::getIdentity(), toBt(s.vec("position"))));
  world_->addCollisionObject(made.ghost.get(), s.whole("group"), -1);
}

void WorldPlayer::addCharacter(const Step& s) {
  if (ghosts_.count(s.id)) return;
  GhostObject& made = ghosts_[s.id];
  auto capsule = std::make_unique<btCapsuleShape>(toBt(s["radius"]), toBt(s["height"]));
  auto ghost = std::make_unique<btPairCachingGhostObject>();
  ghost->setCollisionShape(capsule.get());
  ghost->setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
  ghost->setWorldTransform(btTransform(btQuaternion::getIdentity(), toBt(s.vec("position"))));
  made.character = std::make_unique<btKinematicCharacterController>(ghost.get(), capsule.get(), toBt(0.3),
                                                                    btVector3(0, 1, 0));
  made.character->setGravity(world_->getGravity());
  made.character->setWalkDirection(toBt(s.vec("walk") / 60.0));
  if (s.is("jump-at")) made.character->setJumpSpeed(toBt(s["jump-at"]));
  made.shape.shape = std::move(capsule);
  made.ghost = std::move(ghost);
  world_->addCollisionObject(made.ghost.get(), btBroadphaseProxy::CharacterFilter,
                             btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
  world_->addAction(made.character.get());
}

void WorldPlayer::addVehicle(const Step& s) {
  if (rigids_.count(s.id)) return;
  const Vector3d size = s.vec("size");
  Step chassis(Kind::Rigid);
  chassis.id = s.id;
  chassis.set("size", size).set("mass", s["mass"]).set("position", s.vec("position")).set("no-sleep", 1);
  chassis.set("velocity", s.vec("velocity"));
  addRigid(chassis);
  VehicleObject& made = vehicles_[s.id];
  made.raycaster = std::make_unique<btDefaultVehicleRaycaster>(world_.get());
  const btRaycastVehicle::btVehicleTuning tuning;
  made.vehicle = std::make_unique<btRaycastVehicle>(tuning, rigids_[s.id].body.get(), made.raycaster.get());
  made.vehicle->setCoordinateSystem(0, 1, 2);
  for (int i = 0; i < 4; ++i) {
    const Vector3d position((i & 1 ? 1 : -1) * size.x(), 0, (i & 2 ? 1 : -1) * size.z());
    made.vehicle->addWheel(toBt(position), btVector3(0, -1, 0), btVector3(-1, 0, 0),
                           toBt(0.4 * size.y() + 0.2), toBt(0.3 * size.y() + 0.1), tuning, (i & 2) != 0);
    made.vehicle->applyEngineForce(toBt(s["engine"]), i);
  }
  made.vehicle->setSteeringValue(toBt(s["steering"]), 2);
  world_->addVehicle(made.vehicle.get());
}

}  // namespace limber::fuzz

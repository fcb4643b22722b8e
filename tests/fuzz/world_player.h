// SPDX-License-Identifier: Zlib
#pragma once

#include "fuzz/bullet_shapes.h"
#include "fuzz/player.h"

#include <limber/limber.h>

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolverInterface.h>

namespace limber::fuzz {

/// Members are destroyed in reverse order: the body before its shape.
struct RigidObject {
  OwnedShape shape;
  std::unique_ptr<btMotionState> state;
  std::unique_ptr<btRigidBody> body;
  bool moves = false;  ///< kinematic, moved with `velocity` and `spin`
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), spin = Eigen::Vector3d::Zero();
  int group = 0, mask = -1;
};

struct SoftObject {
  SoftBody* body = nullptr;
  std::size_t system = 0;
};

struct SpringObject {
  SpringConstraint* spring = nullptr;
  std::size_t system = 0;
  int ends[2] = {0, 0};
  std::uint32_t points[2] = {0, 0};
};

struct JointObject {
  std::unique_ptr<btTypedConstraint> joint;
  int a = 0, b = 0;
};

struct MultiBodyObject {
  std::vector<OwnedShape> shapes;
  std::unique_ptr<btMultiBody> body;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
};

struct GhostObject {
  OwnedShape shape;
  std::unique_ptr<btGhostObject> ghost;
  std::unique_ptr<btKinematicCharacterController> character;
};

struct VehicleObject {
  std::unique_ptr<btVehicleRaycaster> raycaster;
  std::unique_ptr<btRaycastVehicle> vehicle;
};

/// Moves a body of the motion "kinematic-state" through its motion state, as Bullet recommends.
void moveState(btMotionState& state, const btTransform& to);

/// Returns the world's pre-tick callback, for which Bullet has no getter.
btInternalTickCallback preTickSlot(const btDynamicsWorld& world);

/// A world that plays a story, and the user who performs its steps.
class WorldPlayer {
 public:
  WorldPlayer(const Story& story, const PlayOptions& options);
  ~WorldPlayer();
  WorldPlayer(const WorldPlayer&) = delete;
  WorldPlayer& operator=(const WorldPlayer&) = delete;

  Run run();

  /// Performs the steps of the story for a phase of the current frame.
  void perform(Phase phase);
  void preTick(btScalar tick);

 private:
  // the scene, scene.cpp
  void makeWorld(const Step& step);
  void addSystem();
  void addFloor(const Step& step);
  void addRigid(const Step& step);
  void addRigidObject(int id, OwnedShape shape, const Step& step, const Eigen::Vector3d& position);
  void addSoft(const Step& step);
  void addJoint(const Step& step);
  void addMultiBody(const Step& step);
  void addGhost(const Step& step);
  void addCharacter(const Step& step);
  void addVehicle(const Step& step);

  // the user, user.cpp, user_removes.cpp
  void act(const Step& step);
  void build(const Step& step);
  void touchSprings(const Step& step);
  void touchPoints(const Step& step);
  void push(const Step& step);
  void setVelocity(const Step& step);
  void teleport(const Step& step);
  void changeRigid(const Step& step);
  void changeFilter(const Step& step);
  void changeFlags(const Step& step);
  void changeSleep(const Step& step);
  void look(const Step& step);
  void lookAt(const SoftBody& body, const Step& step);
  void castRay(const Step& step);
  void synchronize(const Step& step);
  void changeSystem(const Step& step);
  void surround(const Step& step);
  void changeSoft(const Step& step);
  void carrySoft(SoftBody& body, const Step& step, bool release);
  void joinSoft(SoftBody& body, const Step& step, std::uint32_t point);
  void weldSoft(SoftBody& body, const Step& step);
  void loadElsewhere(SoftBodySystem& system);
  void pushSoft(SoftBody& body, const Step& step, std::uint32_t point);
  void destroy(const Step& step);
  void destroySoft(int id, const std::string& how, std::uint32_t point);
  void destroyRigid(int id);
  void leave(const Step& step);
  void enter(const Step& step);
  void forgetSpringsOn(int id);
  void forgetEverywhere(btRigidBody& body);
  void removeJointsOn(int id);
  void removeVehicle(int id);

  // checks after each frame, player.cpp
  void observe();
  void observeSoft(int id, const SoftBody& body, Frame& frame);
  void observeContacts(int id, SoftBody& body);
  void fail(const std::string& law, const std::string& detail);
  double energy() const;
  bool softIsNearRigid() const;
  int touchingRigidPairs() const;

  // the end, user_removes.cpp
  void tearDown();
  void helloWorldLoop();
  void removeRest();
  void checkEmptied();
  void checkPlainTicks();

  RigidObject* rigid(int id);
  SoftObject* soft(int id);
  SoftBody* livingSoft(int id);
  btRigidBody* bodyOf(int id, int point);
  SoftBodySystem* systemOf(std::size_t index);
  void moveKinematics(double seconds);
  void step(int frame);

  const Story& story_;
  PlayOptions options_;
  Step settings_, clock_;
  Run result_;
  int frame_ = -1;
  int rigidPairs_ = 0;  ///< largest number in the ticks of this frame so far, without the last
  Phase phase_ = Phase::Between;
  std::vector<char> done_;                 ///< for each step of the story, whether it has been performed
  btInternalTickCallback slot_ = nullptr;  ///< the user's own pre-tick callback

  std::unique_ptr<ThreadPool> threads_;
  std::unique_ptr<btGhostPairCallback> ghostPairs_;
  std::unique_ptr<btCollisionConfiguration> configuration_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  std::unique_ptr<btBroadphaseInterface> broadphase_;
  std::unique_ptr<btMLCPSolverInterface> lcp_;
  std::unique_ptr<btConstraintSolver> solver_;
  std::unique_ptr<btOverlapFilterCallback> filter_;
  std::unique_ptr<btActionInterface> action_;
  std::unique_ptr<ContactListener> listener_;
  std::map<int, GhostObject> ghosts_;
  std::map<int, MultiBodyObject> multiBodies_;
  std::map<int, RigidObject> rigids_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  std::map<int, VehicleObject> vehicles_;
  std::map<int, JointObject> joints_;
  std::map<int, SpringObject> springs_;
  std::map<int, SoftObject> softs_;
  std::vector<std::unique_ptr<SoftBodySystem>> systems_;
  std::vector<std::uint64_t> fields_;               ///< numbers of fields that were added
  std::map<int, std::vector<std::uint8_t>> saved_;  ///< states of soft bodies, by their ids
  std::map<int, Skeleton> skeletons_;               ///< by the ids of their bodies
  std::map<int, Grab> grabs_;                       ///< by the ids of their bodies
};

}  // namespace limber::fuzz

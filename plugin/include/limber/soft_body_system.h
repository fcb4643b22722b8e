// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/result.h>
#include <limber/soft_body.h>
#include <limber/spring_constraint.h>

#include <btBulletDynamicsCommon.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

class ContactListener;

/// Whether an object of the world is a system's own and not the user's: a point mass (findPoint()), a surface
/// object (findSurface()), or the one without shape and mass by which systems with bodies of
/// Collision::Surface tell one stepSimulation() from the next, once SoftBody::point() has been called.
bool isSystemObject(const btCollisionObject* object);

/// Whether the springs are stepped when the world is.
enum class HookState : std::uint8_t {
  Idle,        ///< nothing to step: no soft body, no spring
  Attached,    ///< in the world's pre-tick callback
  Overwritten  ///< the application has since set another pre-tick callback: call SoftBodySystem::rehook()
};

/// Time and work of the last tick, for the user's own eyes.
struct TickProfile {
  double gatherMs = 0.0;    ///< reading Bullet's bodies
  double stepMs = 0.0;      ///< the springs
  double handOverMs = 0.0;  ///< writing velocities
  double takeBackMs = 0.0;  ///< after Bullet's contacts
  std::size_t pointsStepped = 0;
  std::size_t springSubsteps = 0;  ///< sum over bodies of springs x substeps
  std::size_t rigidParts = 0;      ///< convex parts of rigid objects that surfaces were held against
  double totalMs() const { return gatherMs + stepMs + handOverMs + takeBackMs; }
};

/// Gives an existing btDiscreteDynamicsWorld soft bodies.
///
///     limber::SoftBodySystem soft(world);
///     auto body = soft.createBody(network, settings);   // then step the world as ever
///
/// It lives in the world's pre-tick callback: an existing one is called first, the world's user info is left
/// alone. The callback is given back with the last body and spring; where no soft body was in the world, as
/// with springs between rigid bodies alone, only at the world's next tick, for until then the world may be
/// gone. Several systems may share a world. The world, its bodies and the system may go in any order, with
/// one exception: if the broadphase is freed before the world, call removeAll() first. Rigid bodies that
/// springs or anchors hold on to must outlive them, as with Bullet's own constraints; forget(body) removes
/// all that hold on to one. Springs on a point mass that the application deletes go with it. Thread rule: the
/// thread that steps the world, between steps, or within one in callbacks and actions of the world.
class SoftBodySystem {
 public:
  /// How the springs are stepped.
  enum class Hook : std::uint8_t {
    PreTick,  ///< by the world, through its pre-tick callback
    Manual    ///< by the user, who owns that callback and calls beforeTick(h) first thing in it
  };

  explicit SoftBodySystem(btDiscreteDynamicsWorld& world, Hook hook = Hook::PreTick);
  /// Removes all its bodies and springs, and itself from the world if that still exists.
  ~SoftBodySystem();
  SoftBodySystem(const SoftBodySystem&) = delete;
  SoftBodySystem& operator=(const SoftBodySystem&) = delete;

  /// A body of the network's shape. The world must exist. Errors, with nothing created: no or invalid
  /// network, invalid settings, a scale that brings all points of a spring together.
  Result<SoftBody*> createBody(SharedNetwork network, const SoftBodySettings& settings = {});

  /// Removes the body, its anchors and every spring on it. The pointer is invalid afterwards.
  void destroyBody(SoftBody* body);

  std::size_t bodyCount() const;
  SoftBody* body(std::size_t i) const;  ///< in order of creation

  /// Errors: invalid settings, both ends without a body, both ends the same place of one body, a pivot that
  /// is not finite or farther than 1e6 m, a surface object, a point mass of a soft body in another world.
  Result<SpringConstraint*> addSpring(const SpringEnd& a, const SpringEnd& b,
                                      const SpringSettings& settings = {});
  /// New settings for a spring; a negative rest length keeps the present one. Errors: invalid settings, a
  /// spring that is not, or no longer, one of this system.
  Result<SpringConstraint*> changeSpring(SpringConstraint* spring, const SpringSettings& settings);
  void removeSpring(SpringConstraint* spring);
  std::size_t springCount() const;

  /// Makes point i move with `body`, at a pivot (m) in the body's local coordinates (the overload without
  /// pivot: where the point is now). Both feel each other; they do not collide. Errors: no soft body, no such
  /// point, a point that is already attached or pinned, a body that is a point mass or a surface object, a
  /// pivot that is not finite or farther than 1e6 m, a soft body in another world.
  Result<bool> attach(SoftBody* softBody, std::uint32_t i, btRigidBody& body, const btVector3& pivot);
  Result<bool> attach(SoftBody* softBody, std::uint32_t i, btRigidBody& body);
  /// Lets go of an attached point; false if it was not attached.
  bool detach(SoftBody* softBody, std::uint32_t i);

  /// Removes every spring and anchor on a rigid body. Call it before deleting one that has any.
  void forget(const btRigidBody& body);

  /// Removes all bodies and springs and leaves the world as it was found.
  void removeAll();

  /// Who is told of contacts that begin, persist and end (contact_listener.h), nullptr for nobody. It must
  /// outlive the system or be taken back. What touches already begins after the next tick.
  void setContactListener(ContactListener* listener);

  /// Whether contacts of bodies with Collision::Surface are shown in Bullet's dispatcher, for those who read
  /// contacts there: between ticks a manifold for each surface object and each of its partners, with the four
  /// contacts that bear most; m_index0 and m_index1 are triangles of network().surface or -1. Bullet does not
  /// act on them, and calls none of its contact callbacks for them. Off by default: it costs time.
  void reportManifolds(bool report);

  HookState hookState() const;
  /// Takes the pre-tick callback again; the one that replaced ours is called first from then on.
  void rehook();
  /// Called once when the hook is found overwritten, and when a body is first put back because its motion was
  /// not finite (SoftBody::restorations()). Default: a line on standard error.
  void onWarning(std::function<void(const std::string&)> handler);

  /// For Hook::Manual: call it in the pre-tick callback with the tick's length in seconds.
  void beforeTick(btScalar tick);

  const TickProfile& profile() const;

  /// Where the world's clock stands between its last two ticks: 0 at the one before the last, 1 at the last,
  /// beyond 1 if the world extrapolates (setLatencyMotionStateInterpolation(false)). It is the time at which
  /// Bullet gives motion states their transforms; for SoftBody::writePositions(xyz, fraction).
  double tickFraction() const;

  /// Draws the soft bodies as the drawer's mode asks: DBG_DrawWireframe: springs, blue where they are pressed
  /// together by a tenth, red where they are stretched by as much, and crosses at pinned points;
  /// DBG_DrawAabb: a box around each body; DBG_DrawContactPoints: contacts; DBG_DrawConstraints: anchors and
  /// single springs. The world's debugDrawWorld() calls it by itself when the mode has wireframe, AABBs or
  /// normals.
  void debugDraw(btIDebugDraw& drawer) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

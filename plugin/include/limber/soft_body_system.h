// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/contact_filter.h>
#include <limber/export.h>
#include <limber/parallel.h>
#include <limber/result.h>
#include <limber/soft_body.h>
#include <limber/spring_constraint.h>
#include <limber/surroundings.h>

#include <btBulletDynamicsCommon.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class btITaskScheduler;

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

class ContactListener;

/// Returns whether an object of the world was created by a system and not by the user: a point mass
/// (findPoint()), a surface object (findSurface()), or the step boundary. The step boundary has no shape and
/// no mass. Systems with bodies of Collision::Surface add it after SoftBody::point() has been called, to
/// distinguish one stepSimulation() call from the next.
LIMBER_API bool isSystemObject(const btCollisionObject* object);

/// State of the connection between the world's steps and the springs.
enum class HookState : std::uint8_t {
  Idle,        ///< nothing to step: no soft body, no spring
  Attached,    ///< registered as the world's pre-tick callback
  Overwritten  ///< the application has set another pre-tick callback since: call SoftBodySystem::rehook()
};

/// Time and work of the last tick, for display.
struct TickProfile {
  // In order of the tick; Bullet's own part, between the last two, is not included.
  double readMs = 0.0;      ///< finding the awake bodies, reading them from Bullet, forces of fields
  double searchMs = 0.0;    ///< finding contacts, with the ContactFilter
  double islandsMs = 0.0;   ///< collecting the rigid bodies and joints that take part, making islands
  double chooseMs = 0.0;    ///< choosing integrators and substeps
  double stepMs = 0.0;      ///< stepping, with the searches for contacts within the tick
  double writeMs = 0.0;     ///< writing velocities to Bullet
  double readBackMs = 0.0;  ///< reading from Bullet after its solver, reporting contacts
  std::size_t awakeBodies = 0;
  std::size_t pointsStepped = 0;
  std::size_t substeps = 0;        ///< sum over the awake bodies
  std::size_t springSubsteps = 0;  ///< sum over bodies of springs x substeps
  std::size_t contacts = 0;        ///< that the solver had, also at a distance, and between rigid bodies
  std::size_t islands = 0;         ///< sets of bodies that contacts or joints couple; other bodies are alone
  std::size_t rigidParts = 0;      ///< convex parts of rigid objects that were tested against surfaces
  double beforeStepMs() const { return readMs + searchMs + islandsMs + chooseMs; }
  double totalMs() const { return beforeStepMs() + stepMs + writeMs + readBackMs; }

  /// Adds all times and numbers, for sums over ticks.
  LIMBER_API TickProfile& operator+=(const TickProfile& other);
};

/// Adds soft bodies to an existing btDiscreteDynamicsWorld.
///
///     limber::SoftBodySystem soft(world);
///     auto body = soft.createBody(network, settings);   // then step the world as usual
///
/// It uses the world's pre-tick callback. An existing callback is called first; the world's user info is not
/// changed. The previous callback is restored with the removal of the last body and spring. If no soft body
/// was in the world (springs between rigid bodies only), it is restored at the world's next tick, because the
/// world may have been deleted by then. Several systems may share a world. The world, its bodies and the
/// system may be deleted in any order, with one exception: if the broadphase is deleted before the world,
/// call removeAll() first. Once the world has been deleted, only
/// the destructor may be called. Rigid bodies with springs or anchors must outlive them, as with Bullet's own
/// constraints; forget(body) removes all springs and anchors of one body. Springs on a point mass that the
/// application deletes are removed with it. Thread rule: the thread that steps the world, between steps, or
/// within a step in callbacks and actions of the world.
class LIMBER_API SoftBodySystem {
 public:
  /// The caller that steps the springs.
  enum class Hook : std::uint8_t {
    PreTick,  ///< the world, through its pre-tick callback
    Manual    ///< the user, who owns that callback and calls beforeTick(h) first in it
  };

  explicit SoftBodySystem(btDiscreteDynamicsWorld& world, Hook hook = Hook::PreTick);
  /// Removes all its bodies and springs, and itself from the world if the world still exists.
  ~SoftBodySystem();
  SoftBodySystem(const SoftBodySystem&) = delete;
  SoftBodySystem& operator=(const SoftBodySystem&) = delete;

  /// Creates a body of the network's shape. The world must exist. Errors, with nothing created: no or invalid
  /// network, invalid settings, a volume modulus or pressure that the network cannot have (a surface that is
  /// not closed), a point that would be beyond 2e6 m, or move at more than 1e6 m/s.
  Result<SoftBody*> createBody(const SharedNetwork& network, const SoftBodySettings& settings = {});

  /// Removes the body, its anchors and every spring on it. The pointer is invalid afterwards. Error: a body
  /// that does not, or no longer, belong to this system.
  Result<void> destroyBody(SoftBody* body);

  /// Creates a body with the network, settings and state of another one of this world, also of another
  /// system, with its SoftBody::transform() at `transform`. It has no anchors, springs, name or user data.
  /// Errors, with nothing created: a body that is not alive(), those of createBody() and setTransform().
  Result<SoftBody*> clone(SoftBody* body, const btTransform& transform);

  // Saved states; SoftBody::saveState() says what they contain.

  /// Return the state of all bodies, the settings of all springs, the places of their ends in the world and
  /// the time of wind and fields, and restore it in a system that has as many, made in the same order. Grabs
  /// and their springs are not a part of it: they hold on. Errors, with nothing changed: those of
  /// SoftBody::restoreState(), with the number of the body; other numbers of bodies or springs.
  std::vector<std::uint8_t> saveState();
  Result<void> restoreState(const std::vector<std::uint8_t>& bytes);

  /// Returns all living bodies with their networks, states and names, as bytes for a file. Bullet's
  /// serializer also writes them: a `.bullet` file of world.serialize() has the soft bodies of all its
  /// systems.
  std::vector<std::uint8_t> saveBodies();
  /// Creates the bodies in bytes of saveBodies(), or of a `.bullet` file; returns them in their order. In a
  /// `.bullet` file that is the order of their objects in the world. Bullet's importers skip the objects of
  /// soft bodies (btBulletWorldImporter prints that it does not know their shapes). Errors, with nothing
  /// created: damaged bytes, and the errors of createBody().
  Result<std::vector<SoftBody*>> loadBodies(const std::vector<std::uint8_t>& bytes);

  std::size_t bodyCount() const;
  /// Returns body i, in order of creation; nullptr if there is no such body.
  SoftBody* body(std::size_t i) const;

  /// Adds a spring. Errors: invalid settings, both ends without a body, both ends at the same point of one
  /// body, a pivot that is not finite or farther than 1e6 m, or not 0 on a point mass, a surface object, a
  /// rigid body or a point mass of a soft body in another world. A rigid body in no world may be added to
  /// this one later.
  Result<SpringConstraint*> addSpring(const SpringEnd& a, const SpringEnd& b,
                                      const SpringSettings& settings = {});
  /// Joins two soft bodies where they meet: a spring from each point of `a` to the nearest point of `b`
  /// within `distance` (m), at the present distances unless the settings have a rest length. With
  /// SpringSettings::breakForce the seam can tear. Returns the springs. Errors, with nothing added: those of
  /// addSpring(), a distance that is not above 0, bodies of other systems, twice the same body, no points
  /// within the distance.
  Result<std::vector<SpringConstraint*>> weld(SoftBody* a, SoftBody* b, double distance,
                                              const SpringSettings& settings = {});
  /// Sets new settings of a spring; without a rest length it keeps the current one. Wakes the bodies at its
  /// ends if they differ. Errors: invalid settings, a spring that does not, or no longer, belong to this
  /// system.
  Result<void> changeSpring(SpringConstraint* spring, const SpringSettings& settings);
  /// Moves the end of a spring that is fixed in the world, at once; the other end is pulled along. Wakes
  /// nothing. Errors: no such spring, both ends on bodies, a pivot that is not finite or farther than 1e6 m.
  Result<void> moveSpring(SpringConstraint* spring, const btVector3& pivot);
  /// Removes a spring and wakes the bodies at its ends. Error: one that does not, or no longer, belong to
  /// this system.
  Result<void> removeSpring(SpringConstraint* spring);
  std::size_t springCount() const;

  /// Attaches point i to `body` at a pivot (m) in the body's local coordinates (the overload without pivot:
  /// at the current position of the point). Forces act in both directions; point and body do not collide, nor
  /// do the points around it that are inside the body, deeper than their radius, when it is attached. The
  /// anchor breaks for good in a tick in which it had to hold more than `breakForce` (N, 0: never), see
  /// ContactListener::anchorBreaks(), SoftBody::attached() and SoftBody::anchorForce(). Errors: a breakForce
  /// that is not from 0 to 1e18; a soft body that does not, or no longer, belong to a system of this world,
  /// no such point, a point that is already attached or pinned, a body that is a point mass or a surface
  /// object or in another world, a pivot that is not finite or farther than 1e6 m.
  Result<void> attach(SoftBody* softBody, std::uint32_t i, btRigidBody& body, const btVector3& pivot,
                      double breakForce = 0.0);
  Result<void> attach(SoftBody* softBody, std::uint32_t i, btRigidBody& body, double breakForce = 0.0);
  /// Attaches several points, as an edge or a patch, where they are. Each holds `breakForce` (N, 0: for
  /// ever). Errors, with none attached: those above, also for a point that is in `points` twice.
  Result<void> attach(SoftBody* softBody, const std::vector<std::uint32_t>& points, btRigidBody& body,
                      double breakForce = 0.0);
  /// Detaches an attached point. Errors: no such soft body, a point that is not attached.
  Result<void> detach(SoftBody* softBody, std::uint32_t i);

  /// Removes all springs and anchors on a rigid body, and wakes what they held. Call it before deleting a
  /// body that has any.
  void forget(const btRigidBody& body);

  // --- surroundings (surroundings.h), between steps. A change wakes the bodies that it may act on. ---

  /// Sets the air and the wind in it. Default: still air of 1.2 kg/m^3, in which ropes and cloths have drag
  /// and solids have none (SoftBodySettings::flow). Error: an invalid field.
  Result<void> setAir(const Air& air);
  /// Sets the water; std::nullopt (the default) for none. Error: an invalid field.
  Result<void> setWater(const std::optional<Water>& water);
  const Air& air() const;
  const std::optional<Water>& water() const;

  /// Adds a field that acts on one body, or with nullptr on all bodies of the system, also on later ones. It
  /// is removed with its body. Returns its number. Errors: an empty function, a body that is not of this
  /// system.
  Result<std::uint64_t> addField(ForceField field, SoftBody* body = nullptr);
  /// Removes a field. Error: no such field.
  Result<void> removeField(std::uint64_t field);

  /// Removes all bodies and springs and restores the world's original state.
  void removeAll();

  /// Sets the listener for contacts that begin, persist and end (contacts.h); nullptr for none. It
  /// must outlive the system or be replaced before. Contacts that exist already begin after the next tick.
  void setContactListener(ContactListener* listener);

  /// Sets the function that may change or reject contacts before they act (contact_filter.h); nullptr (the
  /// default) for none. It is asked for contacts of this system's bodies of all kinds: with static, kinematic
  /// and dynamic objects, with links of multibodies, with other soft bodies and with themselves, in both
  /// modes of Collision. If the two soft bodies of a contact are in different systems, both filters are
  /// asked. Wakes all bodies.
  void setContactFilter(ContactFilter filter);

  /// Sets whether contacts of bodies with Collision::Surface appear as manifolds in Bullet's dispatcher, for
  /// programs that read contacts there. Between ticks there is then one manifold for each pair of a surface
  /// object and an object that it touches, with the four contacts of the largest impulses; m_index0 and
  /// m_index1 are triangles of network().surface or -1. Bullet does not act on these manifolds and calls none
  /// of its contact callbacks for them. Off by default, because it costs time.
  void reportManifolds(bool report);

  HookState hookState() const;
  /// Registers the pre-tick callback again; the callback that had replaced it is called first from then on.
  void rehook();
  /// Sets the handler of warnings. It is called once when the hook is found overwritten, and when a body is
  /// restored for the first time because its motion was not finite (SoftBody::restorations()). Default: a
  /// line on standard error.
  void onWarning(std::function<void(const std::string&)> handler);

  /// Steps the springs. For Hook::Manual: call it in the pre-tick callback with the tick's length in seconds.
  void beforeTick(btScalar tick);

  /// Sets the function that runs the parts of a tick on several threads; nullptr (the default): all on the
  /// thread that steps the world. It applies to all systems of the world, also to those created later, until
  /// it is replaced. Ticks alone call it. Results are the same, to the bit, on any number of threads. Bodies
  /// of Collision::Surface are read, searched for contacts with static and kinematic objects, stepped, and
  /// written in parallel. Bodies that touch each other, or a common dynamic body, are stepped by one thread;
  /// by all together if there are many or large ones, as is a single body of 3000 springs or more. Bodies of
  /// Collision::Points are stepped in parallel.
  ///
  /// `fromSprings`: ticks whose awake bodies have fewer springs do not call it, unless one of them has 3000
  /// itself; 0: all call it. Some 200 cubes have 6000; with fewer, starting the threads takes longer than the
  /// work.
  ///
  /// Within a tick these may then be called on any thread, and several at a time: the world's
  /// btOverlapFilterCallback, the ContactFilter, Bullet's global functions for combined friction and
  /// restitution, and virtual functions of the user's shapes and objects. They must not throw. They may call
  /// findSurface(), findPoint(), isSystemObject() and SoftBody::settings(). Everything else keeps the thread
  /// rule above.
  void setParallelFor(ParallelFor run, std::size_t fromSprings = 6000);

  const TickProfile& profile() const;

  /// Returns the position of the world's clock between its last two ticks: 0 at the one before the last, 1 at
  /// the last, above 1 if the world extrapolates (setLatencyMotionStateInterpolation(false)). Bullet computes
  /// the transforms of motion states for this time. For SoftBody::writePositions(xyz, fraction).
  double tickFraction() const;

  /// Draws the soft bodies according to the drawer's mode. DBG_DrawWireframe: springs, blue at a compression
  /// of a tenth, red at an extension of a tenth, and crosses at pinned points. DBG_DrawAabb: a box around
  /// each body. DBG_DrawContactPoints: contacts. DBG_DrawConstraints: anchors and single springs. The world's
  /// debugDrawWorld() calls it automatically if the mode has wireframe, AABBs or normals.
  void debugDraw(btIDebugDraw& drawer) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Returns a function for SoftBodySystem::setParallelFor() that runs tasks with one of Bullet's task
/// schedulers (btCreateDefaultTaskScheduler(), btGetTBBTaskScheduler(), ...) or the user's own. The scheduler
/// must outlive it. Where Bullet was built without BT_THREADSAFE, as Debian's is, its functions return
/// nullptr for all schedulers but the sequential one.
LIMBER_API ParallelFor parallelForOf(btITaskScheduler& scheduler);

/// Makes the dispatcher compute contacts between spheres and boxes with Bullet's closed form
/// (btSphereBoxCollisionAlgorithm) instead of its general convex algorithm. This holds for pairs that are
/// created later. The closed form is faster and more exact: in single precision the general algorithm
/// sometimes reports a sphere that rests on a box as centimetres above it. Single spheres and the point
/// masses of bodies with Collision::Points are affected. Contacts of spheres with spheres or triangles
/// already have closed forms.
LIMBER_API void useFastSphereAlgorithms(btCollisionDispatcher& dispatcher);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

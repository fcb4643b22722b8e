// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/export.h>
#include <limber/handle.h>
#include <limber/result.h>
#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;
struct SoftContact;
struct SurfaceHit;

/// A point that was divided where a body tore or was cut.
struct Tear {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< m
  std::uint32_t point = 0;                          ///< the divided point
  std::uint32_t copy = 0;                           ///< the new point at the same place
  double energy = 0.0;  ///< J, of the spring that was too long; 0: a cut, or a point next to
                        ///< that spring that the same tear divides
};

/// One soft body in a world. SoftBodySystem creates and owns it; the pointer is valid until destroyBody(),
/// removeAll(), or the destruction of the system. A handle() tells whether the body still exists.
///
/// Every point mass is an ordinary btRigidBody sphere, which the user may use like any other: apply forces
/// and impulses, move it, set its velocity, user pointer and index, and material. Changes between ticks take
/// effect in the next tick. With Collision::Points, sleeping points must be activated first, as any body of
/// Bullet, or by wake(). Indices run from 0 to pointCount() - 1 in the order of network().restPoints.
///
/// With Collision::Points these spheres are in the world. With Collision::Surface they are not, and the world
/// has surfaceObject() instead. Bullet's own constraints then cannot act on the points (springs, anchors and
/// pins can). Thread rule: the thread that steps the world, between steps.
class LIMBER_API SoftBody {
 public:
  ~SoftBody();
  SoftBody(const SoftBody&) = delete;
  SoftBody& operator=(const SoftBody&) = delete;

  /// Returns a reference that becomes null when the body is destroyed.
  Handle<SoftBody> handle();

  const SpringNetwork& network() const;
  const SharedNetwork& sharedNetwork() const;
  const SoftBodySettings& settings() const;
  std::uint32_t pointCount() const;

  /// Returns false after the application has deleted one of its point masses or its surface object, or
  /// removed it from the world (as the clean-up loop of Bullet's HelloWorld does), and once the world is
  /// gone. The springs then no longer act. If the application adds what it has removed again, the body is
  /// alive at once and moves on from where it was.
  bool alive() const;

  // Of the user; the plugin does not read them. saveBodies() saves the name.
  const std::string& name() const;
  void setName(std::string name);
  void* userPointer() const;  ///< nullptr at first
  void setUserPointer(void* pointer);
  int userIndex() const;  ///< -1 at first
  void setUserIndex(int index);

  /// Returns the Bullet body of point i; nullptr if the application has deleted it, or if there is no such
  /// point. With Collision::Surface,
  /// stepping is cheaper while this has not been called for any point of the body.
  btRigidBody* point(std::uint32_t i) const;

  /// Returns the object that represents the body in Bullet's world with Collision::Surface. Its origin is the
  /// centre of mass, its velocity the mean velocity, and its shape the current surface, which rays, sweeps
  /// and contact tests find. The user sets its group, mask, user pointer and index. Its friction is that of
  /// the points until point() is called. Impulses, forces, velocities and poses set on it act on the soft
  /// body as on a rigid body of its mass and inertia, from the next tick on, and Bullet's constraints may be
  /// attached to it. Its gravity and damping are those of the settings and the world. Like the points it has
  /// the flag CF_DISABLE_VISUALIZE_OBJECT, since the system draws the body. Deleting it or removing it from
  /// the world disables the body (alive()); adding it again revives it. Returns nullptr with
  /// Collision::Points, or after it was deleted.
  btRigidBody* surfaceObject() const;

  /// Return the position (m) and velocity (m/s) of point i; NaN if there is no such point.
  Eigen::Vector3d position(std::uint32_t i) const;
  Eigen::Vector3d velocity(std::uint32_t i) const;

  /// Writes all positions as pointCount() x 3 floats, x y z. The memory is never read, so it may be mapped
  /// GPU memory.
  void writePositions(float* xyz) const;
  /// Writes the positions at a time between the last two ticks, for frames that do not coincide with ticks: 0
  /// is before the last tick, 1 after it, more than 1 extrapolates. SoftBodySystem::tickFraction() returns
  /// the fraction at which Bullet shows its rigid bodies. Points that were moved by hand since then are
  /// written at their new positions.
  void writePositions(float* xyz, double tickFraction) const;

  /// Returns the number of skinned points (limber::Skin); without a skin that of the points themselves.
  /// network().render.vertexToPoint holds their indices.
  std::uint32_t skinnedPointCount() const;
  /// Writes the positions of the skinned points as skinnedPointCount() x 3 floats, in order. The memory is
  /// never read.
  void writeSkinnedPositions(float* xyz) const;
  void writeSkinnedPositions(float* xyz, double tickFraction) const;

  /// Returns the present surface, for export: the render surface with its skin and texture coordinates, or
  /// the triangles of the points; with normals. Empty for ropes.
  TriangleMesh surfaceMesh() const;
  /// Write the present surface (saveMesh()), and the points and springs (saveSprings()), as .obj or .ply.
  /// Errors as there; exportMesh() of a rope.
  Result<void> exportMesh(const std::string& file) const;
  Result<void> exportSprings(const std::string& file) const;
  /// Returns network() with the present shape as its rest shape, without the springs that have broken: a body
  /// made of it, with the same scale and mass fractions and without factors of rest lengths, has no strain at
  /// the present place. To keep dents, call it when the body has come to rest. Error: a
  /// tetrahedron that is inside out, and the like, from validate(SpringNetwork).
  Result<SharedNetwork> presentNetwork() const;

  // Errors of the following: no such point, a point that the application has deleted, a body that is
  // not alive().

  /// Fixes point i at its position: it becomes a kinematic body of Bullet until unpin(). No change if it is
  /// pinned already.
  Result<void> pin(std::uint32_t i);
  /// Moves a pinned point to `target` over the next tick; the springs pull the other points along. It takes
  /// more ticks where the pin would be faster than SoftBodySettings::maxPinSpeed. Further errors: a point
  /// that is not pinned; a target that is not finite.
  Result<void> movePin(std::uint32_t i, const btVector3& target);
  /// Moves a pinned point to `target` at once: it has no velocity from that. Errors as of movePin().
  Result<void> teleportPin(std::uint32_t i, const btVector3& target);
  /// Releases a pinned point. It has its mass again and keeps the velocity of its last movement. Further
  /// error: a point that is not pinned.
  Result<void> unpin(std::uint32_t i);
  /// Returns whether point i exists and is pinned.
  bool pinned(std::uint32_t i) const;
  /// Returns whether point i exists and is attached to a rigid body, SoftBodySystem::attach().
  bool attached(std::uint32_t i) const;
  /// Returns the mean force (N) of point i's anchor on the point in the last tick; 0 if it is not attached.
  btVector3 anchorForce(std::uint32_t i) const;
  /// Returns the force (N) with which the pin holds point i against its springs, dampers, volume and weight,
  /// at the present positions and velocities; 0 if it is not pinned. Drag, contacts and the inertia of a pin
  /// that is moved do not count. Costs as much as a substep of the body.
  btVector3 pinForce(std::uint32_t i) const;

  // --- changes while the body lives. Errors of all: a body that is not alive(); values that are not finite
  // or too large. All of them wake the body.

  /// Gives the body other settings, also of its material: withMaterial(network(), material, settings()).
  ///
  ///     SoftBodySettings s = body->settings();
  ///     s.extensionStiffness = s.compressionStiffness = 500.0;
  ///     body->change(s);
  ///
  /// Positions and velocities stay, so only what is changed brings or takes energy: a stiffness takes effect
  /// at the present strains, a mass at the present velocities, a pressure at the present volume. Another
  /// `scale` scales the present shape about the centre of mass along the body's axes, with equal strains;
  /// pinned and attached points stay. Springs that have yielded keep the strain of that, broken ones stay
  /// broken. Masses that the user has set on points stay; friction, restitution and sleeping thresholds that
  /// the user has set on Bullet's objects are replaced where these settings differ from the present ones.
  /// Position, rotation and velocities in `settings` are not used. Makes new constants, which takes about as
  /// long as creating a body. Errors, with nothing changed: those of createBody(); another `collision`;
  /// another sign of a `scale`.
  Result<void> change(const SoftBodySettings& settings);

  /// Returns the place of the body: the centre of mass of all points, pinned ones included, with the masses
  /// of the settings, and the rotation that brings the rest shape nearest to the present one.
  btTransform transform() const;
  /// Moves the body, pinned points included, to this transform() at once. Its deformation, velocity and
  /// angular velocity stay; the displacement gives it no velocity. Attached points are pulled back by their
  /// bodies, unless these are placed elsewhere together with them: detach them before.
  Result<void> setTransform(const btTransform& transform);
  /// Gives all points that are not pinned the velocity of a rigid body: m/s, rad/s about transform()'s
  /// origin.
  Result<void> setVelocity(const btVector3& linear, const btVector3& angular = btVector3(0, 0, 0));
  /// Brings the body back to its rest shape: as it was created, with the place and velocities of its
  /// settings, or at rest at a transform(). Springs are as at first, neither yielded nor broken. Pins stay
  /// pins, tears and cuts stay.
  Result<void> reset();
  Result<void> reset(const btTransform& transform);

  /// Applies a force (N) in all ticks of the coming stepSimulation(), as for Bullet's bodies: to the body as
  /// a whole, at point i, or at a place on its surface. Pinned points do not move. Further errors: no such
  /// point; a hit of another body.
  Result<void> applyForce(const btVector3& force);
  Result<void> applyForce(const btVector3& force, std::uint32_t i);
  Result<void> applyForce(const btVector3& force, const SurfaceHit& place);
  Result<void> applyTorque(const btVector3& torque);  ///< N m
  /// Change the momentum (N s) or angular momentum (N m s) at once.
  Result<void> applyImpulse(const btVector3& impulse);
  Result<void> applyImpulse(const btVector3& impulse, std::uint32_t i);
  Result<void> applyImpulse(const btVector3& impulse, const SurfaceHit& place);
  Result<void> applyTorqueImpulse(const btVector3& impulse);
  /// Pushes all points within `radius` (m) away from `center`, as an explosion does: a point at the distance
  /// d gets the velocity speed (1 - d / radius) in addition; towards the centre if speed (m/s) is negative.
  Result<void> applyBlast(const btVector3& center, btScalar radius, btScalar speed);

  // --- tears and cuts. They give the body a network of its own, so network() and its indices change: points
  // keep their indices, new ones follow; triangles keep theirs, and filled bodies get more of them; indices
  // of springs, vertices and skinned points change. Mass, momentum, area and volume stay. A closed body
  // without tetrahedra is open afterwards: its pressure and volume modulus end.

  /// Cuts the body along the plane through `point` (m) with this normal, at its present shape. The cut
  /// follows the edges of triangles, the faces of tetrahedra or the points of ropes that are nearest to the
  /// plane. Returns the number of new points: 0 where the plane does not cross the body, or within a tick:
  /// the cut is then made at the start of the next one. contacts() is empty until then. A pinned point that
  /// is divided stays pinned on both sides, an attached one stays attached with point i. Takes about as long
  /// as creating a body. Errors, with nothing changed: a body that is not alive(); numbers that are not
  /// finite; a normal of 0; a point that would get too small a mass.
  Result<std::uint32_t> cut(const btVector3& point, const btVector3& normal);
  /// Cuts with a blade only where it has passed: from edge[0], edge[1] to edge[3], edge[2] (m). The corners
  /// are in the order around the region, which is nearly flat. A cut that ends within the body on all sides
  /// opens nothing if it crosses a single edge, so the sweeps of a slow blade should begin where the blade
  /// entered the body. Errors as above; an area of 0.
  Result<std::uint32_t> cut(const std::array<btVector3, 4>& edge);
  /// Returns where the body tore or was cut in the last tick and since (ElasticLimit::tear). Valid until the
  /// next tick or cut.
  const std::vector<Tear>& tears() const;

  // --- the state of the body

  /// Returns the whole state as bytes: settings, positions, velocities, pins, masses, yielded and broken
  /// springs, sleep, contacts() and their impulses. From restoreState() on a body of the same network
  /// continues as this one, to the bit, in a world of the same objects with the same states. Anchors, single
  /// springs, forces for the coming step, and what you have given single points besides their masses, as
  /// gravity or friction, are not part of it. It is also saved of a body that is not alive(), which
  /// cannot be restored. Takes about as long as reading all points; the searches for contacts in the next
  /// tick take longer, because it also discards their caches. So from then on the bits of a run are those of
  /// its restorations, but not those of a run in which no state was saved, which differs by rounding: peers
  /// in lockstep save in the same ticks.
  std::vector<std::uint8_t> saveState();
  /// Restores a state. Errors, with nothing changed: bytes that saveState() has not made, or that are
  /// damaged; a body of another network or kind of collision. A body that has torn since the state was saved
  /// has another network; SoftBodySystem::saveBodies() also saves the network.
  Result<void> restoreState(const std::vector<std::uint8_t>& bytes);

  /// Returns the number of ticks in which a position, velocity or force of the body was not finite, or beyond
  /// 1e18. It is 0 unless the application has set such a value or the step has computed one. The points then
  /// get their last valid values, and SoftBodySystem::onWarning()'s handler is called the first time.
  std::uint32_t restorations() const;

  bool sleeping() const;
  void wake();
  /// Puts the body to sleep in the next tick, wherever it is, until something touches or wakes it. Bodies
  /// that springs join sleep only together. Setting the state ISLAND_SLEEPING of surfaceObject() does the
  /// same.
  void sleep();

  /// Returns the number of substeps of the springs in the last tick; 0 while asleep.
  int substeps() const;
  /// Returns a number that the bodies of the world have in common that were stepped together in the last
  /// tick, because contacts, joints, springs or anchors couple them, also through rigid bodies; a body that
  /// was stepped alone has one for itself. Surfaces that were near enough to meet in the tick count as
  /// touching. The number stays as long as the first of these bodies and the bodies made before it stay. -1
  /// while asleep, and before the first tick. For debug pictures.
  int island() const;
  /// Returns the smallest share of its stiffness that a spring, or the volume modulus, of this body has left
  /// because of Stepping::maxSubsteps: 1 without softening. At 0.01 the body may be deformed by 100 times
  /// what its settings would allow. It is that of the last tick, and 1 before the first one.
  double softening() const;
  /// Returns the integrator of the last tick, never Auto.
  Stepper stepper() const;
  /// Returns an estimate of the rate, in m/s, at which the body's motion deviates from the exact one because
  /// of the substep length (root mean square over the points). It is the value of the last tick, or a larger
  /// earlier one that decays over a quarter of a second. Contacts are not included.
  double errorPerSecond() const;
  /// Returns an upper bound, in rad/s, of the fastest oscillation of the body's springs at any deformation.
  /// Substeps are short enough to be stable for this bound, with volumes, tetrahedra and links added, and as
  /// exact as Stepping::periodTolerance requires for the fastest oscillation about the rest shape. 0 before
  /// the first tick.
  double frequencyBound() const;

  /// Returns the contacts of the last tick with their impulses (contacts.h): all that had an impulse, and
  /// all with a distance below 5 % of the radius. For a sleeping body they are those of its last tick awake.
  /// Objects that have left the world since then are omitted. Valid until the next tick or call.
  const std::vector<SoftContact>& contacts() const;

  double totalMass() const;                 ///< kg of all points that are not static or kinematic
  Eigen::Vector3d centerOfMass() const;     ///< m
  Eigen::Vector3d linearMomentum() const;   ///< kg m/s
  Eigen::Vector3d angularMomentum() const;  ///< kg m^2/s about the world's origin
  double kineticEnergy() const;             ///< J
  double elasticEnergy() const;             ///< J in its own springs and its volume term, which is 0 at the
                                            ///< volume at rest: below 0 in a gas that has expanded
  double volume() const;                    ///< m^3 inside its closed surfaces at present; 0 without any. The
                                            ///< gauge pressure of a gas is in the settings at rest, and
                                            ///< (pressure + ambientPressure) V0 / V - ambientPressure at V

  /// Returns the indices in network().springs of those that have broken, see ElasticLimit, in order.
  std::vector<std::uint32_t> brokenSprings() const;

  /// Returns a hash of all positions and velocities, bit for bit: equal runs give equal hashes.
  std::uint64_t stateHash() const;

 private:
  friend class SoftBodySystem;
  friend SoftBodyData& dataOf(const SoftBody& body);
  explicit SoftBody(std::unique_ptr<SoftBodyData> data);

  std::unique_ptr<SoftBodyData> data_;
  std::shared_ptr<const void> life_;  // expires with the body; nullptr until there is a handle
};

/// The soft body and index of a point mass, found from any collision object that Bullet reports (contact,
/// ray, sweep).
struct PointReference {
  SoftBody* body = nullptr;  ///< nullptr: the object is no point mass of an existing soft body
  std::uint32_t index = 0;
};
LIMBER_API PointReference findPoint(const btCollisionObject* object);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

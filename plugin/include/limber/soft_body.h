// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;
struct SoftContact;

/// One soft body in a world. Made and owned by SoftBodySystem; the pointer stays valid until destroyBody(),
/// removeAll(), or the end of the system.
///
/// Every point mass is an ordinary btRigidBody sphere that belongs to the user as much as any other: apply
/// forces and impulses, move it, set its velocity, its user pointer and index, its material. Whatever changes
/// between ticks is taken over. Indices run from 0 to pointCount() - 1 in the order of network().restPoints.
///
/// With Collision::Points these spheres are in the world; with Collision::Surface they are not: Bullet's own
/// constraints cannot hold them (springs, anchors and pins can), and the world has surfaceObject() instead.
/// Thread rule: the thread that steps the world, between steps.
class SoftBody {
 public:
  explicit SoftBody(std::unique_ptr<SoftBodyData> data);
  ~SoftBody();
  SoftBody(const SoftBody&) = delete;
  SoftBody& operator=(const SoftBody&) = delete;

  const SpringNetwork& network() const;
  const SharedNetwork& sharedNetwork() const;
  const SoftBodySettings& settings() const;
  std::uint32_t pointCount() const;

  /// False once the application has deleted or removed one of its point masses or its surface object (as
  /// HelloWorld's clean-up loop does): the springs then no longer act.
  bool alive() const;

  /// The Bullet body of point i, nullptr if the application has deleted it. With Collision::Surface a body is
  /// cheaper to step until this has been called for one of its points.
  btRigidBody* point(std::uint32_t i) const;

  /// What stands for the body in Bullet's world with Collision::Surface: its origin is the centre of mass,
  /// its velocity the mean one, its shape the surface as it is now, which rays, sweeps and contact tests
  /// find. Group, mask, user pointer and index are the user's, its friction is that of the points until
  /// point() is called. Impulses, forces, velocities and poses that are given to it act on the soft body as
  /// on a rigid one of its mass and inertia, from the next tick on, and Bullet's constraints hold it; its
  /// gravity and damping are those of the settings and the world. Like the points it has the flag
  /// CF_DISABLE_VISUALIZE_OBJECT: the system draws the body. Deleting it or taking it out of the world
  /// ends the body. nullptr with Collision::Points, or once it is deleted.
  btRigidBody* surfaceObject() const;

  Eigen::Vector3d position(std::uint32_t i) const;  ///< m
  Eigen::Vector3d velocity(std::uint32_t i) const;  ///< m/s

  /// Writes all positions as pointCount() x 3 floats, x y z; only writes, so mapped GPU memory will do.
  void writePositions(float* xyz) const;
  /// The same at a time between the last two ticks, for pictures that do not coincide with ticks: 0 is before
  /// the last tick, 1 after it, more than 1 goes on as in that tick. SoftBodySystem::tickFraction() tells at
  /// which fraction Bullet shows its rigid bodies. What has been moved by hand since is where it was put.
  void writePositions(float* xyz, double tickFraction) const;

  /// What network().render.vertexToPoint counts: the places of the skin, without one the points themselves.
  std::uint32_t placeCount() const;
  /// Writes the positions of the places as placeCount() x 3 floats; only writes, in order.
  void writePlaces(float* xyz) const;
  void writePlaces(float* xyz, double tickFraction) const;

  /// Holds point i where it is: it becomes a kinematic body of Bullet until unpin().
  void pin(std::uint32_t i);
  /// Moves a pinned point; it gets there over the next tick, dragging the springs along.
  void movePin(std::uint32_t i, const btVector3& target);
  /// Lets go of a pinned point, which keeps the velocity it was moved with.
  void unpin(std::uint32_t i);
  bool pinned(std::uint32_t i) const;

  /// Ticks in which a position, velocity or force of the body was not finite, or beyond 1e18: 0 unless the
  /// application has set such a value or the step has computed one. Points then get their last sound values,
  /// and SoftBodySystem::onWarning() is told the first time.
  std::uint32_t restorations() const;

  bool sleeping() const;
  void wake();

  /// Springs were stepped this often in the last tick; 0 while asleep.
  int substeps() const;
  /// What advanced the body in the last tick, never Auto.
  Stepper stepper() const;
  /// m/s: estimate of how fast the body's motion departs from the exact one for want of finer substeps, root
  /// mean square over the points: the last tick's, or what is left of an earlier peak, which fades over a
  /// quarter of a second. Contacts are not in it.
  double errorPerSecond() const;
  /// rad/s, an upper bound of the body's fastest oscillation at any deformation. Substeps are short enough
  /// for it to be stable, and as exact as Stepping::periodTolerance asks at the rest shape's own fastest one.
  double frequencyBound() const;

  /// Where the body touches something, and what was borne there in the last tick (soft_contact.h): all that
  /// bore anything, and what is nearer than 5 % of the radius. Of a sleeping body those of the last tick in
  /// which it was awake. What has left the world since is left out. Valid until the next tick or call.
  const std::vector<SoftContact>& contacts() const;

  double totalMass() const;                 ///< kg of all points that are not held
  Eigen::Vector3d centerOfMass() const;     ///< m
  Eigen::Vector3d linearMomentum() const;   ///< kg m/s
  Eigen::Vector3d angularMomentum() const;  ///< kg m^2/s about the world's origin
  double kineticEnergy() const;             ///< J
  double elasticEnergy() const;             ///< J in its own springs and its volume

  /// A hash of all positions and velocities, bit for bit: equal runs give equal hashes.
  std::uint64_t stateHash() const;

 private:
  friend class SoftBodySystem;
  friend SoftBodyData& dataOf(const SoftBody& body);
  std::unique_ptr<SoftBodyData> data_;
};

/// The soft body and index of a point mass, from any collision object that Bullet reports (contact, ray,
/// sweep).
struct PointReference {
  SoftBody* body = nullptr;  ///< nullptr: the object is no point mass of a living soft body
  std::uint32_t index = 0;
};
PointReference findPoint(const btCollisionObject* object);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

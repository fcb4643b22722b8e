// SPDX-License-Identifier: Zlib
#pragma once

// Contacts and hits of soft bodies.

#include <limber/bullet_precision.h>
#include <limber/export.h>
#include <limber/soft_body.h>
#include <limber/spring_constraint.h>

#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- points on soft bodies that Bullet's queries hit -------------------------------------------------------

/// The soft body of a surface object, found from any collision object that Bullet reports.
struct SurfaceReference {
  SoftBody* body = nullptr;  ///< nullptr: the object is not the surface object of an existing soft body
};
LIMBER_API SurfaceReference findSurface(const btCollisionObject* object);

/// The point of a soft body that a ray, sweep or contact has hit.
struct SurfaceHit {
  SoftBody* body = nullptr;    ///< nullptr: no surface, or no such triangle
  std::uint32_t triangle = 0;  ///< index into network().surface; for a body without one (a rope), the index
                               ///< of the spring in network().springs
  std::array<std::uint32_t, 3> points{};              ///< the corners; of a spring a, b, b
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< barycentric coordinates, 0 or more, sum 1, of the
                                                      ///< point of the triangle or spring nearest to the hit
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();   ///< unit, by the winding of the triangle; for a spring,
                                                      ///< from the spring to the hit; 0 if there is none
};

/// Returns the hit for a `triangleIndex` as Bullet reports it (LocalShapeInfo::m_triangleIndex, or the index
/// of contact tests) and a point in world coordinates.
LIMBER_API SurfaceHit surfaceHit(const btCollisionObject* object, int triangleIndex, const btVector3& point);

// --- contacts ----------------------------------------------------------------------------------------------

/// A point on a soft body: the sum of weights[i] times the position of points[i].
struct ContactSide {
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::uint32_t triangle = kNone;  ///< index into network().surface; if an edge or a point touches, the
                                   ///< adjacent triangle that faces the other side most. kNone: the body has
                                   ///< no triangles, or Collision::Points
  std::array<std::uint32_t, 3> points{};  ///< the corners of the triangle in order; without a triangle the
                                          ///< points in contact, the last one repeated
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< 0 or more, sum 1; all 0: not on a soft body
};

/// A contact of a soft body in the last tick, with its impulse, seen from `body`. Two soft bodies in contact
/// have one contact each, with the sides exchanged. For a body that touches itself there is one contact, in
/// which `otherBody` is the same body.
struct SoftContact {
  SoftBody* body = nullptr;
  const btCollisionObject* other = nullptr;  ///< for a soft body its surface object, or its point mass
  SoftBody* otherBody = nullptr;             ///< nullptr: `other` is not soft
  ContactSide side, otherSide;               ///< otherSide is set only if `other` is soft
  btVector3 position = btVector3(0, 0, 0);   ///< m, on the surface of `body`, its radius included
  btVector3 normal = btVector3(0, 0, 0);     ///< unit, from other to body
  double distance = 0.0;  ///< m between the surfaces at the end of the tick, below 0 where they overlap; the
                          ///< other surface is at position - distance * normal
  btVector3 impulse = btVector3(0, 0, 0);          ///< N s on body, sum over the tick
  double normalImpulse = 0.0;                      ///< N s, the part of `impulse` along the normal, 0 or more
  btVector3 frictionImpulse = btVector3(0, 0, 0);  ///< N s, the part across the normal (on a curved
                                                   ///< surface, the normal at each moment)
};

/// Returns contact `point` of a manifold in Bullet's dispatcher. The manifold belongs to a point mass or to a
/// surface object (SoftBodySystem::reportManifolds()). `body` is the first of the two objects that is soft;
/// nullptr if neither is, or if the manifold has no such contact. A manifold stores only part of a
/// SoftContact: the position, for which the nearest point of the stored triangle is returned, and the
/// impulses along and across the normal.
LIMBER_API SoftContact readContact(const btPersistentManifold& manifold, int point);

// --- listeners ---------------------------------------------------------------------------------------------

/// A soft body and an object that it touches. Two soft bodies in contact give two pairs, one for each body.
struct ContactPair {
  SoftBody* body = nullptr;
  const btCollisionObject* other = nullptr;  ///< for a soft body its surface object; with Collision::Points
                                             ///< the sphere of its first point, whichever point touches
  SoftBody* otherBody = nullptr;             ///< nullptr: the other is not soft
  bool otherGone = false;  ///< at the end of a pair: other and otherBody may have been deleted; use the
                           ///< pointers for identification only, do not dereference them

  // These are 0 at the end of a pair.
  std::size_t contacts = 0;                ///< number of entries of body->contacts() that belong to the pair
  double normalImpulse = 0.0;              ///< N s, sum over these contacts in the last tick
  btVector3 impulse = btVector3(0, 0, 0);  ///< N s on body, sum over these contacts
  SoftContact strongest;                   ///< the contact with the largest impulse
};

/// An anchor that has broken, see SoftBodySystem::attach().
struct BrokenAnchor {
  SoftBody* body = nullptr;
  std::uint32_t point = 0;                   ///< of the body
  const btCollisionObject* other = nullptr;  ///< the rigid body to which it was attached
  double force = 0.0;                        ///< N, that it had to hold
};

/// Receives the contacts after each tick, on the thread that steps the world. Soft bodies are reported in
/// order of creation, the objects that they touch in the order in which they were added to the world.
///
/// A pair begins in the first tick after which body->contacts() has an entry for it. It ends in the first
/// tick after which there is none. While the soft body sleeps, its pairs continue without calls. A pair also
/// ends when one of the two objects leaves the world: the call then follows after the next tick, or at once
/// from destroyBody() and removeAll(). There is no such call when the system or the world is destroyed, or
/// when the listener is replaced.
///
/// A listener may read everything, apply forces and impulses, and remove rigid bodies from the world. Soft
/// bodies that it destroys are deleted after all calls of the tick. It must not destroy the system.
class LIMBER_API ContactListener {
 public:
  virtual ~ContactListener() = default;
  virtual void contactBegins(const ContactPair&) {}
  virtual void contactPersists(const ContactPair&) {}
  virtual void contactEnds(const ContactPair&) {}

  // Called before those, once for each event of the last tick.

  /// A spring of the system has broken (SpringSettings::breakForce).
  virtual void springBreaks(SpringConstraint&) {}
  virtual void anchorBreaks(const BrokenAnchor&) {}
  /// The body has torn (ElasticLimit::tear), or got the cuts that were asked for within the tick before.
  virtual void bodyTears(SoftBody&, const std::vector<Tear>&) {}
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

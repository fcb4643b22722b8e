// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/rigid_surfaces.h"
#include "bullet/surface_object.h"
#include "bullet/surface_shape.h"
#include "collide/surface_contacts.h"

#include <Eigen/Geometry>

#include <deque>
#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The plane in which a point last touched a static or kinematic convex body, in that body's coordinates.
struct CachedContact {
  std::uint64_t partner = 0;  ///< its stamp, see stampOf(); 0: none
  btVector3 surface = btVector3(0, 0, 0), normal = btVector3(0, 0, 0);
  btVector3 place = btVector3(0, 0, 0);  ///< of the point's centre when it was found
};

/// Where a body may get in a tick if nothing is in its way, see contact_reach.h.
struct Flight {
  Eigen::AlignedBox3d box;  ///< m
  double reach = 0.0;       ///< m, no point gets farther
  double tick = 0.0;        ///< s, of that tick; 0: not known
};

/// The part of a concave static object that is around a body. It is kept while the body stays within it.
struct ConcavePatch {
  int partner = 0;      ///< unique id in the broadphase; 0: none
  bool used = false;    ///< in the present tick
  btTransform pose;     ///< of the partner when it was made
  btVector3 low, high;  ///< m, of the partner's coordinates: all triangles in there
  ShapeSurface surface;
  std::unique_ptr<RigidPart> part;  ///< a view of it
};

/// The last search for contacts with a surface. Kept while the two are near, and then for its memory.
struct KeptSearch {
  const btCollisionObject* partner = nullptr;  ///< nullptr: none
  int id = 0;                                  ///< of the partner in the broadphase, unless used again
  std::uint64_t part = 0;                      ///< of the partner's shape
  bool used = false;       ///< in the present tick
  KeptContacts kept;
};

/// How a surface object was left, see surface_rigid.h.
struct LeftObject {
  btTransform pose = btTransform::getIdentity();
  btVector3 velocity = btVector3(0, 0, 0), spin = btVector3(0, 0, 0);
};

/// What a body with Collision::Surface has besides its points.
struct SurfaceData {
  SurfaceObject* object = nullptr;  ///< nullptr: Collision::Points, or the application has deleted it
  std::unique_ptr<SurfaceShape> shape;
  LeftObject left;
  Eigen::Quaterniond frame = Eigen::Quaterniond::Identity();  ///< the object's basis, turning with the body
  Eigen::Vector3d objectForce = Eigen::Vector3d::Zero();      ///< N, on the object in this stepSimulation()
  Eigen::Vector3d objectTorque = Eigen::Vector3d::Zero();     ///< N m
  bool pushed = false;                  ///< there have been any
  bool joined = false;                  ///< a constraint of Bullet's holds the object
  std::vector<double> gaps;             ///< #contacts, scratch of takeBackObject()
  bool held = false;                    ///< taken out of the simulation by Bullet or the user
  btVector3 gravity;                    ///< m/s^2, of the world when the points were given it
  Points force;                         ///< 3 x #points, N, of the present stepSimulation(); once shared
  std::vector<CachedContact> contacts;  ///< #points
  Flight flight;                        ///< foreseen for the coming tick; Bullet's broadphase has its box
  std::vector<btCollisionObject*> partners;  ///< of the coming tick, see surface_partners.h

  std::shared_ptr<const SurfaceTopology> topology;  ///< of its points, triangles and, of ropes, springs
  Points motion;                                    ///< 3 x #points, m, expected over the tick
  Points within;                                    ///< 3 x #points, m, where they are within a step
  SurfaceBoxes boxes;
  MovingSurface moving;               ///< a view of the above
  double impact = 0.0;                ///< m in the tick, towards static and kinematic objects that stop it
  bool foreseen = false;              ///< `motion` and `impact` are those of this tick
  bool fitted = false;                ///< and so are `boxes`
  std::vector<KeptSearch> searches;  ///< with what was near in the last tick
  std::deque<ConcavePatch> patches;  ///< of concave partners; views into a patch last as long as it does
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

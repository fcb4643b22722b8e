// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/rigid_surfaces.h"
#include "bullet/surface_object.h"
#include "bullet/surface_shape.h"
#include "core/kept_contacts.h"

#include <Eigen/Geometry>

#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The plane in which a point last touched a static or kinematic convex body, in that body's coordinates.
struct CachedContact {
  int partner = 0;  ///< its unique id in the broadphase; 0: none
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
  int partner = 0;      ///< unique id in the broadphase
  btTransform pose;     ///< of the partner when it was made
  btVector3 low, high;  ///< m, of the partner's coordinates: all triangles in there
  ShapeSurface surface;
  std::unique_ptr<RigidPart> part;  ///< a view of it
};

/// The last search for contacts with a surface. Kept while the two are near, and then for its memory.
struct KeptSearch {
  int partner = 0;         ///< its unique id in the broadphase
  std::uint64_t part = 0;  ///< of the partner's shape
  bool used = false;       ///< in the present tick
  KeptContacts kept;
};

/// What a body with Collision::Surface has besides its points.
struct SurfaceData {
  SurfaceObject* object = nullptr;  ///< nullptr: Collision::Points, or the application has deleted it
  std::unique_ptr<SurfaceShape> shape;
  bool held = false;                    ///< taken out of the simulation by Bullet or the user
  btVector3 gravity;                    ///< m/s^2, of the world when the points were given it
  Points force;                         ///< 3 x #points, N, of the present stepSimulation(); once shared
  std::vector<CachedContact> contacts;  ///< #points
  Flight flight;                        ///< foreseen for the coming tick; Bullet's broadphase has its box
  std::vector<btCollisionObject*> partners;  ///< of the coming tick, see surface_partners.h

  std::shared_ptr<const SurfaceTopology> topology;  ///< of its points, triangles and, of ropes, springs
  Points motion;                                    ///< 3 x #points, m, expected over the tick
  SurfaceBoxes boxes;
  MovingSurface moving;               ///< a view of the above
  bool foreseen = false;              ///< `motion` is that of this tick
  bool fitted = false;                ///< and so are `boxes`
  std::vector<KeptSearch> searches;   ///< with what was near in the last tick
  std::vector<ConcavePatch> patches;  ///< of concave partners
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

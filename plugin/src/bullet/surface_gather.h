// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/rigid_surfaces.h"
#include "bullet/soft_body_data.h"
#include "bullet/tick_contacts.h"
#include "core/surface_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Scratch of gatherSurfacePairs, kept for its capacity.
struct SurfaceSearch {
  ContactSearch search;
  std::vector<SurfaceContact> contacts;
};

/// Adds to `found` where the surface of a body with Collision::Surface touches, or may touch in the coming
/// tick: vertices, edges and triangles of rigid bodies that move by themselves, and of other soft bodies;
/// edges and triangles of its own on static and kinematic objects, on which its points are
/// gatherContacts()'s. Call it after gatherContacts() of all bodies; pairs of soft bodies are found once.
void gatherSurfacePairs(SoftBodyData& body, btScalar tick, RigidSurfaces& rigids, SurfaceSearch& search,
                        TickContacts& found);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

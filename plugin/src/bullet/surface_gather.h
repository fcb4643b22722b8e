// SPDX-License-Identifier: Zlib

// This header declares the search for contacts of surfaces, with rigid objects and with each other, before a
// step and within it.

#pragma once

#include "bullet/rigid_shapes.h"
#include "bullet/soft_body_data.h"
#include "bullet/tick_contacts.h"
#include "collide/surface_contacts.h"

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct LinkedGroup;

/// Scratch of gatherSurfacePairs, kept for its capacity.
struct SurfaceSearch {
  ContactSearch search;
  std::vector<SurfaceContact> contacts;
  std::vector<HeldPiece> pieces;
  std::vector<Contact> pairs;  ///< of findContactsInStep()
  std::vector<ContactSource> sources;
};

/// Makes those that have found another soft body known to it, too: one that has just been thrown is far
/// outside what the other one looks at. Call it after gatherContacts() of all bodies.
void shareSoftPartners(const std::vector<LinkedGroup>& groups);

/// Adds to `found` where the surface of a body with Collision::Surface touches, or may touch in the coming
/// tick: vertices, edges and triangles of rigid bodies that move by themselves, and of other soft bodies;
/// edges and triangles of its own on static and kinematic objects, on which its points are
/// gatherContacts()'s. Call it after gatherContacts() of all bodies; pairs of soft bodies are found once.
void gatherSurfacePairs(SoftBodyData& body, btScalar tick, RigidSurfaces& rigids, SurfaceSearch& search,
                        TickContacts& found);

/// Of the size of a surface's features: how far surfaces move against each other from one search to the next.
constexpr double kMaxBetweenSearches = 0.05;

/// How far the surfaces may move against each other in the tick, in sizes of their features: as was foreseen,
/// and by what hits on static and kinematic objects stop.
double displacementOf(const SurfaceCandidate& candidate);

/// Where the sides of a meeting are within a step.
struct SidePositions {
  const PointView *a = nullptr, *b = nullptr;
  const RigidState* rigid = nullptr;  ///< side b, if it is rigid and moves by itself
  double share = 0.0;                 ///< of the tick that is over
};

/// Writes the contacts of a meeting as they are now, and will be in the coming `ahead` seconds, to
/// search.pairs and search.sources, sorted by key. Their places have no bodies yet. The tick is that long
/// (s).
void findContactsInStep(const SurfaceCandidate& candidate, const SidePositions& sides, double ahead,
                        double tick, SurfaceSearch& search);

/// m, of a place on a surface.
Eigen::Vector3d positionOf(const MovingSurface& surface, const SurfacePoint& place);

// --- on what is held ---------------------------------------------------------------------------------------

/// The triangles of a static object with a concave shape that are around the body in this tick, or nullptr if
/// there are none. Made anew when the body or the object has moved away.
RigidPart* patchAround(SoftBodyData& body, const btCollisionObject& partner, const MovingSurface& soft);

/// Whether something of the part that is neither flat nor a plane's end is near: else the points are enough.
bool hasSharpFeatureNear(const SweptBox& box, const RigidPart& part);

/// Whether edges and triangles sink into a sphere or capsule by little where their corners rest on it.
bool staysCloseToRound(const MovingSurface& soft, const RigidPart& part);

/// Whether the points at the corners of what touches bear for it: those that are no more than `margin` (m)
/// farther from what they touch.
bool cornersCarryContact(const SoftBodyData& body, const SurfaceContact& c, double margin);

/// Whether other objects make the edge or corner of the part that is touched none: they are nearer to what
/// touches it, or flush with it.
bool isInternalEdge(const SoftBodyData& body, const MovingSurface& soft, const RigidPart& part,
                    const SurfaceContact& c, SurfaceSearch& s);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This header declares the search for contacts of surfaces, with rigid objects and with each other, before a
// step and within it.

#pragma once

#include "bullet/parallel.h"
#include "bullet/soft_body_data.h"
#include "bullet/tick_contacts.h"

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct LinkedGroup;

/// The motions of a rigid body in the tick and of all that may stop it.
struct RigidMotions {
  const btRigidBody* body = nullptr;
  Eigen::AlignedBox3d box;  ///< m
};

/// A direction along which two surfaces, without their radii, are apart, and their extents.
struct SeparatingAxis {
  bool isKnown = false;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  Extent a, b;
};

/// Scratch memory of a search, kept between calls.
struct SurfaceSearch {
  ContactSearch search;
  std::vector<SurfaceContact> contacts;
  std::vector<HeldPiece> pieces;
  std::vector<RigidPart*> parts;
  std::vector<RigidMotions> motions;    ///< of addStoppedPairs()
  std::vector<SeparatingAxis> axes;     ///< of addStoppedPairs(), #TickContacts::waiting
  std::vector<std::uint32_t> motionOf;  ///< index in `motions`, by index in the world's list of objects
};

/// The contacts of a candidate, found within a step.
struct ContactsInStep {
  std::vector<std::uint64_t> bearing;  ///< keys of those that have borne a load in this tick
  std::vector<TickContact> contacts;
  std::vector<std::uint32_t> newOnes;  ///< scratch: of those that no earlier search has found
};

/// Adds each body to the partners of its soft partners, and drops those that are too far away. Only one of
/// two bodies may have found the other: one that has just been thrown can be far outside the other's search
/// region. Call it after gatherContacts() of all bodies.
void shareSoftPartners(const std::vector<LinkedGroup*>& awake);

/// The contacts of surfaces of bodies with nothing near but static and kinematic objects. Such bodies are
/// searched at the same time.
class HeldPairs {
 public:
  /// Finds the contacts of those of the bodies. Call it after gatherContacts() of all bodies.
  void gather(const std::vector<SoftBodyData*>& bodies, btScalar tick, RigidSurfaces& rigids,
              ScratchPool<SurfaceSearch>& searches, const Parallel& parallel);

  /// Adds the contacts of bodies[i] to `found`. Returns false if the body was not searched.
  bool take(std::size_t i, TickContacts& found) const;

 private:
  /// What a body has found: candidates of a block, with all contacts.
  struct Entry {
    bool isSearched = false;
    std::size_t block = 0, first = 0, end = 0;
  };

  std::vector<TickContacts> blocks_;  ///< one for each range of bodies
  std::vector<Entry> entries_;        ///< #bodies
};

/// Adds to `found` the contacts of the surface of a body with Collision::Surface, now or in the coming tick:
/// with vertices, edges and triangles of dynamic rigid bodies and of other soft bodies; of its own edges and
/// triangles with static and kinematic objects. gatherContacts() finds those of its points with the latter.
/// Call it after gatherContacts() of all bodies. Pairs of soft bodies are found once.
void gatherSurfacePairs(SoftBodyData& body, btScalar tick, RigidSurfaces& rigids, SurfaceSearch& search,
                        TickContacts& found);

/// Moves pairs from found.waiting to found.candidates: those whose bodies move together, and of which one may
/// be stopped in the tick by what it hits, or by a body that is stopped. Call it after all contacts are
/// found.
void addStoppedPairs(btDispatcher& dispatcher, TickContacts& found, SurfaceSearch& search);

/// Returns the largest relative displacement of the surfaces between two searches, as a multiple of the size
/// of their features, see Stepping::searchDistance.
double searchDistanceOf(const SurfaceCandidate& candidate);

/// Returns the largest relative displacement of the surfaces in the tick, as a multiple of the size of their
/// features. It includes the predicted motion and the motion that hits stop. Of the motion that hits
/// of other bodies stop, the sum of both radii counts as searchDistanceOf() if it is smaller: the surfaces
/// must be found before they are through one another. So does the motion until a point that is set free would
/// have moved by that sum, see releasesOf().
double displacementOf(const SurfaceCandidate& candidate, double tick);

/// Returns how many searches per second (1/s) find a point before it moves by the sum of the radii, if the
/// contact that holds it against its springs ends: as it slides over an edge, other contacts must be found
/// before the springs throw it through. 0 if it moves less in the tick, if no edges touch yet, or if side b
/// is soft and yields.
double releasesOf(const SurfaceCandidate& candidate, double tick);

/// Returns the size (m) of the smaller features of the two surfaces, and the sum (m) of their radii.
double featureSizeOf(const SurfaceCandidate& candidate);
double radiusSumOf(const SurfaceCandidate& candidate);

/// Returns the combined restitution of the two surfaces, from Bullet's callback.
double restitutionOf(const SurfaceCandidate& candidate);

/// Returns whether hits and springs may cause contacts within the tick that were not predicted, and whether
/// these are to be found.
bool mayTouch(const SurfaceCandidate& candidate, double tick, SurfaceSearch& search);

/// The time of a search within a step.
struct TimeInStep {
  double since, ahead, tick;  ///< s: since the start of the tick, until the next search, length of the tick
};

/// Moves the surface of a body, or of the rigid side b of a candidate, to its place in a step, with its
/// motion until the next search. `rigid`: side b, if it is rigid and dynamic. Several bodies may be moved at
/// a time.
void moveInStep(SoftBodyData& body, const PointView& points, const TimeInStep& time);
void movePartInStep(const SurfaceCandidate& candidate, const RigidState* rigid, const TimeInStep& time);

/// Writes the contacts of a candidate whose surfaces have been moved, now and until the next search, to
/// `found`, sorted by key. Their contact points have no bodies yet. Several candidates may be searched at a
/// time.
void findContactsInStep(const SurfaceCandidate& candidate, const RigidState* rigid, const TimeInStep& time,
                        SurfaceSearch& search, ContactsInStep& found);

// --- contacts with static and kinematic objects ------------------------------------------------------------

/// Returns the features whose contacts those of the points replace: the points, and the edges on the side of
/// a cylinder into which edges and triangles sink little if their corners rest on it.
Covered coveredFeatures(const MovingSurface& soft, const RigidPart& part);

/// Returns whether a sharp edge of the part that is not covered is near the box, or the part has no edges.
/// Otherwise the contacts of the points are enough.
bool hasSharpFeatureNear(const SweptBox& box, const RigidPart& part, const Covered& covered);

/// Returns whether edges and triangles sink little into a sphere or capsule if their corners rest on it.
bool staysCloseToRound(const MovingSurface& soft, const RigidPart& part);

/// Returns whether a contact of an edge or triangle counts. It does not if contacts of its corners, whose
/// gaps are at most `margin` (m) larger, replace it, or on a round part those that its corners would have;
/// nor if other objects cover the touched edge or corner of the part: they are nearer to the soft body, or
/// flush with the edge or corner.
bool isHeldContact(const SurfaceCandidate& m, const SurfaceContact& c, double margin, SurfaceSearch& s);

/// Sets the side b of a contact with a static or kinematic part, whose `motion` is that of `seconds`.
void setHeldSide(const SurfaceCandidate& m, const SurfaceContact& c, double seconds, double tick,
                 Contact& contact);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

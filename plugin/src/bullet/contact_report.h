// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/bullet_objects.h"

#include <limber/soft_contact.h>

#include <cstddef>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;
struct TickContacts;

/// What a body tells of its contacts in the last tick in which it was awake.
struct ContactReport {
  std::vector<SoftContact> contacts;
  std::vector<PartnerMark> partners;  ///< #contacts, their others
  std::size_t rows = 0, known = 0;    ///< the first are of points on what is held, by point; up to known
                                      ///< those found by us, the others by Bullet
  bool fresh = false;                 ///< of the last tick
  bool hasTriangles = false;          ///< ContactSide::triangle is up to date
};

/// After a tick of that length (s), before reportContactImpulses(): fills the reports of all bodies of a
/// system that are awake. `bodies`: those in its groups, which `pairs` names by their index.
void reportContacts(const std::vector<SoftBodyData*>& bodies, const TickContacts& pairs,
                    const btDiscreteDynamicsWorld& world, double tick);

/// Forgets contacts with what has left the world since, or all if the body itself has.
void dropGone(SoftBodyData& body);

/// The contacts with their triangles.
const std::vector<SoftContact>& readReport(SoftBodyData& body);

/// Finds the triangle of a contact's sides.
void findTriangles(SoftContact& contact);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

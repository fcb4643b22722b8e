// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

#include <limber/soft_contact.h>

#include <cstddef>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct TickContacts;

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

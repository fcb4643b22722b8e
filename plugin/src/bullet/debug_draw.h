// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"
#include "bullet/tick_group.h"

class btIDebugDraw;

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// What the drawer's mode asks for of a body: springs coloured by strain and pinned points (wireframe), its
/// box (AABB), what it touches (contact points), its anchors (constraints).
void debugDraw(SoftBodyData& body, btIDebugDraw& drawer);

/// Springs that were added one by one (constraints).
void debugDraw(const SpringList& springs, btIDebugDraw& drawer);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This header declares how a body is saved in Bullet's files. SoftBody and SoftBodySystem have the other
// functions of saved_state.cpp.

#pragma once

#include "bullet/soft_body_data.h"

class btSerializer;

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Writes a chunk that has the body's network, settings and state.
void writeChunk(SoftBodyData& body, btSerializer& serializer);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

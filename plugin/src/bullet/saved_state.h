// SPDX-License-Identifier: Zlib

// This header declares how the state of a body is saved and restored. SoftBody::saveState() says what it
// contains.

#pragma once

#include "bullet/soft_body_data.h"

#include <limber/result.h>

#include <cstdint>
#include <vector>

class btSerializer;

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

std::vector<std::uint8_t> saveStateOf(SoftBodyData& body);
Result<void> restoreStateOf(SoftBodyData& body, const std::vector<std::uint8_t>& bytes);

/// Returns the settings in a saved state. Errors: bytes that are no such state.
Result<SoftBodySettings> settingsIn(const std::vector<std::uint8_t>& bytes);

/// Returns the errors of restoreStateOf(), without changing anything.
Result<void> checkStateFor(SoftBodyData& body, const std::vector<std::uint8_t>& bytes);

/// Writes a chunk that has the body's network, settings and state to one of Bullet's files.
void writeChunk(SoftBodyData& body, btSerializer& serializer);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

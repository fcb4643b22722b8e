// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/braced_piece.h"

namespace limber {

/// Chords through the body: from each point that no such chord ends in yet, along its inward normal to where
/// that meets the surface again, to the nearest corner there whose chord stays inside. They keep opposite
/// walls apart, which no spring within the surface does.
void addAntipodalBraces(BracedPiece& piece);

}  // namespace limber

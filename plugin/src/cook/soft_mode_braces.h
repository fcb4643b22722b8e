// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/braced_piece.h"

namespace limber {

/// The ratio of the eigenvalues of the softest and the stiffest oscillation that braces aim at.
constexpr double kLeastModeRatio = 1e-3;

/// Braces mechanisms and soft oscillations, each time the pairs that the softest ones stretch most, until
/// kLeastModeRatio is reached, the piece is full, or nothing inside the body helps.
void addSoftModeBraces(BracedPiece& piece, std::uint64_t seed, const GoOn& goOn);

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/braced_piece.h"

namespace limber {

/// The ratio of the eigenvalues of the softest and the stiffest oscillation that braces aim at: 1e-3, and
/// less for many points, by as much as that of a solid ball falls.
double leastModeRatio(std::size_t points);

/// Braces mechanisms and soft oscillations, each time the pairs that the softest ones stretch most, until
/// leastModeRatio() is reached, the piece is full, or nothing inside the body helps.
/// `most`: braces that the piece then has at most, of those that it may get.
void addSoftModeBraces(BracedPiece& piece, std::size_t most, std::uint64_t seed, const GoOn& goOn);

}  // namespace limber

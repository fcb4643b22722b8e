// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/braced_piece.h"

namespace limber {

/// Counterexample-guided insertion: lets the piece go from large random deformations and braces the wrong
/// shapes it comes to rest in, until it has come back from all of them in several rounds in a row, or is
/// full. A spring that has its rest length in a wrong shape does nothing against it; the pair whose distance
/// is most wrong there does most.
void addCounterexampleBraces(BracedPiece& piece, std::uint64_t seed, const GoOn& goOn);

}  // namespace limber

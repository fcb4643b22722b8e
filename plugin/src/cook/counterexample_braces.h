// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/inside_chords.h"

#include <limber/network_builder.h>
#include <limber/spring_network.h>

#include <functional>

namespace limber {

/// Adds a brace to the network, in the order of its springs.
void addBrace(SpringNetwork& network, const Edge& pair, double weight);

struct CounterexampleSettings {
  double weight = 0.3;         ///< stiffnessScale of a brace
  std::size_t mostBraces = 0;  ///< in all that the network may have
  std::uint64_t seed = 1;
  std::function<bool(double)> goOn;  ///< told 0 to 1, how far it is; false: end early
};

/// Counterexample-guided insertion: lets the body go from large random deformations and braces the wrong
/// shapes it comes to rest in, until it has come back from all of them in five rounds in a row.
void braceCounterexamples(SpringNetwork& network, InsideChords& chords,
                          const CounterexampleSettings& settings);

}  // namespace limber

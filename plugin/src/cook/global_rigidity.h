// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <cstdint>
#include <functional>

namespace limber {

/// More points than this take longer than seconds.
constexpr std::size_t kMostForGlobalRigidity = 1000;

/// Whether the graph of the springs is generically globally rigid in space: of all places of the points with
/// these spring lengths there is but one up to rigid motions and reflections, unless the points are in
/// special position. Then, and only then, is the rank of a random equilibrium stress matrix of a random
/// placement #points - 4 (Gortler, Healy, Thurston 2010, theorem 1.14 and section 5; graphs of at most 4
/// points: when all are joined). Computed in a finite field, where ranks are exact: a yes is certain, a no
/// wrong with a probability of less than 1e-5. Up to kMostForGlobalRigidity points.
/// Once `goOn`, asked with the share done, 0 to 1, says no, the answer means nothing.
bool isGloballyRigid(const SpringNetwork& network, std::uint64_t seed = 1,
                     const std::function<bool(double)>& goOn = {});

}  // namespace limber

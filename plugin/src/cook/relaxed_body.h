// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/body_terms.h"
#include "solver/point_state.h"

#include <limber/spring_network.h>

#include <vector>

namespace limber {

/// A body of a network as relaxations see it: of size 1, unit masses, each spring's constant its
/// stiffnessScale, with the volume term that a body of it has by default.
struct RelaxedBody {
  Points rest;  ///< the rest points over the size
  BodyTerms terms;
  std::vector<std::vector<Eigen::Index>> pieces;  ///< points that springs hold together

  explicit RelaxedBody(const SpringNetwork& network);
};

/// A run whose distanceToRest() is below this has returned.
constexpr double kReturned = 1e-3;

/// Root mean square distance of the points to the rest points after the best rigid motion of each piece,
/// without reflection (Kabsch 1976).
double distanceToRest(const RelaxedBody& body, const Points& x);

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <Eigen/Core>

#include <vector>

namespace limber {

/// The points of each piece that springs hold together, ascending; pieces in the order of their first points.
std::vector<std::vector<Eigen::Index>> findPieces(const SpringNetwork& network);

/// These points and what joins no others, with shares of the mass that sum to 1. Its report says how whole
/// the surface is that comes along; it has no render surface.
SpringNetwork pieceOf(const SpringNetwork& network, const std::vector<Eigen::Index>& points);

}  // namespace limber

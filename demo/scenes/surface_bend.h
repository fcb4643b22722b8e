// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

namespace limber::scenes {

/// Surfaces that bend less than this at every edge look best shaded as smooth ones: 60 degrees.
constexpr double kSmoothBend = 1.0472;

/// Radians: the largest angle between the normals of two triangles with a common edge, at rest.
double sharpestBend(const SpringNetwork& network);

}  // namespace limber::scenes

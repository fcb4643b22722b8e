// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/spring_network.h>

#include <string>

namespace limber::scenes {

/// True if the file's name ends in ".limber": a body that has been cooked.
bool isLimberFile(const std::string& file);

/// A cooked body as it is, or the network of a mesh with the library's own settings. Errors name the file.
Result<SharedNetwork> readNetwork(const std::string& file);

/// Surfaces that bend less than this at every edge look best shaded as smooth ones: 60 degrees.
constexpr double kSmoothBend = 1.0472;

/// Radians: the largest angle between the normals of two triangles with a common edge, at rest.
double sharpestBend(const SpringNetwork& network);

}  // namespace limber::scenes

// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/cook.h>
#include <limber/network_builder.h>
#include <limber/result.h>
#include <limber/spring_network.h>

#include <string>

namespace limber::scenes {

/// Returns true if the file's name ends in ".limber": a cooked body.
bool isLimberFile(const std::string& file);

/// Builds the network of the demo's cube: 8 points, edges of 1 m. Errors name the file.
Result<SharedNetwork> cubeNetwork(BraceRule braces = BraceRule::Pipeline);

/// Surfaces with smaller angles at all edges look best with smooth shading: 60 degrees in radians.
constexpr double kSmoothBend = 1.0472;

/// Returns the largest angle at rest between the normals of two triangles with a common edge, radians.
double sharpestBend(const SpringNetwork& network);

/// Returns the angle that nine tenths of the edges do not exceed, radians: scanned and modelled meshes have a
/// few sharp edges by fault.
double usualBend(const SpringNetwork& network);

/// Returns the bodies of a file: those of a .limber file, or of a mesh that is cooked. Cooked bodies are kept
/// in the folder `cache` under a hash of the mesh and the settings, and read from there the next time; empty:
/// no cache. A cache that cannot be read or written costs time, but is no error. Errors name the file.
Result<CookedMesh> readBodies(const std::string& file, const CookSettings& settings,
                              const std::string& cache);

}  // namespace limber::scenes

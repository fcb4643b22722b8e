// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/cook.h>
#include <limber/result.h>

#include <string>

namespace limber::scenes {

/// Returns the bodies of a file: those of a .limber file, or of a mesh that is cooked. Cooked bodies are kept
/// in the folder `cache` under a hash of the mesh and the settings, and read from there the next time; empty:
/// no cache. A cache that cannot be read or written costs time, but is no error. Errors name the file.
Result<CookedMesh> readBodies(const std::string& file, const CookSettings& settings,
                              const std::string& cache);

}  // namespace limber::scenes

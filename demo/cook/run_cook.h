// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/cook_options.h"

#include <limber/result.h>
#include <limber/spring_network.h>

namespace limber::demo {

/// The body that the options ask for. Errors begin with the mesh file's name.
Result<SharedNetwork> cookBody(const CookOptions& options);

/// Cooks or loads the body, then writes, draws and prints what the options ask for. Reasons of failure go to
/// the standard error stream. Whatever fails: every file is written whole or stays as it was.
ExitCode runCook(const CookOptions& options);

}  // namespace limber::demo

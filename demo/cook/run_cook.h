// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/cook_options.h"

#include <limber/result.h>
#include <limber/spring_network.h>

namespace limber::demo {

/// Makes the body that the options describe. Errors begin with the mesh file's name.
Result<SharedNetwork> cookBody(const CookOptions& options);

/// Cooks or loads the body, then writes, draws and prints the output chosen by the options. Errors go to the
/// standard error stream. After any failure, each file is either complete or unchanged.
ExitCode runCook(const CookOptions& options);

}  // namespace limber::demo

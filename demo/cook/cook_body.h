// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/cook_options.h"

#include <limber/result.h>
#include <limber/spring_network.h>

namespace limber::demo {

/// The body that the options ask for. Errors begin with the mesh file's name.
Result<SharedNetwork> cookBody(const CookOptions& options);

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/cook_options.h"

namespace limber::demo {

/// Cooks or loads the body, then writes, draws and prints what the options ask for. Reasons of failure go to
/// the standard error stream. Whatever fails: every file is written whole or stays as it was.
ExitCode runCook(const CookOptions& options);

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#pragma once

#include "bench.h"
#include "results.h"

namespace limber::bench {

// Parts of the networks bench, see properties.cpp.

void measureMasses(const Options& options, Results& results);
void measureSkins(const Options& options, Results& results);
void measureMaterials(const Options& options, Results& results);

}  // namespace limber::bench

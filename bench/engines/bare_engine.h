// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

namespace limber::bench {

/// Plain Bullet with a separate sphere for each point, of its mass, radius and friction and without rotation:
/// Bullet's own cost of so many bodies. There are no springs.
std::unique_ptr<Engine> makeBareEngine();

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

#include <limber/result.h>

#include <memory>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A body at its starting place, not yet in a world. Errors as SoftBodySystem::createBody.
Result<std::unique_ptr<SoftBodyData>> makeBodyData(SharedNetwork network, const SoftBodySettings& settings);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

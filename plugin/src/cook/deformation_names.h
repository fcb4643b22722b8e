// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_analysis.h>

#include <array>

namespace limber {

/// In the order of Deformation.
constexpr std::array<const char*, kDeformations> kDeformationNames{"squash", "twist",   "noise",    "push",
                                                                   "mirror", "flatten", "inversion"};

}  // namespace limber

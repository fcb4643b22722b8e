// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace limber {

/// What would keep assimp busy for ever (seen in 5.2): a PLY header without an end, or with counts of
/// elements that the file cannot hold. Empty for sound headers and for files that are no PLY.
std::string checkPlyHeader(const std::string& path);

}  // namespace limber

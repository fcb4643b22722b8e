// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace limber::bench {

/// Makes the folder if need be and tries to write the named file in it. Returns the reason why that cannot be
/// done, or an empty string.
std::string prepareOutput(const std::string& folder, const std::string& fileName);

}  // namespace limber::bench

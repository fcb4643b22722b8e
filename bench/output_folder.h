// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace limber::bench {

/// Makes the folder if need be and looks whether the named file can be written in it. Returns the reason why
/// not, or an empty string.
std::string prepareOutput(const std::string& folder, const std::string& fileName);

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace limber::demo {

/// Why no file can be made there (no such folder, no permission, a folder itself), or an empty string. Makes
/// and changes nothing.
std::string checkPlace(const std::string& file);

/// Writes a text under a temporary name and renames it, so that there is never half a file; what is no
/// regular file, as /dev/stdout, is written to as it is. Empty when written, else the reason.
std::string writeText(const std::string& file, const std::string& text);

}  // namespace limber::demo

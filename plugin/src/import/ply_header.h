// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace limber {

/// Checks the header of a PLY file more strictly than assimp, which reads for ever or crashes after some
/// damaged ones (seen in 5.2): a header without an end, counts of elements that the file cannot hold, and
/// faces that have texture coordinates but no vertex indices. Returns the reason why the header is invalid.
/// Returns an empty string for valid headers and for files that are not PLY. Throws the exceptions of
/// std::filesystem.
std::string checkPlyHeader(const std::string& path);

}  // namespace limber

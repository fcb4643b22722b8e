// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

namespace limber::demo {

constexpr const char* kContactSheetName = "contact-sheet.png";
constexpr const char* kVideoName = "video.mp4";

/// "frame-0042.png".
std::string frameName(std::int64_t i);

/// Makes the folder if need be, removes the pictures of an earlier run from it (files named as ours, nothing
/// else) and tries to write into it. Returns the reason why it cannot be used, or an empty string.
std::string prepareFolder(const std::string& folder);

/// Tries to write to a file, without changing it. Returns the reason, or an empty string.
std::string checkWritable(const std::string& file);

}  // namespace limber::demo

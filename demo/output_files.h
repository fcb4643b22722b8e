// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

namespace limber::demo {

/// Why no file can be made there (no such folder, no permission, a folder itself), or an empty string. Makes
/// and changes nothing.
std::string checkPlace(const std::string& file);

/// Writes a text under a temporary name and renames it, so that there is never half a file; what is no
/// regular file, as /dev/stdout, is written to as it is. Empty when written, else the reason.
std::string writeText(const std::string& file, const std::string& text);

constexpr const char* kContactSheetName = "contact-sheet.png";
constexpr const char* kPreviewName = "preview.png";
constexpr const char* kVideoName = "video.mp4";

/// "frame-0042.png".
std::string frameName(std::int64_t i);

/// Makes the folder if need be, removes the pictures of an earlier run from it (files named as ours, nothing
/// else) and looks whether it may be written to. Returns the reason why it cannot be used, or an empty
/// string.
std::string prepareFolder(const std::string& folder);

}  // namespace limber::demo

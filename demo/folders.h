// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

namespace limber::demo {

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

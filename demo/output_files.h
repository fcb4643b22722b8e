// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

namespace limber::demo {

/// Returns the reason why the file cannot be written (no such folder, no permission, it is a folder), or an
/// empty string. Creates and changes nothing.
std::string checkWritable(const std::string& file);

/// Writes a text under a temporary name and renames it, so that there is never an incomplete file. A file
/// that is not regular, such as /dev/stdout, is written directly. Returns the reason of a failure, or an
/// empty string.
std::string writeText(const std::string& file, const std::string& text);

/// Returns a hash in 16 hexadecimal digits.
std::string hashText(std::uint64_t hash);

constexpr const char* kContactSheetName = "contact-sheet.png";
constexpr const char* kPreviewName = "preview.png";
constexpr const char* kVideoName = "video.mp4";

/// "frame-0042.png".
std::string frameName(std::int64_t i);

/// Creates the folder if it is missing, removes the pictures of an earlier run from it (only files with our
/// names) and checks that it can be written to. Returns the reason why it cannot be used, or an empty string.
std::string prepareFolder(const std::string& folder);

}  // namespace limber::demo

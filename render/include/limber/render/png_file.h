// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/image.h"

#include <string>

namespace limber::render {

/// Writes to a temporary name beside `path` and renames, so that no half file is ever seen.
/// Fast rather than small (zlib level 1, no filter). Throws std::runtime_error naming the path
/// and the reason (no such folder, no permission, disk full, ...).
void writePng(const std::string& path, const Image& image);

/// Reads any PNG as RGBA. Throws std::runtime_error naming the path and the reason.
Image readPng(const std::string& path);

}  // namespace limber::render

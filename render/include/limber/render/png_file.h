// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/image.h"

#include <string>

namespace limber::render {

/// Writes a temporary file next to `path` and renames it, so that `path` is never an incomplete file. Fast
/// rather than small; opaque images have 3 bytes a pixel. Throws std::runtime_error with the path and the
/// reason (no such folder, no permission, disk full, ...).
void writePng(const std::string& path, const Image& image);

/// Reads any PNG as RGBA. Throws std::runtime_error with the path and the reason.
Image readPng(const std::string& path);

}  // namespace limber::render

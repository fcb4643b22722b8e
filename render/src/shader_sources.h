// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <string_view>

namespace limber::render {

/// Text of a file of the shaders folder, compiled into the library.
const char* shaderSource(std::string_view name);

}  // namespace limber::render

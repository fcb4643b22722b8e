// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/gl_context.h"

namespace limber::render {

/// Each makes a context that is not yet current, or throws std::runtime_error with the reason.
std::unique_ptr<GlContext> createOsmesaContext();
std::unique_ptr<GlContext> createEglContext(const ContextDesc& desc);
/// Only on devices that are no software rasterisers.
std::unique_ptr<GlContext> createEglGpuContext(const ContextDesc& desc);

}  // namespace limber::render

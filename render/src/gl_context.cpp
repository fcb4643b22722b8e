// SPDX-License-Identifier: Zlib
#include "limber/render/gl_context.h"

#include <stdexcept>
#include <vector>

#include "context_backends.h"

namespace limber::render {
namespace {

struct Try {
  const char* name;
  std::unique_ptr<GlContext> (*create)(const ContextDesc& desc);
};

// Hardware first. Where there is none OSMesa comes before EGL: both then draw with the same rasteriser,
// and EGL needs some more libraries.
std::vector<Try> triesFor(Backend backend) {
  const Try gpu{"EGL on a GPU", createEglGpuContext};
  const Try osmesa{"OSMesa", [](const ContextDesc&) { return createOsmesaContext(); }};
  const Try egl{"EGL", createEglContext};
  switch (backend) {
    case Backend::OSMesa:
      return {osmesa};
    case Backend::Egl:
    case Backend::EglSurfaceless:
      return {egl};
    case Backend::Auto:
      break;
  }
  return {gpu, osmesa, egl};
}

}  // namespace

std::unique_ptr<GlContext> createContext(const ContextDesc& desc) {
  std::string reasons;
  for (const Try& attempt : triesFor(desc.backend)) {
    try {
      auto context = attempt.create(desc);
      context->makeCurrent();
      return context;
    } catch (const std::runtime_error& error) {
      reasons += std::string("\n  ") + attempt.name + ": " + error.what();
    }
  }
  throw std::runtime_error("no OpenGL 4.5 core context; tried:" + reasons);
}

}  // namespace limber::render

// SPDX-License-Identifier: Zlib
#include "limber/render/gl_context.h"

#include <stdexcept>

#include "context_backends.h"

namespace limber::render {
namespace {

std::unique_ptr<GlContext> createCurrent(Backend backend, const ContextDesc& desc) {
  auto context = backend == Backend::OSMesa ? createOsmesaContext() : createEglContext(desc);
  context->makeCurrent();
  return context;
}

const char* label(Backend backend) { return backend == Backend::OSMesa ? "OSMesa" : "EGL"; }

}  // namespace

std::unique_ptr<GlContext> createContext(const ContextDesc& desc) {
  std::string reasons;
  for (Backend backend : {Backend::OSMesa, Backend::Egl}) {
    if (desc.backend != Backend::Auto && desc.backend != backend) {
      continue;
    }
    try {
      return createCurrent(backend, desc);
    } catch (const std::runtime_error& error) {
      reasons += std::string("\n  ") + label(backend) + ": " + error.what();
    }
  }
  throw std::runtime_error("no OpenGL 4.5 core context; tried:" + reasons);
}

}  // namespace limber::render

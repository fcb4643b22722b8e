// SPDX-License-Identifier: Zlib
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace limber::render {

/// The library that makes the OpenGL context. Auto tries a GPU through EGL (a device that is not marked as
/// software), then OSMesa (a software rasteriser in this process), then EGL with a software rasteriser. Egl
/// tries the devices in their order, GPUs first, and then Mesa's surfaceless platform. EglSurfaceless tries
/// only that platform.
enum class Backend { Auto, OSMesa, Egl, EglSurfaceless };

struct ContextDesc {
  Backend backend = Backend::Auto;
  bool debug = false;  ///< Requests a debug context (more messages, slower).
  int eglDevice = -1;  ///< Index among the EGL devices; -1 takes the first that works.
};

/// An OpenGL 4.5 core context without a window. The libraries are loaded at run time, so
/// neither of them is needed to link or to start the program.
///
/// Thread rule: a context is current on at most one thread. Call release() on the old thread
/// before makeCurrent() on the new one. All other OpenGL objects of this library must be used
/// and destroyed on the thread on which their context is current.
class GlContext {
 public:
  virtual ~GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Throws std::runtime_error with the library's reason.
  virtual void makeCurrent() = 0;
  virtual void release() noexcept = 0;

  /// Returns the address of an OpenGL function. OSMesa returns non-null for unknown names, too, so the OpenGL
  /// version must be checked first (see loadGl()).
  virtual void* getProcAddress(const char* name) const = 0;

  /// Returns "osmesa", "egl (...)" or the name of an adopted context.
  virtual const std::string& name() const = 0;

  /// Returns true if other code draws in this context, too. The renderer then restores all OpenGL state after
  /// use and does not receive debug messages.
  virtual bool shared() const { return false; }

 protected:
  GlContext() = default;
};

/// Makes a context and makes it current on the calling thread.
/// Throws std::runtime_error with all attempts and the reason why each of them failed.
std::unique_ptr<GlContext> createContext(const ContextDesc& desc = {});

/// Wraps a context that the program has created itself (with GLFW, SDL, Qt, an engine), OpenGL 4.5 core or
/// later, so that a renderer can share it. The program makes it current before it calls the renderer.
/// `getProcAddress` returns the addresses of OpenGL's functions, as glfwGetProcAddress does; `name` is for
/// messages.
std::unique_ptr<GlContext> adoptContext(std::function<void*(const char*)> getProcAddress,
                                        std::string name = "the program's own");

}  // namespace limber::render

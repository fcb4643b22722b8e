// SPDX-License-Identifier: Zlib
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace limber::render {

/// Which library makes the OpenGL context. Auto tries a GPU through EGL (a device that does not call
/// itself software), then OSMesa (a software rasteriser in this process), then EGL in software. Egl tries
/// the devices in their order, GPUs first, then Mesa's platform without any surface; EglSurfaceless that
/// alone.
enum class Backend { Auto, OSMesa, Egl, EglSurfaceless };

struct ContextDesc {
  Backend backend = Backend::Auto;
  bool debug = false;  ///< Ask the driver for a debug context (more messages, slower).
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

  /// Address of an OpenGL function. OSMesa answers non-null for unknown names too, so the
  /// version must be checked before anything is concluded from this (see Gl).
  virtual void* getProcAddress(const char* name) const = 0;

  /// "osmesa", "egl (...)", or what an adopted context was called.
  virtual const std::string& name() const = 0;

  /// Whether others draw in it as well: the renderer then leaves all state as it found it, and the debug
  /// messages to them.
  virtual bool shared() const { return false; }

 protected:
  GlContext() = default;
};

/// Makes a context and makes it current on the calling thread.
/// Throws std::runtime_error naming everything that was tried and why each try failed.
std::unique_ptr<GlContext> createContext(const ContextDesc& desc = {});

/// A context that the program has made by itself (GLFW, SDL, Qt, an engine), OpenGL 4.5 core or later, for
/// a renderer to share: it is the program that makes it current before it calls the renderer.
/// `getProcAddress` finds OpenGL's functions, as glfwGetProcAddress does; `name` is for messages.
std::unique_ptr<GlContext> adoptContext(std::function<void*(const char*)> getProcAddress,
                                        std::string name = "the program's own");

}  // namespace limber::render

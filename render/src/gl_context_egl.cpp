// SPDX-License-Identifier: Zlib
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "context_backends.h"
#include "shared_library.h"

namespace limber::render {
namespace {

// X(member, EGL name, function type)
#define LIMBER_EGL_FUNCTIONS(X)                                    \
  X(bindApi, "eglBindAPI", PFNEGLBINDAPIPROC)                      \
  X(createContext, "eglCreateContext", PFNEGLCREATECONTEXTPROC)    \
  X(destroyContext, "eglDestroyContext", PFNEGLDESTROYCONTEXTPROC) \
  X(getError, "eglGetError", PFNEGLGETERRORPROC)                   \
  X(getProc, "eglGetProcAddress", PFNEGLGETPROCADDRESSPROC)        \
  X(initialize, "eglInitialize", PFNEGLINITIALIZEPROC)             \
  X(makeCurrent, "eglMakeCurrent", PFNEGLMAKECURRENTPROC)

struct Egl {
  SharedLibrary library{{"libEGL.so.1", "libEGL.so"}};
#define LIMBER_EGL_MEMBER(member, name, Type) Type member = library.function<Type>(name);
  LIMBER_EGL_FUNCTIONS(LIMBER_EGL_MEMBER)
#undef LIMBER_EGL_MEMBER

  /// Null if the extension is absent.
  template <typename Function>
  Function extension(const char* name) const {
    return reinterpret_cast<Function>(getProc(name));
  }
  std::string error(const char* call) const {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%s failed (0x%x)", call, static_cast<unsigned>(getError()));
    return text.data();
  }
};

struct Platform {
  EGLenum kind;
  void* native;
  std::string name;
  bool software;
};

// Drivers that do not say are hardware's: Mesa marks its own rasterisers.
bool isSoftware(const Egl& egl, EGLDeviceEXT device) {
  const auto query = egl.extension<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  const char* extensions = query == nullptr ? nullptr : query(device, EGL_EXTENSIONS);
  return extensions != nullptr && std::strstr(extensions, "EGL_MESA_device_software") != nullptr;
}

// Devices come first: they reach the GPU of drivers that lack Mesa's surfaceless platform.
std::vector<Platform> listDevices(const Egl& egl, int wantedDevice) {
  std::vector<Platform> platforms;
  std::array<EGLDeviceEXT, 32> devices{};
  EGLint count = 0;
  const auto query = egl.extension<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  if (query != nullptr && query(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_TRUE) {
    for (int i = 0; i < count; ++i) {
      if (wantedDevice < 0 || wantedDevice == i) {
        const EGLDeviceEXT device = devices[static_cast<std::size_t>(i)];
        platforms.push_back(
            {EGL_PLATFORM_DEVICE_EXT, device, "device " + std::to_string(i), isSoftware(egl, device)});
      }
    }
  }
  return platforms;
}

std::vector<Platform> listPlatforms(const Egl& egl, const ContextDesc& desc) {
  const bool surfacelessOnly = desc.backend == Backend::EglSurfaceless;
  std::vector<Platform> platforms =
      surfacelessOnly ? std::vector<Platform>() : listDevices(egl, desc.eglDevice);
  if (surfacelessOnly || desc.eglDevice < 0) {
    platforms.push_back({EGL_PLATFORM_SURFACELESS_MESA, nullptr, "surfaceless", true});
  }
  std::stable_sort(platforms.begin(), platforms.end(),
                   [](const Platform& x, const Platform& y) { return !x.software && y.software; });
  return platforms;
}

class EglGlContext final : public GlContext {
 public:
  EglGlContext(Egl egl, const Platform& platform, bool debug)
      : egl_(std::move(egl)), name_("egl (" + platform.name + ")") {
    const auto getDisplay = egl_.extension<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    if (getDisplay == nullptr) {
      throw std::runtime_error("eglGetPlatformDisplayEXT is missing");
    }
    display_ = getDisplay(platform.kind, platform.native, nullptr);
    require(display_ != EGL_NO_DISPLAY, "eglGetPlatformDisplay");
    require(egl_.initialize(display_, nullptr, nullptr) == EGL_TRUE, "eglInitialize");
    require(egl_.bindApi(EGL_OPENGL_API) == EGL_TRUE, "eglBindAPI");
    const std::array<EGLint, 9> attributes{EGL_CONTEXT_MAJOR_VERSION,
                                           4,
                                           EGL_CONTEXT_MINOR_VERSION,
                                           5,
                                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                           EGL_CONTEXT_OPENGL_DEBUG,
                                           debug ? EGL_TRUE : EGL_FALSE,
                                           EGL_NONE};
    context_ = egl_.createContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    require(context_ != EGL_NO_CONTEXT, "eglCreateContext");
  }

  // The display stays initialised: it is shared by everything in the process that uses EGL.
  ~EglGlContext() override {
    release();
    egl_.destroyContext(display_, context_);
  }

  void makeCurrent() override {
    require(egl_.bindApi(EGL_OPENGL_API) == EGL_TRUE, "eglBindAPI");
    require(egl_.makeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE,
            "eglMakeCurrent");
  }

  void release() noexcept override {
    egl_.makeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  void* getProcAddress(const char* name) const override {
    return reinterpret_cast<void*>(egl_.getProc(name));
  }
  const std::string& name() const override { return name_; }

 private:
  void require(bool ok, const char* call) const {
    if (!ok) {
      throw std::runtime_error(egl_.error(call));
    }
  }

  Egl egl_;
  std::string name_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

// A GPU's device whose driver is not there may end in a rasteriser all the same.
void requireHardware(const GlContext& context, bool wanted) {
  if (!wanted) {
    return;
  }
  const auto getString = reinterpret_cast<PFNGLGETSTRINGPROC>(context.getProcAddress("glGetString"));
  const auto* text = getString == nullptr ? nullptr : reinterpret_cast<const char*>(getString(GL_RENDERER));
  const std::string driver = text == nullptr ? "" : text;
  for (const char* software : {"llvmpipe", "softpipe", "swrast", "Software"}) {
    if (driver.find(software) != std::string::npos) {
      throw std::runtime_error("this is a software rasteriser: " + driver);
    }
  }
}

std::unique_ptr<GlContext> createOn(const ContextDesc& desc, bool onlyHardware) {
  const Egl egl;
  std::string reasons;
  for (const Platform& platform : listPlatforms(egl, desc)) {
    if (onlyHardware && platform.software) {
      continue;
    }
    try {
      auto context = std::make_unique<EglGlContext>(egl, platform, desc.debug);
      context->makeCurrent();
      requireHardware(*context, onlyHardware);
      return context;
    } catch (const std::runtime_error& error) {
      reasons += (reasons.empty() ? "" : "; ") + platform.name + ": " + error.what();
    }
  }
  throw std::runtime_error(reasons.empty() ? "no such EGL device" : reasons);
}

}  // namespace

std::unique_ptr<GlContext> createEglContext(const ContextDesc& desc) { return createOn(desc, false); }
std::unique_ptr<GlContext> createEglGpuContext(const ContextDesc& desc) { return createOn(desc, true); }

}  // namespace limber::render

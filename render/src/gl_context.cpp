// SPDX-License-Identifier: Zlib
#include "limber/render/gl_context.h"

#include "limber/render/gl_functions.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>
#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace limber::render {

namespace {

/// A library opened at run time. It is never closed: the drivers register exit handlers and threads that
/// would fail after unloading.
class SharedLibrary {
 public:
  /// Opens the first of `names` that can be opened. Throws std::runtime_error with all reasons.
  explicit SharedLibrary(const std::vector<std::string>& names) {
    std::string reasons;
    for (const std::string& name : names) {
      handle_ = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
      if (handle_ != nullptr) {
        name_ = name;
        return;
      }
      reasons += (reasons.empty() ? "" : "; ") + std::string(dlerror());
    }
    throw std::runtime_error(reasons);
  }

  /// Throws std::runtime_error if there is no such symbol.
  template <typename Function>
  Function function(const char* symbol) const {
    void* found = dlsym(handle_, symbol);
    if (found == nullptr) {
      throw std::runtime_error(name_ + " has no function " + symbol);
    }
    return reinterpret_cast<Function>(found);
  }

 private:
  void* handle_ = nullptr;
  std::string name_;
};

// OSMesa's header needs its development package, so the needed part of its stable ABI is declared here.
using OsmesaContext = void*;
using OsmesaCreate = OsmesaContext (*)(const int*, OsmesaContext);
using OsmesaDestroy = void (*)(OsmesaContext);
using OsmesaMakeCurrent = unsigned char (*)(OsmesaContext, void*, unsigned, int, int);
using OsmesaGetProc = void* (*)(const char*);

constexpr int kFormat = 0x22;
constexpr int kRgba = 0x1908;
constexpr int kProfile = 0x33;
constexpr int kCoreProfile = 0x34;
constexpr int kMajorVersion = 0x36;
constexpr int kMinorVersion = 0x37;
constexpr unsigned kUnsignedByte = 0x1401;
constexpr int kSurfaceSize = 4;

class OsmesaGlContext final : public GlContext {
 public:
  OsmesaGlContext()
      : library_({"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}),
        destroy_(library_.function<OsmesaDestroy>("OSMesaDestroyContext")),
        makeCurrent_(library_.function<OsmesaMakeCurrent>("OSMesaMakeCurrent")),
        getProc_(library_.function<OsmesaGetProc>("OSMesaGetProcAddress")) {
    const std::array<int, 9> attributes{kFormat,       kRgba, kProfile, kCoreProfile, kMajorVersion, 4,
                                        kMinorVersion, 5,     0};
    context_ = library_.function<OsmesaCreate>("OSMesaCreateContextAttribs")(attributes.data(), nullptr);
    if (context_ == nullptr) {
      throw std::runtime_error("OSMesaCreateContextAttribs refused an OpenGL 4.5 core context");
    }
  }

  ~OsmesaGlContext() override { destroy_(context_); }

  void makeCurrent() override {
    if (makeCurrent_(context_, surface_.data(), kUnsignedByte, kSurfaceSize, kSurfaceSize) == 0) {
      throw std::runtime_error("OSMesaMakeCurrent failed");
    }
  }

  void release() noexcept override { makeCurrent_(nullptr, nullptr, 0, 0, 0); }
  void* getProcAddress(const char* name) const override { return getProc_(name); }
  const std::string& name() const override { return name_; }

 private:
  SharedLibrary library_;
  OsmesaDestroy destroy_;
  OsmesaMakeCurrent makeCurrent_;
  OsmesaGetProc getProc_;
  OsmesaContext context_ = nullptr;
  std::string name_ = "osmesa";
  // OSMesa requires a default framebuffer; nothing is drawn into it.
  std::array<unsigned char, 4 * kSurfaceSize * kSurfaceSize> surface_{};
};

// X(member, EGL name, function type)
#define LIMBER_EGL_FUNCTIONS(X)                                      \
  X(bindApi, "eglBindAPI", PFNEGLBINDAPIPROC)                        \
  X(createContext, "eglCreateContext", PFNEGLCREATECONTEXTPROC)      \
  X(destroyContext, "eglDestroyContext", PFNEGLDESTROYCONTEXTPROC)   \
  X(getCurrent, "eglGetCurrentContext", PFNEGLGETCURRENTCONTEXTPROC) \
  X(getError, "eglGetError", PFNEGLGETERRORPROC)                     \
  X(getProc, "eglGetProcAddress", PFNEGLGETPROCADDRESSPROC)          \
  X(initialize, "eglInitialize", PFNEGLINITIALIZEPROC)               \
  X(makeCurrent, "eglMakeCurrent", PFNEGLMAKECURRENTPROC)

struct Egl {
  SharedLibrary library{{"libEGL.so.1", "libEGL.so"}};
#define LIMBER_EGL_MEMBER(member, name, Type) Type member = library.function<Type>(name);
  LIMBER_EGL_FUNCTIONS(LIMBER_EGL_MEMBER)
#undef LIMBER_EGL_MEMBER

  /// Returns null if the extension is absent.
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

// Mesa marks its software rasterisers; a device without that mark counts as hardware.
bool isSoftware(const Egl& egl, EGLDeviceEXT device) {
  const auto query = egl.extension<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  const char* extensions = query == nullptr ? nullptr : query(device, EGL_EXTENSIONS);
  return extensions != nullptr && std::strstr(extensions, "EGL_MESA_device_software") != nullptr;
}

// Devices work with drivers that do not have Mesa's surfaceless platform.
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

  // The display stays initialised, because all users of EGL in this process share it.
  ~EglGlContext() override {
    if (egl_.getCurrent() == context_) {
      release();
    }
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

// Throws if a software rasteriser draws: that happens for a GPU without a driver.
void requireHardware(const GlContext& context, bool wanted) {
  if (!wanted) {
    return;
  }
  const auto getString = reinterpret_cast<PFNGLGETSTRINGPROC>(context.getProcAddress("glGetString"));
  const auto* text = getString == nullptr ? nullptr : reinterpret_cast<const char*>(getString(GL_RENDERER));
  const std::string driver = text == nullptr ? "" : text;
  if (isSoftwareRasteriser(driver)) {
    throw std::runtime_error("this is a software rasteriser: " + driver);
  }
}

std::unique_ptr<GlContext> createEgl(const ContextDesc& desc, bool onlyHardware) {
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

class AdoptedGlContext final : public GlContext {
 public:
  AdoptedGlContext(std::function<void*(const char*)> getProcAddress, std::string name)
      : getProcAddress_(std::move(getProcAddress)), name_(std::move(name)) {}

  void makeCurrent() override {}
  void release() noexcept override {}
  void* getProcAddress(const char* name) const override { return getProcAddress_(name); }
  const std::string& name() const override { return name_; }
  bool shared() const override { return true; }

 private:
  std::function<void*(const char*)> getProcAddress_;
  std::string name_;
};

}  // namespace

std::unique_ptr<GlContext> adoptContext(std::function<void*(const char*)> getProcAddress, std::string name) {
  if (!getProcAddress) {
    throw std::runtime_error("adoptContext: there is no function that finds OpenGL's functions");
  }
  return std::make_unique<AdoptedGlContext>(std::move(getProcAddress), std::move(name));
}

namespace {

struct Attempt {
  const char* name;
  std::unique_ptr<GlContext> (*create)(const ContextDesc& desc);
};

// Hardware comes first. Without it OSMesa comes before EGL: both draw with the same rasteriser, and EGL needs
// more libraries.
std::vector<Attempt> attemptsFor(Backend backend) {
  const Attempt gpu{"EGL on a GPU", [](const ContextDesc& desc) { return createEgl(desc, true); }};
  const Attempt osmesa{"OSMesa", [](const ContextDesc&) -> std::unique_ptr<GlContext> {
                         return std::make_unique<OsmesaGlContext>();
                       }};
  const Attempt egl{"EGL", [](const ContextDesc& desc) { return createEgl(desc, false); }};
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
  for (const Attempt& attempt : attemptsFor(desc.backend)) {
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

// SPDX-License-Identifier: Zlib
#include <array>
#include <stdexcept>

#include "context_backends.h"
#include "shared_library.h"

namespace limber::render {
namespace {

// OSMesa's header exists only where its development package does, so what we need of its stable
// ABI is written down here.
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
  // OSMesa insists on a default framebuffer; nothing is ever drawn into it.
  std::array<unsigned char, 4 * kSurfaceSize * kSurfaceSize> surface_{};
};

}  // namespace

std::unique_ptr<GlContext> createOsmesaContext() { return std::make_unique<OsmesaGlContext>(); }

}  // namespace limber::render

// SPDX-License-Identifier: Zlib
#include <stdexcept>
#include <utility>

#include "limber/render/gl_context.h"

namespace limber::render {
namespace {

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

}  // namespace limber::render

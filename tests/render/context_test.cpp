// SPDX-License-Identifier: Zlib
#include <dlfcn.h>

#include <stdexcept>
#include <string>
#include <thread>

#include "limber/render/gl_functions.h"
#include "test_scene.h"

namespace limber::render::test {
namespace {

bool libraryExists(const char* name) { return dlopen(name, RTLD_NOW | RTLD_LOCAL) != nullptr; }

Image sceneOn(Backend backend) {
  Stage stage(backend);
  populate(stage);
  return stage.picture();
}

TEST(Context, AutoMakesACurrentContext) {
  const auto context = createContext();
  EXPECT_FALSE(context->name().empty());
  const Gl gl = loadGl(*context);
  EXPECT_NE(describeDriver(gl).find("4."), std::string::npos) << describeDriver(gl);
}

TEST(Context, OsmesaAndEglDrawTheSameBytes) {
  // A library that is installed but does not work is a failure, not a reason to skip.
  if (!libraryExists("libOSMesa.so.8") && !libraryExists("libOSMesa.so.6")) {
    GTEST_SKIP() << "OSMesa is not installed";
  }
  if (!libraryExists("libEGL.so.1")) {
    GTEST_SKIP() << "EGL is not installed";
  }
  const Image osmesa = sceneOn(Backend::OSMesa);
  EXPECT_EQ(sceneOn(Backend::EglSurfaceless).rgba, osmesa.rgba);
  // A GPU rounds differently, so only a software device is compared.
  ContextDesc desc;
  desc.backend = Backend::Egl;
  if (describeDriver(loadGl(*createContext(desc))).find("llvmpipe") != std::string::npos) {
    EXPECT_EQ(sceneOn(Backend::Egl).rgba, osmesa.rgba);
  }
}

TEST(Context, ImpossibleDeviceSaysWhatWasTried) {
  ContextDesc desc;
  desc.backend = Backend::Egl;
  desc.eglDevice = 31;
  try {
    createContext(desc);
    FAIL() << "there is no such device";
  } catch (const std::runtime_error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("EGL"), std::string::npos) << text;
    EXPECT_EQ(text.find("OSMesa"), std::string::npos) << "only EGL was asked for: " << text;
  }
}

TEST(Context, MovesToAnotherThread) {
  const auto context = createContext();
  context->release();
  std::string driver;
  std::thread([&] {
    context->makeCurrent();
    driver = describeDriver(loadGl(*context));
    context->release();
  }).join();
  context->makeCurrent();
  EXPECT_EQ(driver, describeDriver(loadGl(*context)));
}

}  // namespace
}  // namespace limber::render::test

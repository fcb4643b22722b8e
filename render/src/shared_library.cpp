// SPDX-License-Identifier: Zlib
#include "shared_library.h"

#include <dlfcn.h>

#include <stdexcept>

namespace limber::render {

SharedLibrary::SharedLibrary(const std::vector<std::string>& names) {
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

void* SharedLibrary::address(const char* symbol) const {
  void* found = dlsym(handle_, symbol);
  if (found == nullptr) {
    throw std::runtime_error(name_ + " has no function " + symbol);
  }
  return found;
}

}  // namespace limber::render

// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace limber::render {

/// A library opened at run time. It is never closed again: the drivers behind it register exit
/// handlers and threads that do not survive unloading.
class SharedLibrary {
 public:
  /// Opens the first of `names` that can be opened. Throws std::runtime_error with every reason.
  explicit SharedLibrary(const std::vector<std::string>& names);

  /// Throws std::runtime_error if there is no such symbol.
  template <typename Function>
  Function function(const char* symbol) const {
    return reinterpret_cast<Function>(address(symbol));
  }

 private:
  void* address(const char* symbol) const;

  void* handle_ = nullptr;
  std::string name_;
};

}  // namespace limber::render

// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace limber {

/// What went wrong, in one sentence that names the file, field or index.
struct Error {
  std::string reason;
};

/// Either a value or the reason why there is none. Limber throws no exceptions of its own, so that it can be
/// used in programs built without them.
///
///     Result<TriangleMesh> mesh = importMesh("cube.obj");
///     if (!mesh) { puts(mesh.error().c_str()); return; }
///     use(*mesh);
template <class T>
class Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}

  explicit operator bool() const { return content_.index() == 0; }

  /// The value; only when the result is true.
  T& operator*() { return *std::get_if<0>(&content_); }
  const T& operator*() const { return *std::get_if<0>(&content_); }
  T* operator->() { return std::get_if<0>(&content_); }
  const T* operator->() const { return std::get_if<0>(&content_); }

  /// The reason; empty when the result is true.
  std::string error() const { return *this ? std::string() : std::get_if<1>(&content_)->reason; }

 private:
  std::variant<T, Error> content_;
};

}  // namespace limber

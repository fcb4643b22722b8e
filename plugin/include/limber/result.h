// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace limber {

/// A failure, described in one sentence that names the file, field or index.
struct Error {
  std::string reason;
};

/// Either a value or the reason why there is none. Limber itself throws no exceptions, so programs that are
/// built without exceptions can use it.
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

  /// Returns the value. The result must be true.
  T& operator*() { return *std::get_if<0>(&content_); }
  const T& operator*() const { return *std::get_if<0>(&content_); }
  T* operator->() { return std::get_if<0>(&content_); }
  const T* operator->() const { return std::get_if<0>(&content_); }

  /// Returns the reason; empty when the result is true.
  std::string error() const { return *this ? std::string() : std::get_if<1>(&content_)->reason; }

 private:
  std::variant<T, Error> content_;
};

/// Success, or the reason of a failure, of a function that has nothing to return.
///
///     if (Result<void> done = saveNetwork(network, file); !done) puts(done.error().c_str());
template <>
class Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error.reason)), failed_(true) {}

  explicit operator bool() const { return !failed_; }

  /// Returns the reason; empty when the result is true.
  const std::string& error() const { return error_; }

 private:
  std::string error_;
  bool failed_ = false;
};

}  // namespace limber

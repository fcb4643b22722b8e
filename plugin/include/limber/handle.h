// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>
#include <utility>

namespace limber {

/// A reference to a soft body or a spring that is null as soon as the object has been destroyed: get it from
/// SoftBody::handle() or SpringConstraint::handle(). Thread rule: as for the object.
template <class T>
class Handle {
 public:
  Handle() = default;
  Handle(T* object, std::weak_ptr<const void> life) : object_(object), life_(std::move(life)) {}

  /// Returns the object, nullptr if it has been destroyed.
  T* get() const { return life_.expired() ? nullptr : object_; }
  explicit operator bool() const { return get() != nullptr; }
  T* operator->() const { return get(); }
  T& operator*() const { return *get(); }

 private:
  T* object_ = nullptr;
  std::weak_ptr<const void> life_;
};

}  // namespace limber

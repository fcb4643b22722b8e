// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>
#include <utility>

namespace limber {

/// Constants that several bodies share, for example the springs of equal bodies. Copies are cheap.
template <class Constants>
class SharedConstants {
 public:
  /// Default constants, which all default objects share.
  SharedConstants() {
    static const auto none = std::make_shared<const Constants>();
    constants_ = none;
  }
  explicit SharedConstants(Constants constants)
      : constants_(std::make_shared<const Constants>(std::move(constants))) {}

  const Constants& operator*() const { return *constants_; }
  const Constants* operator->() const { return constants_.get(); }

 private:
  std::shared_ptr<const Constants> constants_;
};

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

namespace limber {

/// The deformations in which a spring exerts a force.
enum class SpringAction : std::uint8_t {
  Both,
  ExtensionOnly,   ///< a bungee: no force while shorter than its rest length
  CompressionOnly  ///< a bumper: no force while longer than its rest length
};

/// A single spring with a parallel damper.
struct SpringSettings {
  double restLength = -1.0;   ///< m, 0 or more; negative: the distance of the ends when the spring is added
  double stiffness = 1000.0;  ///< N/m, 0 or more
  double damping = 0.0;       ///< N s/m along the spring, 0 or more, only while the spring acts
  SpringAction action = SpringAction::Both;
};

/// Returns the first invalid setting and the reason, or an empty string.
std::string validate(const SpringSettings& settings);

}  // namespace limber

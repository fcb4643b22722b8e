// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

namespace limber {

/// When a spring pulls or pushes.
enum class SpringAction : std::uint8_t {
  Both,
  ExtensionOnly,   ///< a bungee: slack while shorter than its rest length
  CompressionOnly  ///< a bumper: loose while longer than its rest length
};

/// A single spring with a damper beside it.
struct SpringSettings {
  double restLength = -1.0;   ///< m, 0 or more; negative: the distance of the ends when the spring is added
  double stiffness = 1000.0;  ///< N/m, 0 or more
  double damping = 0.0;       ///< N s/m along the spring, 0 or more, only while the spring acts
  SpringAction action = SpringAction::Both;
};

/// The first setting that cannot be used and why, or an empty string.
std::string validate(const SpringSettings& settings);

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

namespace limber::test {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kRadius = 0.02;      ///< m, of a body's points
inline constexpr double kGravity = 9.81;     ///< m/s^2
inline constexpr double kTick = 1.0 / 60.0;  ///< s

}  // namespace limber::test

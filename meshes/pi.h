// SPDX-License-Identifier: Zlib
#pragma once

namespace shapes {

constexpr double kPi = 3.14159265358979323846;

}  // namespace shapes

// SPDX-License-Identifier: Zlib
#include "scenes/random.h"

#include <cmath>

namespace limber::scenes {

Eigen::Quaterniond Random::rotation() {
  constexpr double kTwoPi = 6.283185307179586;
  const double u = unit();
  const double a = kTwoPi * unit();
  const double b = kTwoPi * unit();
  const double r = std::sqrt(1.0 - u);
  const double s = std::sqrt(u);
  return Eigen::Quaterniond(s * std::cos(b), r * std::sin(a), r * std::cos(a), s * std::sin(b)).normalized();
}

}  // namespace limber::scenes

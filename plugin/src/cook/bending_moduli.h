// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/elastic_moduli.h"

#include <array>

namespace limber {

/// Pa: the Young's moduli that a body shows when bent, for the six stresses  s_aa = x_b - centre_b  of 1 Pa/m
/// along each axis a, varying along each other axis b. Such a stress is in equilibrium without forces inside
/// and does the work  1/E integral of (x_b - centre_b)^2  on a homogeneous isotropic solid of any shape, so
/// that all six are its Young's modulus. Networks are calibrated by uniform stresses; how far their answers
/// to these are off is what discretising leaves. The order is xy xz yz yx zx zy for ab. For networks with a
/// closed surface.
std::array<double, 6> measureBendingModuli(const ElasticBody& body);

}  // namespace limber

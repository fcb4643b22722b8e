// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <cstdint>
#include <vector>

namespace limber::test {

/// A network of five points with data in every member, and only numbers that rounding cannot change. It must
/// not change, because tests/cook/golden/ contains its bytes.
SpringNetwork everyMemberNetwork();

/// Returns `bytes` with the size and hash of the header corrected; at least a header long.
std::vector<std::uint8_t> forged(std::vector<std::uint8_t> bytes);

/// Size of the header of a .limber file.
constexpr std::size_t kHeaderBytes = 28;

}  // namespace limber::test

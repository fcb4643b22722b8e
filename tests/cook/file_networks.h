// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <cstdint>
#include <vector>

namespace limber::test {

/// Five points, with something in every member and no number the machine's rounding could change: it must
/// stay as it is, for tests/cook/golden/ holds its bytes.
SpringNetwork everyMemberNetwork();

/// `bytes` with the size and hash that its contents ask for; at least a header long.
std::vector<std::uint8_t> forged(std::vector<std::uint8_t> bytes);

/// Of a .limber file.
constexpr std::size_t kHeaderBytes = 28;

}  // namespace limber::test

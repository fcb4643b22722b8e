// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/spring_network.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber {

/// A network as the bytes of a `.limber` file: magic number, version, size, hash, then the members' arrays,
/// little-endian whatever the machine. Equal networks give equal bytes.
std::vector<std::uint8_t> toBytes(const SpringNetwork& network);

/// The network back, bit for bit. Errors, each naming what is wrong: not a .limber file, a version that this
/// library does not know, truncated or longer than it says, a wrong hash, arrays that do not fit, and all
/// that validate(SpringNetwork) finds. Never reads past `size`, never allocates more than about `size`.
Result<SharedNetwork> fromBytes(const std::uint8_t* bytes, std::size_t size);

/// Writes the file anew under a temporary name and renames it, so that there is never half a file. Empty when
/// written, else the reason with the file's name; what validate(SpringNetwork) refuses is not written.
std::string saveNetwork(const SpringNetwork& network, const std::string& file);

/// fromBytes of a file; errors have the file's name in them.
Result<SharedNetwork> loadNetwork(const std::string& file);

}  // namespace limber

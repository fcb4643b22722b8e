// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/spring_network.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber {

/// Returns a network as the bytes of a `.limber` file: magic number, version, size, hash, then the arrays of
/// the members, little-endian on every machine. Equal networks give equal bytes.
std::vector<std::uint8_t> toBytes(const SpringNetwork& network);

/// Returns the network that toBytes() wrote, bit for bit. Errors, each with its cause: not a .limber file; a
/// version that this library does not support; a file shorter or longer than its header states; a wrong hash;
/// arrays of inconsistent sizes; and everything that validate(SpringNetwork) reports. Never reads past
/// `size`, never allocates more than about `size`.
Result<SharedNetwork> fromBytes(const std::uint8_t* bytes, std::size_t size);

/// Writes the file under a temporary name and renames it, so that an incomplete file never exists under the
/// final name. Returns an empty string on success, else the reason with the file's name. Networks that
/// validate(SpringNetwork) rejects are not written.
std::string saveNetwork(const SpringNetwork& network, const std::string& file);

/// Reads a file with fromBytes(). Errors contain the file's name.
Result<SharedNetwork> loadNetwork(const std::string& file);

}  // namespace limber

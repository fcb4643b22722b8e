// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber {

/// What is wrong with a file of `fileSize` bytes, from its first ones, or empty.
using HeaderCheck = std::string (*)(const std::uint8_t* header, std::uint64_t fileSize);

/// All bytes of a file; the rest of them only after its first `headerBytes` (or all, if there are fewer) have
/// passed the check, so that no large foreign file is read. Errors name the file: it cannot be read, is no
/// regular file, or what the check finds.
Result<std::vector<std::uint8_t>> readWholeFile(const std::string& file, std::size_t headerBytes,
                                                HeaderCheck check);

/// Writes a file beside `file` and renames it to that, so that there is always the old or the new one whole.
/// Empty when written, else the reason with the file's name; nothing is left behind then.
std::string writeWholeFile(const std::string& file, const std::vector<std::uint8_t>& bytes);

}  // namespace limber

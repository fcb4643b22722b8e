// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

namespace limber {

/// What the springs of several bodies are computed with at once. All give the same bits.
enum class InstructionSet : std::uint8_t { Scalar, Sse2, Avx2, Avx512 };

/// Bodies at once: 1, 2, 4 or 8.
int laneCount(InstructionSet set);

/// Whether this machine and this build have it.
bool isAvailable(InstructionSet set);

/// The widest available.
InstructionSet bestInstructionSet();

const char* nameOf(InstructionSet set);

}  // namespace limber

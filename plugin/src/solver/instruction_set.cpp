// SPDX-License-Identifier: Zlib
#include "solver/instruction_set.h"

#include "solver/lane_kernels.h"

#include <initializer_list>

namespace limber {

int laneCount(InstructionSet set) {
  constexpr int kCount[] = {1, 2, 4, 8};
  return kCount[static_cast<int>(set)];
}

bool isAvailable(InstructionSet set) {
#if defined(LIMBER_HAS_LANES)
  switch (set) {
    case InstructionSet::Scalar:
    case InstructionSet::Sse2:
      return true;
    case InstructionSet::Avx2:
      return __builtin_cpu_supports("avx2");
    case InstructionSet::Avx512:
      return __builtin_cpu_supports("avx512f");
  }
#endif
  return set == InstructionSet::Scalar;
}

InstructionSet bestInstructionSet() {
  for (const InstructionSet set : {InstructionSet::Avx512, InstructionSet::Avx2, InstructionSet::Sse2})
    if (isAvailable(set)) return set;
  return InstructionSet::Scalar;
}

const char* nameOf(InstructionSet set) {
  constexpr const char* kName[] = {"scalar", "SSE2", "AVX2", "AVX-512"};
  return kName[static_cast<int>(set)];
}

}  // namespace limber

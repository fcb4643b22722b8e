// SPDX-License-Identifier: Zlib
// The code of lane_kernel_*.cpp. Each of these files compiles it for registers of LIMBER_PACK_BITS, as
// LIMBER_PACK_STEP.

#include "solver/target_begin.h"

#include "solver/motion_sums.h"

namespace limber::kernel {
namespace {

/// Returns the same pointers, as those to packs.
template <class Packs, class Numbers>
Packs packs(const Numbers& numbers) {
  static_assert(sizeof(Packs) == sizeof(Numbers));
  Packs result;
  __builtin_memcpy(static_cast<void*>(&result), &numbers, sizeof result);
  return result;
}

}  // namespace

void LIMBER_PACK_STEP(const Body<double>& body, const MovedPoints<double>* moved, double* change, double tick,
                      int substeps) {
  *reinterpret_cast<Pack*>(change) = stepAlone<Pack>(packs<Body<Pack>>(body), tick, substeps);
  if (moved) sumUp(packs<MovedPoints<Pack>>(*moved));
}

}  // namespace limber::kernel

#include "solver/target_end.h"

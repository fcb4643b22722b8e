// SPDX-License-Identifier: Zlib
// The body of float_lanes_*.cpp, each of which compiles it for another instruction set.

#define LIMBER_PACK_NUMBER float
#include "solver/verlet_kernel.h"

namespace limber::bench {
namespace {

kernel::Pack* packs(AlignedNumbers& numbers) { return reinterpret_cast<kernel::Pack*>(numbers.data()); }

}  // namespace

void LIMBER_FLOAT_STEP(FloatLanes& l, double tick, int substeps) {
  using kernel::Pack;
  const kernel::ContactCalls none{nullptr, nullptr, nullptr};
  kernel::Body<Pack> body;
  body.springs = {l.springs,          l.a.data(),         l.b.data(),        packs(l.restLength),
                  packs(l.stiffness), packs(l.stiffness), packs(l.direction)};
  body.points = {l.points,       packs(l.position),     packs(l.velocity),
                 packs(l.force), packs(l.acceleration), packs(l.inverseMass)};
  body.hasDampers = l.damped;
  body.dampHalf = packs(l.dampHalf);
  body.dampFull = packs(l.dampFull);
  body.contactCalls = &none;
  body.earlierForce = packs(l.earlierForce);
  kernel::stepAlone<Pack>(body, tick, substeps);
}

}  // namespace limber::bench

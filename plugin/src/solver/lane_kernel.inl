// SPDX-License-Identifier: Zlib
// The code of lane_kernel_*.cpp. Each of these files compiles it for a different instruction set.

#include "solver/verlet_kernel.h"

namespace limber::kernel {
namespace {

Pack* packs(double* numbers) { return reinterpret_cast<Pack*>(numbers); }
const Pack* packs(const double* numbers) { return reinterpret_cast<const Pack*>(numbers); }

}  // namespace

void LIMBER_PACK_STEP(const LaneBody& b, double tick, int substeps) {
  Body<Pack> body;
  body.springs = {b.springs,
                  b.a,
                  b.b,
                  packs(b.restLength),
                  packs(b.extensionStiffness),
                  packs(b.compressionStiffness),
                  packs(b.direction)};
  body.points = {b.points,       packs(b.position),     packs(b.velocity),
                 packs(b.force), packs(b.acceleration), packs(b.inverseMass)};
  const VolumeBody& v = b.volumes;
  body.volumes = {v.components,        v.points,         v.firstTriangle,   v.corners,         v.componentOf,
                  packs(v.restVolume), packs(v.modulus), packs(v.pressure), packs(v.gradient), packs(v.sums),
                  v.timeStep};
  const TetrahedronBody& t = b.tetrahedra;
  body.tetrahedra = {t.count,
                     t.corners,
                     packs(t.inverseRest),
                     packs(t.stabilityScale),
                     packs(t.modulus),
                     packs(t.crushModulus)};
  body.hasDampers = b.damped;
  body.dampHalf = packs(b.dampHalf);
  body.dampFull = packs(b.dampFull);
  body.contactCalls = b.contacts;
  body.earlierForce = packs(b.earlierForce);
  *packs(b.change) = stepAlone<Pack>(body, tick, substeps);
}

}  // namespace limber::kernel

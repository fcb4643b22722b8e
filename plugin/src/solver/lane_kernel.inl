// SPDX-License-Identifier: Zlib
// The code of lane_kernel_*.cpp. Each of these files compiles it for registers of LIMBER_PACK_BITS, as
// LIMBER_PACK_STEP.

#include "solver/target_begin.h"

#include "solver/motion_sums.h"

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
                  b.restLength,
                  b.extensionStiffness,
                  b.compressionStiffness,
                  packs(b.direction),
                  b.stretch ? packs(b.stretch) : nullptr,
                  b.crossingLoss};
  body.points = {b.points,       packs(b.position),     packs(b.velocity),
                 packs(b.force), packs(b.acceleration), packs(b.inverseMass)};
  const VolumeBody& v = b.volumes;
  body.volumes = {v.components,  v.points,          v.firstTriangle, v.corners,
                  v.componentOf, v.restVolume,      v.modulus,       v.gasPressure,
                  v.ambient,     packs(v.gradient), packs(v.sums),   v.timeStep};
  const TetrahedronBody& t = b.tetrahedra;
  body.tetrahedra = {t.count, t.corners, t.inverseRest, packs(t.stabilityScale), t.modulus, t.crushModulus};
  body.planes = {b.planes, b.planePoints, reinterpret_cast<Plane<Pack>*>(b.planeNumbers)};
  if (b.regionDistance) body.regions = {b.points, packs(b.regionCenter), packs(b.regionDistance)};
  body.sweepCount = b.sweeps;
  body.dampHalf = b.dampHalf;
  body.dampFull = b.dampFull;
  body.contactCalls = b.contacts;
  body.earlierForce = packs(b.earlierForce);
  *packs(b.change) = stepAlone<Pack>(body, tick, substeps);
  if (!b.sums) return;
  sumUp(MovedPoints<Pack>{b.points, packs(b.position), packs(b.velocity), packs(b.inverseMass),
                          packs(b.start), b.fractions, b.weightedRest},
        *reinterpret_cast<MotionSums<Pack>*>(b.sums));
}

}  // namespace limber::kernel

#include "solver/target_end.h"

// SPDX-License-Identifier: Zlib
#include "solver/spring_lanes.h"

#include "solver/body_contacts.h"
#include "solver/kernel_views.h"
#include "solver/lane_kernels.h"
#include "solver/spring_damping.h"
#include "solver/verlet_kernel.h"

namespace limber {
namespace {

void reserveVolumes(LaneBlock& b, LaneScratch& scratch, const VolumeArrays& volumes, std::size_t lanes) {
  reserveNumbers(b.restVolume, volumes.restVolume.size() * lanes);
  reserveNumbers(b.modulus, lanes);
  reserveNumbers(b.pressure, lanes);
  reserveNumbers(scratch.gradient, static_cast<std::size_t>(volumes.gradient.size()) * lanes);
  reserveNumbers(scratch.sums, volumes.sums.size() * lanes);
}

void reserveTetrahedra(LaneBlock& b, LaneScratch& scratch, const TetrahedronVolumes& tetrahedra,
                       std::size_t lanes) {
  reserveNumbers(b.inverseRest, tetrahedra.inverseRest.size() * lanes);
  reserveNumbers(scratch.hold, tetrahedra.hold.size() * lanes);
  reserveNumbers(b.tetrahedronModulus, lanes);
  reserveNumbers(b.crushModulus, lanes);
}

void reserve(LaneScratch& s, std::size_t points, std::size_t springs, std::size_t lanes) {
  for (auto* array : {&s.position, &s.velocity, &s.acceleration, &s.inverseMass, &s.force, &s.earlierForce})
    reserveNumbers(*array, 3 * points * lanes);
  reserveNumbers(s.direction, 3 * springs * lanes);
}

void reserve(LaneBlock& b, LaneScratch& scratch, std::size_t lanes) {
  const SteppedBody& first = b.lanes[0].body;
  reserve(scratch, static_cast<std::size_t>(first.points->position.cols()), first.springs->size(), lanes);
  for (auto* array :
       {&b.restLength, &b.extensionStiffness, &b.compressionStiffness, &b.dampHalf, &b.dampFull})
    reserveNumbers(*array, first.springs->size() * lanes);
  if (first.volumes) reserveVolumes(b, scratch, *first.volumes, lanes);
  if (first.tetrahedra) reserveTetrahedra(b, scratch, *first.tetrahedra, lanes);
}

void toLane(const double* from, std::size_t count, AlignedNumbers& to, std::size_t lane, std::size_t lanes) {
  double* target = numbers(to) + lane;
  for (std::size_t i = 0; i < count; ++i) target[i * lanes] = from[i];
}

void fromLane(const AlignedNumbers& from, std::size_t lane, std::size_t lanes, std::size_t count,
              double* to) {
  const double* source = from.front().value + lane;
  for (std::size_t i = 0; i < count; ++i) to[i] = source[i * lanes];
}

void loadState(LaneScratch& scratch, const PointState& state, std::size_t lane, std::size_t lanes) {
  const auto count = static_cast<std::size_t>(state.position.size());
  toLane(state.position.data(), count, scratch.position, lane, lanes);
  toLane(state.velocity.data(), count, scratch.velocity, lane, lanes);
  toLane(state.acceleration.data(), count, scratch.acceleration, lane, lanes);
  toLane(state.inverseMass.data(), count, scratch.inverseMass, lane, lanes);
}

void loadSprings(LaneBlock& block, const SpringArrays& springs, std::size_t lane, std::size_t lanes) {
  const std::size_t count = springs.size();
  toLane(springs.restLength.data(), count, block.restLength, lane, lanes);
  toLane(springs.extensionStiffness.data(), count, block.extensionStiffness, lane, lanes);
  toLane(springs.compressionStiffness.data(), count, block.compressionStiffness, lane, lanes);
  toLane(springs.dampHalf.data(), count, block.dampHalf, lane, lanes);
  toLane(springs.dampFull.data(), count, block.dampFull, lane, lanes);
}

void loadVolumes(LaneBlock& block, const VolumeArrays& volumes, std::size_t lane, std::size_t lanes) {
  toLane(volumes.restVolume.data(), volumes.restVolume.size(), block.restVolume, lane, lanes);
  toLane(&volumes.modulus, 1, block.modulus, lane, lanes);
  toLane(&volumes.pressure, 1, block.pressure, lane, lanes);
}

void loadTetrahedra(LaneBlock& block, const TetrahedronVolumes& tetrahedra, std::size_t lane,
                    std::size_t lanes) {
  toLane(tetrahedra.inverseRest.data(), tetrahedra.inverseRest.size(), block.inverseRest, lane, lanes);
  toLane(&tetrahedra.modulus, 1, block.tetrahedronModulus, lane, lanes);
  toLane(&tetrahedra.crushModulus, 1, block.crushModulus, lane, lanes);
}

/// A lane without a body holds points that coincide and rest: nothing pulls or moves them.
void clearState(LaneBlock& block, LaneScratch& s, std::size_t count, std::size_t lane, std::size_t lanes) {
  for (auto* array : {&s.position, &s.velocity, &s.acceleration, &s.inverseMass})
    for (std::size_t i = 0; i < count; ++i) numbers(*array)[i * lanes + lane] = 0.0;
  const VolumeArrays* volumes = block.lanes[0].body.volumes;
  for (std::size_t c = 0; volumes && c < volumes->restVolume.size(); ++c)
    numbers(block.restVolume)[c * lanes + lane] = 1.0;
}

void load(LaneBlock& block, LaneScratch& scratch, std::size_t lanes) {
  for (std::size_t lane = 0; lane < block.lanes.size(); ++lane) {
    LaneBlock::Lane& source = block.lanes[lane];
    loadState(scratch, *source.body.points, lane, lanes);
    const TetrahedronVolumes* tetrahedra = source.body.tetrahedra;
    if (tetrahedra) toLane(tetrahedra->hold.data(), tetrahedra->hold.size(), scratch.hold, lane, lanes);
    if (source.revision == source.body.springs->revision) continue;
    loadSprings(block, *source.body.springs, lane, lanes);
    if (source.body.volumes) loadVolumes(block, *source.body.volumes, lane, lanes);
    if (tetrahedra) loadTetrahedra(block, *tetrahedra, lane, lanes);
    source.revision = source.body.springs->revision;
  }
  const auto count = static_cast<std::size_t>(block.lanes[0].body.points->position.size());
  for (std::size_t lane = block.lanes.size(); lane < lanes; ++lane)
    clearState(block, scratch, count, lane, lanes);
}

struct LaneContacts {
  LaneBlock& block;
  LaneScratch& scratch;
  int stride;

  PointView points(std::size_t lane) const {
    return {numbers(scratch.position) + lane, numbers(scratch.velocity) + lane,
            numbers(scratch.inverseMass) + lane, stride, 3 * stride};
  }
  static void stop(void* context, double time, double dt) {
    const auto& self = *static_cast<const LaneContacts*>(context);
    for (std::size_t lane = 0; lane < self.block.lanes.size(); ++lane)
      stopAtContacts(self.block.lanes[lane].body, self.points(lane), time, dt);
  }
  static void settle(void* context) {
    const auto& self = *static_cast<const LaneContacts*>(context);
    for (std::size_t lane = 0; lane < self.block.lanes.size(); ++lane)
      settleContacts(self.block.lanes[lane].body, self.points(lane));
  }
};

/// Readies the contacts of all lanes; false if there are none.
bool prepareContacts(LaneBlock& block, const LaneContacts& contacts) {
  bool any = false;
  for (std::size_t lane = 0; lane < block.lanes.size(); ++lane) {
    SteppedBody& body = block.lanes[lane].body;
    if (!mayTouch(body)) continue;
    if (body.contacts) prepareContacts(*body.contacts, contacts.points(lane));
    any = true;
  }
  return any;
}

kernel::VolumeBody laneVolumes(LaneBlock& b, LaneScratch& s) {
  VolumeArrays* volumes = b.lanes[0].body.volumes;
  if (!volumes) return {};
  kernel::VolumeBody body = volumeBody(*volumes);
  body.restVolume = numbers(b.restVolume);
  body.modulus = numbers(b.modulus), body.pressure = numbers(b.pressure);
  body.gradient = numbers(s.gradient), body.sums = numbers(s.sums);
  return body;
}

kernel::TetrahedronBody laneTetrahedra(LaneBlock& b, LaneScratch& s) {
  const TetrahedronVolumes* tetrahedra = b.lanes[0].body.tetrahedra;
  if (!tetrahedra) return {};
  kernel::TetrahedronBody body = tetrahedronBody(*tetrahedra);
  body.inverseRest = numbers(b.inverseRest), body.hold = numbers(s.hold);
  body.modulus = numbers(b.tetrahedronModulus), body.crushModulus = numbers(b.crushModulus);
  return body;
}

kernel::LaneBody laneBody(LaneBlock& b, LaneScratch& s, const kernel::ContactCalls& contacts,
                          double* change) {
  const SpringArrays& springs = *b.lanes[0].body.springs;
  kernel::LaneBody body;
  body.points = static_cast<unsigned>(b.lanes[0].body.points->position.cols());
  body.springs = static_cast<unsigned>(springs.size());
  body.a = springs.a.data(), body.b = springs.b.data();
  body.position = numbers(s.position), body.velocity = numbers(s.velocity);
  body.force = numbers(s.force), body.earlierForce = numbers(s.earlierForce);
  body.acceleration = numbers(s.acceleration), body.inverseMass = numbers(s.inverseMass);
  body.restLength = numbers(b.restLength);
  body.extensionStiffness = numbers(b.extensionStiffness);
  body.compressionStiffness = numbers(b.compressionStiffness);
  body.direction = numbers(s.direction);
  body.dampHalf = numbers(b.dampHalf), body.dampFull = numbers(b.dampFull);
  body.volumes = laneVolumes(b, s);
  body.tetrahedra = laneTetrahedra(b, s);
  body.damped = springs.damped;
  body.contacts = &contacts;
  body.change = change;
  return body;
}

void stepPacks(const kernel::LaneBody& body, double tick, int substeps, InstructionSet set) {
#if defined(LIMBER_HAS_LANES)
  switch (set) {
    case InstructionSet::Sse2:
      return kernel::stepSse2(body, tick, substeps);
    case InstructionSet::Avx2:
      return kernel::stepAvx2(body, tick, substeps);
    case InstructionSet::Avx512:
      return kernel::stepAvx512(body, tick, substeps);
    case InstructionSet::Scalar:
      break;
  }
#endif
  static_cast<void>(body), static_cast<void>(tick), static_cast<void>(substeps), static_cast<void>(set);
}

void unload(LaneBlock& block, const LaneScratch& scratch, std::size_t lanes, const CacheLine& change,
            double dt) {
  for (std::size_t lane = 0; lane < block.lanes.size(); ++lane) {
    SteppedBody& body = block.lanes[lane].body;
    PointState& state = *body.points;
    const auto count = static_cast<std::size_t>(state.position.size());
    fromLane(scratch.position, lane, lanes, count, state.position.data());
    fromLane(scratch.velocity, lane, lanes, count, state.velocity.data());
    body.errorRate = verletErrorRate(change.value[lane], state.position.cols(), dt);
  }
}

}  // namespace

void stepLanes(LaneBlock& block, LaneScratch& scratch, double tick, int substeps, InstructionSet set) {
  const auto lanes = static_cast<std::size_t>(laneCount(set));
  for (LaneBlock::Lane& lane : block.lanes) {
    prepareDampers(*lane.body.springs, lane.body.points->inverseMass, tick / substeps);
    prepareVolumes(lane.body, tick / substeps);
  }
  reserve(block, scratch, lanes);
  load(block, scratch, lanes);
  LaneContacts contacts{block, scratch, laneCount(set)};
  const kernel::ContactCalls calls{prepareContacts(block, contacts) ? &contacts : nullptr,
                                   &LaneContacts::stop, &LaneContacts::settle};
  CacheLine change;
  stepPacks(laneBody(block, scratch, calls, change.value), tick, substeps, set);
  unload(block, scratch, lanes, change, tick / substeps);
}

}  // namespace limber

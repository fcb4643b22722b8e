// SPDX-License-Identifier: Zlib
// Copies bodies into the arrays of the kernels of lane_kernels.h, steps them and copies them back.
#include "solver/simd_steps.h"

#include "solver/verlet_kernel.h"

#include <algorithm>
#include <initializer_list>

#if !defined(LIMBER_HAS_LANES)
namespace limber::kernel {
// never called, see canStepSpringBatches()
double stepSpringBatches(const SpringBatchBody&, double, int) { return 0.0; }
void computeBatchForces(const SpringBatchBody&) {}
double computeBatchForcesAndChange(const SpringBatchBody&) { return 0.0; }
void kickSpringBatches(const SpringBatchBody&, double) {}
void driftSpringBatches(const SpringBatchBody&, double) {}
void dampSpringBatches(const SpringBatchBody&, bool, bool) {}
}  // namespace limber::kernel
#endif

namespace limber {

// --- instruction sets --------------------------------------------------------------------------------------

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

// --- several bodies at once --------------------------------------------------------------------------------

namespace {

kernel::VolumeBody volumeBody(VolumeArrays& volumes) {
  const kernel::Volumes<double> v = kernelVolumes(volumes);
  return {v.components, v.points,   v.firstTriangle, v.corners, v.componentOf, v.restVolume,
          v.modulus,    v.pressure, v.gradient,      v.sums,    v.timeStep};
}

kernel::TetrahedronBody tetrahedronBody(const TetrahedronVolumes& volumes) {
  const kernel::Tetrahedra<double> t = kernelTetrahedra(volumes);
  return {t.count, t.corners, t.inverseRest, t.stabilityScale, t.modulus, t.crushModulus};
}

void reserveVolumes(LaneBlock& b, LaneScratch& scratch, const VolumeArrays& volumes, std::size_t lanes) {
  reserveNumbers(b.restVolume, volumes->restVolume.size() * lanes);
  reserveNumbers(b.modulus, lanes);
  reserveNumbers(b.pressure, lanes);
  reserveNumbers(scratch.gradient, static_cast<std::size_t>(volumes.gradient.size()) * lanes);
  reserveNumbers(scratch.sums, volumes.sums.size() * lanes);
}

void reserveTetrahedra(LaneBlock& b, LaneScratch& scratch, const TetrahedronVolumes& tetrahedra,
                       std::size_t lanes) {
  reserveNumbers(b.inverseRest, tetrahedra->inverseRest.size() * lanes);
  reserveNumbers(scratch.stabilityScale, tetrahedra.stabilityScale.size() * lanes);
  reserveNumbers(b.tetrahedronModulus, lanes);
  reserveNumbers(b.crushModulus, lanes);
}

void reserve(LaneScratch& s, std::size_t points, std::size_t springs, std::size_t lanes) {
  for (auto* array : {&s.position, &s.velocity, &s.acceleration, &s.inverseMass, &s.force, &s.earlierForce})
    reserveNumbers(*array, 3 * points * lanes);
  reserveNumbers(s.direction, 3 * springs * lanes);
}

void reserve(LaneBlock& b, LaneScratch& scratch, std::size_t lanes) {
  const SolverBody& first = b.lanes[0].body;
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
  toLane(springs->restLength.data(), count, block.restLength, lane, lanes);
  toLane(springs->extensionStiffness.data(), count, block.extensionStiffness, lane, lanes);
  toLane(springs->compressionStiffness.data(), count, block.compressionStiffness, lane, lanes);
}

void loadDampers(LaneBlock& block, const SolverBody& body, double dt, std::size_t lane, std::size_t lanes) {
  const SpringArrays& springs = *body.springs;
  if (!springs->damped) return;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const DampingImpulses impulses = dampingImpulses(springs, body.points->inverseMass, i, dt);
    numbers(block.dampHalf)[i * lanes + lane] = impulses.half;
    numbers(block.dampFull)[i * lanes + lane] = impulses.full;
  }
}

void loadVolumes(LaneBlock& block, const VolumeArrays& volumes, std::size_t lane, std::size_t lanes) {
  toLane(volumes->restVolume.data(), volumes->restVolume.size(), block.restVolume, lane, lanes);
  toLane(&volumes->modulus, 1, block.modulus, lane, lanes);
  toLane(&volumes->pressure, 1, block.pressure, lane, lanes);
}

void loadTetrahedra(LaneBlock& block, const TetrahedronVolumes& tetrahedra, std::size_t lane,
                    std::size_t lanes) {
  toLane(tetrahedra->inverseRest.data(), tetrahedra->inverseRest.size(), block.inverseRest, lane, lanes);
  toLane(&tetrahedra->modulus, 1, block.tetrahedronModulus, lane, lanes);
  toLane(&tetrahedra->crushModulus, 1, block.crushModulus, lane, lanes);
}

/// Clears a lane without a body: its points coincide and rest, without forces or masses.
void clearState(LaneBlock& block, LaneScratch& s, std::size_t count, std::size_t lane, std::size_t lanes) {
  for (auto* array : {&s.position, &s.velocity, &s.acceleration, &s.inverseMass})
    for (std::size_t i = 0; i < count; ++i) numbers(*array)[i * lanes + lane] = 0.0;
  const VolumeArrays* volumes = block.lanes[0].body.volumes;
  for (std::size_t c = 0; volumes && c < (*volumes)->restVolume.size(); ++c)
    numbers(block.restVolume)[c * lanes + lane] = 1.0;
}

void load(LaneBlock& block, LaneScratch& scratch, double dt, std::size_t lanes) {
  for (std::size_t lane = 0; lane < block.lanes.size(); ++lane) {
    LaneBlock::Lane& source = block.lanes[lane];
    loadState(scratch, *source.body.points, lane, lanes);
    const TetrahedronVolumes* tetrahedra = source.body.tetrahedra;
    if (tetrahedra)
      toLane(tetrahedra->stabilityScale.data(), tetrahedra->stabilityScale.size(), scratch.stabilityScale,
             lane, lanes);
    if (source.revision == source.body.springs->revision && source.substep == dt) continue;
    loadSprings(block, *source.body.springs, lane, lanes);
    loadDampers(block, source.body, dt, lane, lanes);
    if (source.body.volumes) loadVolumes(block, *source.body.volumes, lane, lanes);
    if (tetrahedra) loadTetrahedra(block, *tetrahedra, lane, lanes);
    source.revision = source.body.springs->revision;
    source.substep = dt;
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
      solvePositions(self.block.lanes[lane].body, self.points(lane), time, dt);
  }
  static void settle(void* context) {
    const auto& self = *static_cast<const LaneContacts*>(context);
    for (std::size_t lane = 0; lane < self.block.lanes.size(); ++lane)
      solveVelocities(self.block.lanes[lane].body, self.points(lane));
  }
};

/// Prepares the contacts of all lanes. Returns false if no lane can have contacts.
bool prepareContacts(LaneBlock& block, const LaneContacts& contacts) {
  bool any = false;
  for (std::size_t lane = 0; lane < block.lanes.size(); ++lane) {
    SolverBody& body = block.lanes[lane].body;
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
  body.inverseRest = numbers(b.inverseRest), body.stabilityScale = numbers(s.stabilityScale);
  body.modulus = numbers(b.tetrahedronModulus), body.crushModulus = numbers(b.crushModulus);
  return body;
}

kernel::LaneBody laneBody(LaneBlock& b, LaneScratch& s, const kernel::ContactCalls& contacts,
                          double* change) {
  const SpringArrays& springs = *b.lanes[0].body.springs;
  kernel::LaneBody body;
  body.points = static_cast<unsigned>(b.lanes[0].body.points->position.cols());
  body.springs = static_cast<unsigned>(springs.size());
  body.a = springs->a.data(), body.b = springs->b.data();
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
  body.damped = springs->damped;
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
    SolverBody& body = block.lanes[lane].body;
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
  for (LaneBlock::Lane& lane : block.lanes) prepareVolumes(lane.body, tick / substeps);
  reserve(block, scratch, lanes);
  load(block, scratch, tick / substeps, lanes);
  LaneContacts contacts{block, scratch, laneCount(set)};
  const kernel::ContactCalls calls{prepareContacts(block, contacts) ? &contacts : nullptr,
                                   &LaneContacts::stop, &LaneContacts::settle};
  CacheLine change;
  stepPacks(laneBody(block, scratch, calls, change.value), tick, substeps, set);
  unload(block, scratch, lanes, change, tick / substeps);
}

// --- four springs of a body --------------------------------------------------------------------------------

namespace {

std::size_t filledUp(std::size_t springs) { return (springs + 3) / 4 * 4; }

void reserve(SpringBatchArrays& q, std::size_t points, std::size_t springs) {
  for (auto* array : {&q.position, &q.velocity, &q.acceleration, &q.inverseMass, &q.force, &q.earlierForce})
    reserveNumbers(*array, 4 * points);
  for (auto* array : {&q.restLength, &q.extensionStiffness, &q.compressionStiffness, &q.inverseLength,
                      &q.dampHalf, &q.dampFull})
    reserveNumbers(*array, springs);
  q.a.assign(springs, 0);
  q.b.assign(springs, 0);
  q.apart.assign(springs / 4, 1);
}

bool shareNoPoint(const unsigned* a, const unsigned* b) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j)
      if (a[i] == a[j] || a[i] == b[j] || b[i] == a[j] || b[i] == b[j]) return false;
  return true;
}

void loadTopology(SpringBatchArrays& q, const SpringArrays& springs, unsigned points) {
  std::copy(springs->a.begin(), springs->a.end(), q.a.begin());
  std::copy(springs->b.begin(), springs->b.end(), q.b.begin());
  std::fill(q.a.begin() + static_cast<std::ptrdiff_t>(springs.size()), q.a.end(), points);
  std::fill(q.b.begin() + static_cast<std::ptrdiff_t>(springs.size()), q.b.end(), points + 1);
  numbers(q.position)[4 * (points + 1)] = 1.0;
  for (std::size_t g = 0; g < q.apart.size(); ++g) q.apart[g] = shareNoPoint(&q.a[4 * g], &q.b[4 * g]);
}

void loadSprings(SpringBatchArrays& q, const SpringArrays& springs) {
  const auto copy = [](const std::vector<double>& from, AlignedNumbers& to) {
    std::copy(from.begin(), from.end(), numbers(to));
  };
  copy(springs->restLength, q.restLength);
  copy(springs->extensionStiffness, q.extensionStiffness);
  copy(springs->compressionStiffness, q.compressionStiffness);
  copy(springs.dampHalf, q.dampHalf);
  copy(springs.dampFull, q.dampFull);
  q.sameStiffness = springs->extensionStiffness == springs->compressionStiffness;
  q.revision = springs.revision;
}

void toBatches(const Points& from, AlignedNumbers& to) {
  double* target = numbers(to);
  for (Eigen::Index i = 0; i < from.cols(); ++i)
    for (Eigen::Index c = 0; c < 3; ++c) target[4 * i + c] = from(c, i);
}

void fromBatches(AlignedNumbers& from, Points& to) {
  const double* source = numbers(from);
  for (Eigen::Index i = 0; i < to.cols(); ++i)
    for (Eigen::Index c = 0; c < 3; ++c) to(c, i) = source[4 * i + c];
}

void load(SpringBatchArrays& q, const PointState& state, const SpringArrays& springs) {
  const auto points = static_cast<std::size_t>(state.position.cols());
  if (q.position.empty() || q.a.size() != filledUp(springs.size())) {
    reserve(q, points + 2, filledUp(springs.size()));
    loadTopology(q, springs, static_cast<unsigned>(points));
  }
  if (q.revision != springs.revision) loadSprings(q, springs);
  toBatches(state.position, q.position);
  toBatches(state.velocity, q.velocity);
  toBatches(state.acceleration, q.acceleration);
  toBatches(state.inverseMass, q.inverseMass);
}

kernel::VolumeBody batchVolumes(SpringBatchArrays& q, VolumeArrays* volumes) {
  if (!volumes) return {};
  reserveNumbers(q.gradient, q.position.size() * 8);
  reserveNumbers(q.sums, 8 * (*volumes)->restVolume.size());
  kernel::VolumeBody body = volumeBody(*volumes);
  body.gradient = numbers(q.gradient), body.sums = numbers(q.sums);
  return body;
}

kernel::TetrahedronBody batchTetrahedra(SpringBatchArrays& q, const TetrahedronVolumes* tetrahedra) {
  if (!tetrahedra) return {};
  const std::size_t count = filledUp((*tetrahedra)->tetrahedra.size());
  if (q.corners.size() != 4 * count) {
    reserveNumbers(q.inverseRest, count);
    reserveNumbers(q.stabilityScale, count);
    q.corners.assign(4 * count, static_cast<unsigned>(q.position.size() * 2 - 2));
    const unsigned* corners = (*tetrahedra)->tetrahedra.front().data();
    std::copy(corners, corners + 4 * (*tetrahedra)->tetrahedra.size(), q.corners.begin());
    std::copy((*tetrahedra)->inverseRest.begin(), (*tetrahedra)->inverseRest.end(), numbers(q.inverseRest));
  }
  std::copy(tetrahedra->stabilityScale.begin(), tetrahedra->stabilityScale.end(), numbers(q.stabilityScale));
  kernel::TetrahedronBody body = tetrahedronBody(*tetrahedra);
  body.count = static_cast<unsigned>(count);
  body.corners = q.corners.data();
  body.inverseRest = numbers(q.inverseRest), body.stabilityScale = numbers(q.stabilityScale);
  return body;
}

kernel::SpringBatchBody springBatchBody(SolverBody& stepped, const kernel::ContactCalls* contacts) {
  SpringBatchArrays& q = *stepped.springBatches;
  kernel::SpringBatchBody body;
  body.points = static_cast<unsigned>(q.position.size() * 2);
  body.springs = static_cast<unsigned>(q.a.size());
  body.a = q.a.data(), body.b = q.b.data(), body.apart = q.apart.data();
  body.position = numbers(q.position), body.velocity = numbers(q.velocity);
  body.force = numbers(q.force), body.earlierForce = numbers(q.earlierForce);
  body.acceleration = numbers(q.acceleration), body.inverseMass = numbers(q.inverseMass);
  body.restLength = numbers(q.restLength);
  body.extensionStiffness = numbers(q.extensionStiffness);
  // if both are the same, the kernel reads one array less
  body.compressionStiffness = numbers(q.sameStiffness ? q.extensionStiffness : q.compressionStiffness);
  body.inverseLength = numbers(q.inverseLength);
  body.dampHalf = numbers(q.dampHalf), body.dampFull = numbers(q.dampFull);
  body.volumes = batchVolumes(q, stepped.volumes);
  body.tetrahedra = batchTetrahedra(q, stepped.tetrahedra);
  body.damped = (*stepped.springs)->damped;
  body.contacts = contacts;
  return body;
}

}  // namespace

bool canStepSpringBatches() { return isAvailable(InstructionSet::Avx2); }

kernel::SpringBatchBody loadSpringBatches(SolverBody& body, const kernel::ContactCalls* contacts) {
  load(*body.springBatches, *body.points, *body.springs);
  return springBatchBody(body, contacts);
}

void unloadSpringBatches(SolverBody& body) {
  fromBatches(body.springBatches->position, body.points->position);
  fromBatches(body.springBatches->velocity, body.points->velocity);
}

PointView viewOf(SpringBatchArrays& springBatches) {
  return {numbers(springBatches.position), numbers(springBatches.velocity),
          numbers(springBatches.inverseMass), 1, 4};
}

void stepSpringBatches(SolverBody& body, double tick, int substeps) {
  kernel::ContactCalls calls;
  const kernel::SpringBatchBody springBatches = loadSpringBatches(body, &calls);
  BodyContacts contacts{&body, viewOf(*body.springBatches)};
  calls = contacts.calls();
  const double change = kernel::stepSpringBatches(springBatches, tick, substeps);
  unloadSpringBatches(body);
  body.errorRate = verletErrorRate(change, body.points->position.cols(), tick / substeps);
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
// Copies a body into the arrays of the kernel that computes four springs at a time, and back.
#include "solver/simd_steps.h"

#include "solver/lane_kernels.h"

#if !defined(LIMBER_HAS_X86_LANES) && !defined(LIMBER_HAS_NEON_LANES)
namespace limber::kernel {
// never called, see canStepSpringBatches()
double stepSpringBatches(const SpringBatchBody&, double, int) { return 0.0; }
void computeBatchForces(const SpringBatchBody&, double) {}
void dampBatch(const SpringBatchBody&, bool, bool) {}
void clearBatchForces(const SpringBatchBody&, const BatchPoints&) {}
void addBatchSprings(const SpringBatchBody&, unsigned, unsigned, double) {}
void addBatchVolumes(const SpringBatchBody&) {}
void addBatchTetrahedra(const SpringBatchBody&, unsigned, unsigned) {}
void kickBatchPoints(const SpringBatchBody&, double, const BatchPoints&) {}
void driftBatchPoints(const SpringBatchBody&, double, const BatchPoints&) {}
void dampBatchSprings(const SpringBatchBody&, bool, bool, unsigned, unsigned) {}
void stopBatchPoints(const PlaneBody&, unsigned, unsigned, double, double) {}
void settleBatchPoints(const PlaneBody&, unsigned, unsigned) {}
void loadSlots(const SpringBatchBody&, const BatchPoints&, unsigned) {}
void unloadSlots(const SpringBatchBody&, const BatchPoints&, unsigned) {}
}  // namespace limber::kernel
#endif

namespace limber {
namespace {

using kernel::StripBody;

std::size_t filledUp(std::size_t springs) { return (springs + 3) / 4 * 4; }

/// Returns the number of springs with those that fill up batches.
std::size_t entriesOf(const SpringArrays& springs) {
  const Strips& strips = springs->division.strips;
  return strips.length > 0 ? 4 * strips.batches.size() : filledUp(springs.size());
}

void reserve(SpringBatchArrays& q, std::size_t points, std::size_t springs) {
  for (auto* array : {&q.position, &q.velocity, &q.acceleration, &q.inverseMass, &q.force, &q.earlierForce})
    reserveNumbers(*array, 4 * points);
  for (auto* array : {&q.restLength, &q.extensionStiffness, &q.compressionStiffness, &q.inverseLength,
                      &q.dampHalf, &q.dampFull})
    reserveNumbers(*array, springs);
  q.springs = springs;
}

bool shareNoPoint(const unsigned* a, const unsigned* b) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j)
      if (a[i] == a[j] || a[i] == b[j] || b[i] == a[j] || b[i] == b[j]) return false;
  return true;
}

void loadBatches(SpringBatchArrays& q, const SpringArrays& springs, unsigned points) {
  q.a.assign(springs->a.begin(), springs->a.end());
  q.b.assign(springs->b.begin(), springs->b.end());
  q.a.resize(q.springs, points);
  q.b.resize(q.springs, points + 1);
  q.apart.resize(q.springs / 4);
  for (std::size_t g = 0; g < q.apart.size(); ++g) q.apart[g] = shareNoPoint(&q.a[4 * g], &q.b[4 * g]);
}

void loadStrips(SpringBatchArrays& q, const Strips& strips) {
  reserveNumbers(q.slots, StripBody::kNumbers * (strips.length + std::size_t{1}));
  q.a.resize(strips.batches.size());
  q.b.resize(strips.batches.size());
  for (std::size_t i = 0; i < strips.batches.size(); ++i) {
    const Strips::Batch& batch = strips.batches[i];
    q.a[i] = StripBody::kNumbers * batch.a;
    q.b[i] = StripBody::kNumbers * batch.b + batch.shift;
  }
}

void loadTopology(SpringBatchArrays& q, const SpringArrays& springs, unsigned points) {
  reserve(q, points + 2, entriesOf(springs));
  numbers(q.position)[4 * (points + 1)] = 1.0;
  if (springs->division.strips.length > 0)
    loadStrips(q, springs->division.strips);
  else
    loadBatches(q, springs, points);
}

void loadSprings(SpringBatchArrays& q, const SpringArrays& springs) {
  const std::vector<std::uint32_t>& places = springs->division.strips.places;
  const auto copy = [&](const std::vector<double>& from, AlignedNumbers& to) {
    if (places.empty())
      std::copy(from.begin(), from.end(), numbers(to));
    else
      for (std::size_t i = 0; i < from.size(); ++i) numbers(to)[places[i]] = from[i];
  };
  copy(springs->restLength, q.restLength);
  copy(springs->extensionStiffness, q.extensionStiffness);
  copy(springs->compressionStiffness, q.compressionStiffness);
  copy(springs.dampHalf, q.dampHalf);
  copy(springs.dampFull, q.dampFull);
  if (springs->kinked) {
    reserveNumbers(q.stretch, q.springs);
    reserveNumbers(q.crossingLoss, q.springs);
    copy(springs.crossingLoss, q.crossingLoss);
  }
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
  if (q.position.empty() || q.springs != entriesOf(springs))
    loadTopology(q, springs, static_cast<unsigned>(state.position.cols()));
  if (q.revision != springs.revision) loadSprings(q, springs);
  toBatches(state.position, q.position);
  toBatches(state.velocity, q.velocity);
  toBatches(state.acceleration, q.acceleration);
  toBatches(state.inverseMass, q.inverseMass);
}

void setVolumes(SpringBatchArrays& q, kernel::Volumes<double>& volumes) {
  reserveNumbers(q.gradient, q.position.size() * 8);
  reserveNumbers(q.sums, std::size_t{8} * volumes.components);
  volumes.gradient = numbers(q.gradient), volumes.sums = numbers(q.sums);
}

void setTetrahedra(SpringBatchArrays& q, const TetrahedronVolumes& from, kernel::Tetrahedra<double>& to) {
  const std::size_t count = filledUp(to.count);
  if (q.corners.size() != 4 * count) {
    reserveNumbers(q.inverseRest, count);
    reserveNumbers(q.stabilityScale, count);
    q.corners.assign(4 * count, static_cast<unsigned>(q.position.size() * 2 - 2));
    std::copy_n(to.corners, std::size_t{4} * to.count, q.corners.begin());
    std::copy(from->inverseRest.begin(), from->inverseRest.end(), numbers(q.inverseRest));
  }
  std::copy(from.stabilityScale.begin(), from.stabilityScale.end(), numbers(q.stabilityScale));
  to.count = static_cast<unsigned>(count);
  to.corners = q.corners.data();
  to.inverseRest = numbers(q.inverseRest), to.stabilityScale = numbers(q.stabilityScale);
}

StripBody stripBody(SpringBatchArrays& q, const SolverBody& body) {
  const std::uint32_t length = (*body.springs)->division.strips.length;
  if (length == 0) return {};
  return {length, static_cast<unsigned>(body.points->position.cols()), numbers(q.slots)};
}

kernel::SpringBatchBody springBatchBody(SolverBody& stepped) {
  SpringBatchArrays& q = *stepped.springBatches;
  kernel::SpringBatchBody body{kernelBody(stepped), q.apart.data(), stripBody(q, stepped)};
  const bool kinked = (*stepped.springs)->kinked;
  body.springs = {static_cast<unsigned>(q.springs), q.a.data(), q.b.data(), numbers(q.restLength),
                  numbers(q.extensionStiffness),
                  // if both are the same, the kernel reads one array less
                  numbers(kinked ? q.compressionStiffness : q.extensionStiffness), numbers(q.inverseLength),
                  kinked ? numbers(q.stretch) : nullptr, kinked ? numbers(q.crossingLoss) : nullptr};
  body.points = {static_cast<unsigned>(q.position.size() * 2),
                 numbers(q.position),
                 numbers(q.velocity),
                 numbers(q.force),
                 numbers(q.acceleration),
                 numbers(q.inverseMass)};
  body.earlierForce = numbers(q.earlierForce);
  body.dampHalf = numbers(q.dampHalf), body.dampFull = numbers(q.dampFull);
  if (body.volumes.components > 0) setVolumes(q, body.volumes);
  if (stepped.tetrahedra) setTetrahedra(q, *stepped.tetrahedra, body.tetrahedra);
  return body;
}

}  // namespace

bool canStepSpringBatches() { return isAvailable(InstructionSet::Avx2) || isAvailable(InstructionSet::Neon); }

kernel::SpringBatchBody loadSpringBatches(SolverBody& body) {
  load(*body.springBatches, *body.points, *body.springs);
  const kernel::SpringBatchBody loaded = springBatchBody(body);
  kernel::loadSlots(loaded, {0, loaded.strips.slots}, StripBody::kInverseMass);
  return loaded;
}

void packPlanes(SolverBody& body) {
  body.packed = nullptr;
  if (!body.contacts || body.contacts->empty()) return;
  body.packed = &body.springBatches->planes;
  packPlanes(*body.contacts, static_cast<std::uint32_t>(body.points->position.cols()), *body.packed);
}

void unloadSpringBatches(SolverBody& body) {
  fromBatches(body.springBatches->position, body.points->position);
  fromBatches(body.springBatches->velocity, body.points->velocity);
  if (body.packed) unpackPlanes(*body.packed, *body.contacts);
  body.packed = nullptr;
}

PointView viewOf(SpringBatchArrays& springBatches) {
  return {numbers(springBatches.position),
          numbers(springBatches.velocity),
          numbers(springBatches.inverseMass),
          1,
          4,
          numbers(springBatches.force),
          numbers(springBatches.earlierForce)};
}

}  // namespace limber

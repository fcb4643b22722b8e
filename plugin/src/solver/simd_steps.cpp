// SPDX-License-Identifier: Zlib

// This file copies bodies into the lanes of the kernels of lane_kernels.h, or a body into the arrays of the
// kernel that computes four springs at a time, steps them and copies them back.

#include "solver/simd_steps.h"

#include "solver/lane_kernels.h"

#include <cstring>
#include <initializer_list>

namespace limber {

// --- instruction sets --------------------------------------------------------------------------------------

int laneCount(InstructionSet set) {
  constexpr int kCount[] = {1, 2, 4, 8, 2};
  return kCount[static_cast<int>(set)];
}

bool isAvailable(InstructionSet set) {
#if defined(LIMBER_HAS_X86_LANES)
  if (set == InstructionSet::Sse2) return true;
  if (set == InstructionSet::Avx2) return __builtin_cpu_supports("avx2");
  if (set == InstructionSet::Avx512) return __builtin_cpu_supports("avx512f");
#elif defined(LIMBER_HAS_NEON_LANES)
  if (set == InstructionSet::Neon) return true;
#endif
  return set == InstructionSet::Scalar;
}

InstructionSet bestInstructionSet() {
  for (const InstructionSet set :
       {InstructionSet::Avx512, InstructionSet::Avx2, InstructionSet::Sse2, InstructionSet::Neon})
    if (isAvailable(set)) return set;
  return InstructionSet::Scalar;
}

const char* nameOf(InstructionSet set) {
  constexpr const char* kName[] = {"scalar", "SSE2", "AVX2", "AVX-512", "NEON"};
  return kName[static_cast<int>(set)];
}

// --- several bodies at once --------------------------------------------------------------------------------

namespace {

/// Bodies in lanes. The first one provides the constants that all share.
struct Lanes {
  SolverBody* const* bodies;
  std::size_t used;   ///< number of bodies
  std::size_t count;  ///< number of lanes
  LaneScratch& scratch;

  SolverBody& first() const { return *bodies[0]; }
  PointView points(std::size_t lane) const {
    const int stride = static_cast<int>(count);
    return {numbers(scratch.position) + lane, numbers(scratch.velocity) + lane,
            numbers(scratch.inverseMass) + lane, stride, 3 * stride};
  }
};

void reserve(const Lanes& lanes) {
  LaneScratch& s = lanes.scratch;
  const SolverBody& first = lanes.first();
  const auto points = static_cast<std::size_t>(first.points->position.cols());
  for (auto* array : {&s.position, &s.velocity, &s.acceleration, &s.inverseMass, &s.force, &s.earlierForce,
                      &s.start, &s.gradient})
    reserveNumbers(*array, 3 * points * lanes.count);
  reserveNumbers(s.direction, 3 * first.springs->size() * lanes.count);
  if ((*first.springs)->kinked) reserveNumbers(s.stretch, first.springs->size() * lanes.count);
  if (first.volumes) reserveNumbers(s.sums, 4 * (*first.volumes)->restVolume.size() * lanes.count);
  if (first.tetrahedra)
    reserveNumbers(s.stabilityScale, first.tetrahedra->stabilityScale.size() * lanes.count);
  reserveNumbers(s.motion, sizeof(MotionSums) / sizeof(double) * lanes.count);
}

/// `from`: Points or a vector of numbers.
template <class Numbers>
void toLane(const Numbers& from, AlignedNumbers& to, std::size_t lane, std::size_t lanes) {
  double* target = numbers(to) + lane;
  const double* source = from.data();
  for (std::size_t i = 0, count = static_cast<std::size_t>(from.size()); i < count; ++i)
    target[i * lanes] = source[i];
}

void fromLane(const AlignedNumbers& from, std::size_t lane, std::size_t lanes, std::size_t count,
              double* to) {
  const double* source = from.front().value + lane;
  for (std::size_t i = 0; i < count; ++i) to[i] = source[i * lanes];
}

/// Copies the states of the bodies. A lane without a body gets that of the first one, without contacts.
void load(const Lanes& lanes) {
  LaneScratch& s = lanes.scratch;
  for (std::size_t lane = 0; lane < lanes.count; ++lane) {
    const SolverBody& body = *lanes.bodies[lane < lanes.used ? lane : 0];
    const PointState& state = *body.points;
    toLane(state.position, s.position, lane, lanes.count);
    toLane(state.velocity, s.velocity, lane, lanes.count);
    toLane(state.acceleration, s.acceleration, lane, lanes.count);
    toLane(state.inverseMass, s.inverseMass, lane, lanes.count);
    if (body.tetrahedra) toLane(body.tetrahedra->stabilityScale, s.stabilityScale, lane, lanes.count);
  }
  const auto count = 3 * lanes.first().points->position.cols() * static_cast<Eigen::Index>(lanes.count);
  if (lanes.first().sums) std::copy_n(numbers(s.position), count, numbers(s.start));
}

/// The drag and the contacts that are not in planes.
struct LaneContacts final : kernel::ContactCalls {
  const Lanes& lanes;

  explicit LaneContacts(const Lanes& stepped) : lanes(stepped) {}

  void stop(double time, double dt) override {
    for (std::size_t lane = 0; lane < lanes.used; ++lane) {
      SolverBody& body = *lanes.bodies[lane];
      if (lanes.scratch.inPlanes[lane])
        solveUnpredicted(body, lanes.points(lane), time, dt);
      else
        solvePositions(body, lanes.points(lane), time, dt);
    }
  }
  void drag(double dt) override {
    for (std::size_t lane = 0; lane < lanes.used; ++lane)
      applyDrag(*lanes.bodies[lane], lanes.points(lane), dt);
  }
  void settle() override {
    for (std::size_t lane = 0; lane < lanes.used; ++lane) {
      SolverBody& body = *lanes.bodies[lane];
      if (lanes.scratch.inPlanes[lane])
        settleUnpredicted(body, lanes.points(lane));
      else
        solveVelocities(body, lanes.points(lane));
    }
  }
};

/// Which contacts and drags bodies in lanes have.
struct LaneNeeds {
  bool calls = false;    ///< in each substep: drag, or contacts that are not in planes
  bool watches = false;  ///< search regions
};

LaneNeeds prepareContacts(const Lanes& lanes) {
  LaneNeeds needs;
  for (std::size_t lane = 0; lane < lanes.used; ++lane) {
    SolverBody& body = *lanes.bodies[lane];
    startDrag(body);
    const bool touches = body.contacts && !body.contacts->empty();
    if (touches) prepareContacts(*body.contacts, lanes.points(lane));
    lanes.scratch.inPlanes[lane] = touches && areFixedPlanes(*body.contacts);
    needs.calls = needs.calls || body.drag || (touches && !lanes.scratch.inPlanes[lane]);
    needs.watches = needs.watches || (body.watch && body.watch->on);
  }
  return needs;
}

/// Held points, and bodies without a watch, have no region to leave.
void loadRegions(const Lanes& lanes) {
  LaneScratch& s = lanes.scratch;
  const auto points = static_cast<std::size_t>(lanes.first().points->position.cols());
  reserveNumbers(s.regionCenter, 3 * points * lanes.count);
  reserveNumbers(s.regionDistance, points * lanes.count);
  std::fill_n(numbers(s.regionDistance), points * lanes.count, HUGE_VAL);
  for (std::size_t lane = 0; lane < lanes.used; ++lane) {
    const SolverBody& body = *lanes.bodies[lane];
    if (!body.watch || !body.watch->on) continue;
    const ContactWatch::Regions regions = body.watch->regions();
    toLane(*regions.center, s.regionCenter, lane, lanes.count);
    for (std::size_t i = 0; i < points; ++i)
      if (!body.points->inverseMass.col(static_cast<Eigen::Index>(i)).isZero(0.0))
        numbers(s.regionDistance)[i * lanes.count + lane] = (*regions.distance)[i];
  }
}

// --- fixed planes in lanes ---

constexpr unsigned kNoPlane = static_cast<unsigned>(-1);

/// Numbers the points of any lane that have a plane, in order of their first appearance.
void numberPlanes(const Lanes& lanes) {
  LaneScratch& s = lanes.scratch;
  s.planePoints.clear();
  s.planeOf.assign(static_cast<std::size_t>(lanes.first().points->position.cols()), kNoPlane);
  for (std::size_t lane = 0; lane < lanes.used; ++lane) {
    if (!s.inPlanes[lane]) continue;
    for (const PlaneContact& row : *lanes.bodies[lane]->contacts) {
      if (s.planeOf[row.point] != kNoPlane) continue;
      s.planeOf[row.point] = static_cast<unsigned>(s.planePoints.size());
      s.planePoints.push_back(row.point);
    }
  }
}

/// Calls visit(row, index of its first number in `planes`) for all contacts in `planes`.
template <class Visit>
void forEachPlane(const Lanes& lanes, Visit visit) {
  const LaneScratch& s = lanes.scratch;
  for (std::size_t lane = 0; lane < lanes.used; ++lane)
    if (s.inPlanes[lane])
      for (PlaneContact& row : *lanes.bodies[lane]->contacts)
        visit(row, s.planeOf[row.point] * kPlaneNumbers * lanes.count + lane);
}

void loadPlanes(const Lanes& lanes) {
  LaneScratch& s = lanes.scratch;
  numberPlanes(lanes);
  const std::size_t count = s.planePoints.size() * kPlaneNumbers * lanes.count;
  reserveNumbers(s.planes, count);
  if (count > 0) std::fill_n(numbers(s.planes), count, 0.0);
  forEachPlane(lanes, [&](PlaneContact& row, std::size_t first) {
    toLane(row, numbers(s.planes) + first, lanes.count);
  });
}

void unloadPlanes(const Lanes& lanes) {
  forEachPlane(lanes, [&](PlaneContact& row, std::size_t first) {
    fromLane(numbers(lanes.scratch.planes) + first, lanes.count, row);
  });
}

/// Returns the first body, with the arrays that differ between the bodies in lanes.
kernel::Body<double> laneBody(const Lanes& lanes) {
  LaneScratch& s = lanes.scratch;
  kernel::Body<double> body = kernelBody(lanes.first());
  body.points = {body.points.count, numbers(s.position),     numbers(s.velocity),
                 numbers(s.force),  numbers(s.acceleration), numbers(s.inverseMass)};
  body.earlierForce = numbers(s.earlierForce);
  body.springs.direction = numbers(s.direction);
  if (body.springs.stretch) body.springs.stretch = numbers(s.stretch);
  if (body.volumes.components > 0)
    body.volumes.gradient = numbers(s.gradient), body.volumes.sums = numbers(s.sums);
  if (body.tetrahedra.count > 0) body.tetrahedra.stabilityScale = numbers(s.stabilityScale);
  if (!s.planePoints.empty())
    body.planes = {static_cast<kernel::Index>(s.planePoints.size()), s.planePoints.data(),
                   reinterpret_cast<kernel::Plane<double>*>(numbers(s.planes))};
  return body;
}

/// Returns the arguments of motionSums().
kernel::MovedPoints<double> movedPoints(const Lanes& lanes, const kernel::Body<double>& body) {
  LaneScratch& s = lanes.scratch;
  const RestShape& rest = *lanes.first().rest;
  return {body.points.count,    body.points.position,
          body.points.velocity, body.points.inverseMass,
          numbers(s.start),     rest.fractions.data(),
          rest.weighted.data(), reinterpret_cast<MotionSums*>(numbers(s.motion))};
}

/// Returns the kernel of a set that is available; nullptr for Scalar.
kernel::LaneStep* laneStep(InstructionSet set) {
#if defined(LIMBER_HAS_X86_LANES)
  if (set == InstructionSet::Sse2) return kernel::stepSse2;
  if (set == InstructionSet::Avx2) return kernel::stepAvx2;
  if (set == InstructionSet::Avx512) return kernel::stepAvx512;
#elif defined(LIMBER_HAS_NEON_LANES)
  if (set == InstructionSet::Neon) return kernel::stepNeon;
#endif
  return static_cast<void>(set), nullptr;
}

void unload(const Lanes& lanes, const CacheLine& change, double dt) {
  for (std::size_t lane = 0; lane < lanes.used; ++lane) {
    SolverBody& body = *lanes.bodies[lane];
    PointState& state = *body.points;
    const auto count = static_cast<std::size_t>(state.position.size());
    fromLane(lanes.scratch.position, lane, lanes.count, count, state.position.data());
    fromLane(lanes.scratch.velocity, lane, lanes.count, count, state.velocity.data());
    if (body.sums)
      fromLane(lanes.scratch.motion, lane, lanes.count, sizeof(MotionSums) / sizeof(double), body.sums->low);
    body.errorRate = verletErrorRate(change.value[lane], state.position.cols(), dt);
  }
  unloadPlanes(lanes);
}

/// Returns the address of the constants that bodies share, or nullptr without such a part.
template <class Part>
const void* constantsOf(const Part* part) {
  return part ? part->operator->() : nullptr;
}

bool haveSameBits(const Points& a, const Points& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

}  // namespace

bool canShareLanes(const SolverBody& a, const SolverBody& b) {
  return constantsOf(a.springs) == constantsOf(b.springs) && a.springs->oneSweep == b.springs->oneSweep &&
         constantsOf(a.volumes) == constantsOf(b.volumes) &&
         constantsOf(a.tetrahedra) == constantsOf(b.tetrahedra) && a.rest == b.rest &&
         haveSameBits(a.points->inverseMass, b.points->inverseMass);
}

void stepLanes(SolverBody* const* bodies, std::size_t count, LaneScratch& scratch, double tick, int substeps,
               InstructionSet set) {
  const double dt = tick / substeps;
  const Lanes lanes{bodies, count, static_cast<std::size_t>(laneCount(set)), scratch};
  prepareSprings(*lanes.first().springs, lanes.first().points->inverseMass, dt);
  for (std::size_t lane = 0; lane < count; ++lane) prepareVolumes(*bodies[lane], dt);
  reserve(lanes);
  load(lanes);
  const LaneNeeds needs = prepareContacts(lanes);
  LaneContacts contacts(lanes);
  contacts.always = needs.calls;
  loadPlanes(lanes);
  kernel::Body<double> body = laneBody(lanes);
  if (needs.calls || needs.watches) body.contacts = &contacts;
  if (needs.watches && !needs.calls) {
    loadRegions(lanes);
    body.regions = {body.points.count, numbers(scratch.regionCenter), numbers(scratch.regionDistance)};
  }
  kernel::MovedPoints<double> moved{};
  if (lanes.first().sums) moved = movedPoints(lanes, body);
  CacheLine change;
  if (kernel::LaneStep* step = laneStep(set))
    step(body, lanes.first().sums ? &moved : nullptr, change.value, tick, substeps);
  unload(lanes, change, dt);
}

// --- four springs at once ----------------------------------------------------------------------------------

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

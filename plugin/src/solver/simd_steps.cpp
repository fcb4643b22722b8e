// SPDX-License-Identifier: Zlib
// Copies bodies into the arrays of the kernels of lane_kernels.h, steps them and copies them back.
#include "solver/simd_steps.h"

#include "solver/verlet_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <initializer_list>

#if !defined(LIMBER_HAS_X86_LANES) && !defined(LIMBER_HAS_NEON_LANES)
namespace limber::kernel {
// never called, see canStepSpringBatches()
double stepSpringBatches(const SpringBatchBody&, double, int) { return 0.0; }
void clearBatchForces(const SpringBatchBody&, const BatchPoints&) {}
void addBatchSprings(const SpringBatchBody&, unsigned, unsigned) {}
void addBatchVolumes(const SpringBatchBody&) {}
void addBatchTetrahedra(const SpringBatchBody&, unsigned, unsigned) {}
void kickBatchPoints(const SpringBatchBody&, double, const BatchPoints&) {}
void driftBatchPoints(const SpringBatchBody&, double, const BatchPoints&) {}
void dampBatchSprings(const SpringBatchBody&, bool, bool, unsigned, unsigned) {}
}  // namespace limber::kernel
#endif

namespace limber {

// --- instruction sets --------------------------------------------------------------------------------------

int laneCount(InstructionSet set) {
  constexpr int kCount[] = {1, 2, 4, 8, 2};
  return kCount[static_cast<int>(set)];
}

bool isAvailable(InstructionSet set) {
#if defined(LIMBER_HAS_X86_LANES)
  switch (set) {
    case InstructionSet::Scalar:
    case InstructionSet::Sse2:
      return true;
    case InstructionSet::Avx2:
      return __builtin_cpu_supports("avx2");
    case InstructionSet::Avx512:
      return __builtin_cpu_supports("avx512f");
    case InstructionSet::Neon:
      return false;
  }
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

kernel::VolumeBody volumeBody(VolumeArrays& volumes) {
  const kernel::Volumes<double> v = kernelVolumes(volumes);
  return {v.components, v.points,      v.firstTriangle, v.corners,  v.componentOf, v.restVolume,
          v.modulus,    v.gasPressure, v.ambient,       v.gradient, v.sums,        v.timeStep};
}

kernel::TetrahedronBody tetrahedronBody(const TetrahedronVolumes& volumes) {
  const kernel::Tetrahedra<double> t = kernelTetrahedra(volumes);
  return {t.count, t.corners, t.inverseRest, t.stabilityScale, t.modulus, t.crushModulus};
}

/// Bodies in lanes. The first one provides the constants that all share.
struct Lanes {
  SolverBody* const* bodies;
  std::size_t used;   ///< number of bodies
  std::size_t count;  ///< number of lanes
  double dt;          ///< s, of a substep
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
  if (first.volumes) reserveNumbers(s.sums, first.volumes->sums.size() * lanes.count);
  reserveNumbers(s.motion, sizeof(MotionSums) / sizeof(double) * lanes.count);
}

void toLane(const Points& from, AlignedNumbers& to, std::size_t lane, std::size_t lanes) {
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
    const PointState& state = *lanes.bodies[lane < lanes.used ? lane : 0]->points;
    toLane(state.position, s.position, lane, lanes.count);
    toLane(state.velocity, s.velocity, lane, lanes.count);
    toLane(state.acceleration, s.acceleration, lane, lanes.count);
    toLane(state.inverseMass, s.inverseMass, lane, lanes.count);
  }
  const auto count = 3 * lanes.first().points->position.cols() * static_cast<Eigen::Index>(lanes.count);
  if (lanes.first().sums) std::copy_n(numbers(s.position), count, numbers(s.start));
}

void stopInLanes(void* context, double time, double dt) {
  const auto& lanes = *static_cast<const Lanes*>(context);
  for (std::size_t lane = 0; lane < lanes.used; ++lane) {
    SolverBody& body = *lanes.bodies[lane];
    if (lanes.scratch.inPlanes[lane])
      solveUnpredicted(body, lanes.points(lane), time, dt);
    else
      solvePositions(body, lanes.points(lane), time, dt);
  }
}

void dragInLanes(void* context) {
  const auto& lanes = *static_cast<const Lanes*>(context);
  for (std::size_t lane = 0; lane < lanes.used; ++lane)
    applyDrag(*lanes.bodies[lane], lanes.points(lane), lanes.dt);
}

void settleInLanes(void* context) {
  const auto& lanes = *static_cast<const Lanes*>(context);
  for (std::size_t lane = 0; lane < lanes.used; ++lane) {
    SolverBody& body = *lanes.bodies[lane];
    if (lanes.scratch.inPlanes[lane])
      settleUnpredicted(body, lanes.points(lane));
    else
      solveVelocities(body, lanes.points(lane));
  }
}

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

constexpr std::size_t kPlaneNumbers = sizeof(kernel::Plane<double>) / sizeof(double);
constexpr std::size_t kFirstResult = offsetof(kernel::Plane<double>, least) / sizeof(double);

double* numbersOf(kernel::Plane<double>& plane) { return plane.normal; }

kernel::Plane<double> planeOf(const PlaneContact& row) {
  kernel::Plane<double> plane{};
  for (Eigen::Index c = 0; c < 3; ++c) {
    plane.normal[c] = row.normal[c];
    plane.touch[c] = row.touch[c];
    plane.surfaceVelocity[c] = row.surfaceVelocity[c];
    plane.impulse[c] = row.impulse.sum[c];
    plane.pressing[c] = row.impulse.pressing[c];
  }
  plane.along = row.impulse.along;
  plane.friction = row.friction, plane.recoverySpeed = row.recoverySpeed, plane.mass = row.mass;
  return plane;
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
    kernel::Plane<double> plane = planeOf(row);
    for (std::size_t i = 0; i < kPlaneNumbers; ++i)
      numbers(s.planes)[first + i * lanes.count] = numbersOf(plane)[i];
  });
}

void unloadPlanes(const Lanes& lanes) {
  forEachPlane(lanes, [&](PlaneContact& row, std::size_t first) {
    kernel::Plane<double> plane{};
    for (std::size_t i = kFirstResult; i < kPlaneNumbers; ++i)
      numbersOf(plane)[i] = numbers(lanes.scratch.planes)[first + i * lanes.count];
    row.impulse.sum = Eigen::Vector3d::Map(plane.impulse);
    row.impulse.pressing = Eigen::Vector3d::Map(plane.pressing);
    row.impulse.along = plane.along;
    row.touching = plane.least == 0.0;
  });
}

kernel::VolumeBody laneVolumes(const Lanes& lanes) {
  if (!lanes.first().volumes) return {};
  kernel::VolumeBody body = volumeBody(*lanes.first().volumes);
  body.gradient = numbers(lanes.scratch.gradient), body.sums = numbers(lanes.scratch.sums);
  return body;
}

kernel::LaneBody laneBody(const Lanes& lanes, const kernel::ContactCalls& contacts, double* change) {
  LaneScratch& s = lanes.scratch;
  const SolverBody& first = lanes.first();
  const SpringArrays& springs = *first.springs;
  kernel::LaneBody body{};
  body.points = static_cast<unsigned>(first.points->position.cols());
  body.springs = static_cast<unsigned>(springs.size());
  body.a = springs->a.data(), body.b = springs->b.data();
  body.position = numbers(s.position), body.velocity = numbers(s.velocity);
  body.force = numbers(s.force), body.earlierForce = numbers(s.earlierForce);
  body.acceleration = numbers(s.acceleration), body.inverseMass = numbers(s.inverseMass);
  body.restLength = springs->restLength.data();
  body.extensionStiffness = springs->extensionStiffness.data();
  body.compressionStiffness = springs->compressionStiffness.data();
  body.direction = numbers(s.direction);
  body.damped = springs->damped;
  body.dampHalf = springs.dampHalf.data(), body.dampFull = springs.dampFull.data();
  body.volumes = laneVolumes(lanes);
  if (first.tetrahedra) body.tetrahedra = tetrahedronBody(*first.tetrahedra);
  body.planes = static_cast<unsigned>(s.planePoints.size()), body.planePoints = s.planePoints.data();
  if (body.planes > 0) body.planeNumbers = numbers(s.planes);
  body.contacts = &contacts;
  body.change = change;
  if (!first.sums) return body;
  body.start = numbers(s.start);
  body.fractions = first.rest->fractions.data(), body.weightedRest = first.rest->weighted.data();
  body.sums = numbers(s.motion);
  return body;
}

void stepPacks(const kernel::LaneBody& body, double tick, int substeps, InstructionSet set) {
#if defined(LIMBER_HAS_X86_LANES)
  switch (set) {
    case InstructionSet::Sse2:
      return kernel::stepSse2(body, tick, substeps);
    case InstructionSet::Avx2:
      return kernel::stepAvx2(body, tick, substeps);
    case InstructionSet::Avx512:
      return kernel::stepAvx512(body, tick, substeps);
    case InstructionSet::Scalar:
    case InstructionSet::Neon:
      break;
  }
#elif defined(LIMBER_HAS_NEON_LANES)
  if (set == InstructionSet::Neon) return kernel::stepNeon(body, tick, substeps);
#endif
  static_cast<void>(body), static_cast<void>(tick), static_cast<void>(substeps), static_cast<void>(set);
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
  return constantsOf(a.springs) == constantsOf(b.springs) &&
         constantsOf(a.volumes) == constantsOf(b.volumes) &&
         constantsOf(a.tetrahedra) == constantsOf(b.tetrahedra) && a.rest == b.rest &&
         haveSameBits(a.points->inverseMass, b.points->inverseMass);
}

void stepLanes(SolverBody* const* bodies, std::size_t count, LaneScratch& scratch, double tick, int substeps,
               InstructionSet set) {
  const double dt = tick / substeps;
  const Lanes lanes{bodies, count, static_cast<std::size_t>(laneCount(set)), dt, scratch};
  prepareDampers(*lanes.first().springs, lanes.first().points->inverseMass, dt);
  prepareVolumes(lanes.first(), dt);
  reserve(lanes);
  load(lanes);
  const LaneNeeds needs = prepareContacts(lanes);
  const kernel::ContactCalls calls{needs.calls || needs.watches ? const_cast<Lanes*>(&lanes) : nullptr,
                                   needs.calls, &stopInLanes, &dragInLanes, &settleInLanes};
  loadPlanes(lanes);
  CacheLine change;
  kernel::LaneBody body = laneBody(lanes, calls, change.value);
  if (needs.watches && !needs.calls) {
    loadRegions(lanes);
    body.regionCenter = numbers(scratch.regionCenter), body.regionDistance = numbers(scratch.regionDistance);
  }
  stepPacks(body, tick, substeps, set);
  unload(lanes, change, dt);
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

bool canStepSpringBatches() { return isAvailable(InstructionSet::Avx2) || isAvailable(InstructionSet::Neon); }

kernel::SpringBatchBody loadSpringBatches(SolverBody& body, const kernel::ContactCalls* contacts) {
  load(*body.springBatches, *body.points, *body.springs);
  return springBatchBody(body, contacts);
}

void unloadSpringBatches(SolverBody& body) {
  fromBatches(body.springBatches->position, body.points->position);
  fromBatches(body.springBatches->velocity, body.points->velocity);
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

void stepSpringBatches(SolverBody& body, double tick, int substeps) {
  kernel::ContactCalls calls{};
  const kernel::SpringBatchBody springBatches = loadSpringBatches(body, &calls);
  BodyContacts contacts{&body, viewOf(*body.springBatches), tick / substeps};
  calls = contacts.calls();
  const double change = kernel::stepSpringBatches(springBatches, tick, substeps);
  unloadSpringBatches(body);
  body.errorRate = verletErrorRate(change, body.points->position.cols(), tick / substeps);
}

}  // namespace limber

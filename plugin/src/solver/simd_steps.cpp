// SPDX-License-Identifier: Zlib
// Copies bodies into the lanes of the kernels of lane_kernels.h, steps them and copies them back.
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

}  // namespace limber

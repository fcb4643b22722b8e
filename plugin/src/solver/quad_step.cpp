// SPDX-License-Identifier: Zlib
#include "solver/quad_step.h"

#include "solver/body_contacts.h"
#include "solver/instruction_set.h"
#include "solver/kernel_views.h"
#include "solver/lane_kernels.h"

#include <algorithm>

#if !defined(LIMBER_HAS_LANES)
namespace limber::kernel {
// never called, see canStepQuads()
double stepQuads(const QuadBody&, double, int) { return 0.0; }
void computeQuadForces(const QuadBody&) {}
double computeQuadForcesAndChange(const QuadBody&) { return 0.0; }
void kickQuads(const QuadBody&, double) {}
void driftQuads(const QuadBody&, double) {}
void dampQuads(const QuadBody&, bool, bool) {}
}  // namespace limber::kernel
#endif

namespace limber {
namespace {

std::size_t filledUp(std::size_t springs) { return (springs + 3) / 4 * 4; }

void reserve(QuadArrays& q, std::size_t points, std::size_t springs) {
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

void loadTopology(QuadArrays& q, const SpringArrays& springs, unsigned points) {
  std::copy(springs.a.begin(), springs.a.end(), q.a.begin());
  std::copy(springs.b.begin(), springs.b.end(), q.b.begin());
  std::fill(q.a.begin() + static_cast<std::ptrdiff_t>(springs.size()), q.a.end(), points);
  std::fill(q.b.begin() + static_cast<std::ptrdiff_t>(springs.size()), q.b.end(), points + 1);
  numbers(q.position)[4 * (points + 1)] = 1.0;
  for (std::size_t g = 0; g < q.apart.size(); ++g) q.apart[g] = shareNoPoint(&q.a[4 * g], &q.b[4 * g]);
}

void loadSprings(QuadArrays& q, const SpringArrays& springs) {
  const auto copy = [](const std::vector<double>& from, AlignedNumbers& to) {
    std::copy(from.begin(), from.end(), numbers(to));
  };
  copy(springs.restLength, q.restLength);
  copy(springs.extensionStiffness, q.extensionStiffness);
  copy(springs.compressionStiffness, q.compressionStiffness);
  copy(springs.dampHalf, q.dampHalf);
  copy(springs.dampFull, q.dampFull);
  q.sameStiffness = springs.extensionStiffness == springs.compressionStiffness;
  q.revision = springs.revision;
}

void toQuads(const Points& from, AlignedNumbers& to) {
  double* target = numbers(to);
  for (Eigen::Index i = 0; i < from.cols(); ++i)
    for (Eigen::Index c = 0; c < 3; ++c) target[4 * i + c] = from(c, i);
}

void fromQuads(AlignedNumbers& from, Points& to) {
  const double* source = numbers(from);
  for (Eigen::Index i = 0; i < to.cols(); ++i)
    for (Eigen::Index c = 0; c < 3; ++c) to(c, i) = source[4 * i + c];
}

void load(QuadArrays& q, const PointState& state, const SpringArrays& springs) {
  const auto points = static_cast<std::size_t>(state.position.cols());
  if (q.position.empty() || q.a.size() != filledUp(springs.size())) {
    reserve(q, points + 2, filledUp(springs.size()));
    loadTopology(q, springs, static_cast<unsigned>(points));
  }
  if (q.revision != springs.revision) loadSprings(q, springs);
  toQuads(state.position, q.position);
  toQuads(state.velocity, q.velocity);
  toQuads(state.acceleration, q.acceleration);
  toQuads(state.inverseMass, q.inverseMass);
}

kernel::VolumeBody quadVolumes(QuadArrays& q, VolumeArrays* volumes) {
  if (!volumes) return {};
  reserveNumbers(q.gradient, q.position.size() * 8);
  reserveNumbers(q.sums, 8 * volumes->restVolume.size());
  kernel::VolumeBody body = volumeBody(*volumes);
  body.gradient = numbers(q.gradient), body.sums = numbers(q.sums);
  return body;
}

kernel::TetrahedronBody quadTetrahedra(QuadArrays& q, const TetrahedronVolumes* tetrahedra) {
  if (!tetrahedra) return {};
  const std::size_t count = filledUp(tetrahedra->tetrahedra.size());
  if (q.corners.size() != 4 * count) {
    reserveNumbers(q.inverseRest, count);
    reserveNumbers(q.hold, count);
    q.corners.assign(4 * count, static_cast<unsigned>(q.position.size() * 2 - 2));
    const unsigned* corners = tetrahedra->tetrahedra.front().data();
    std::copy(corners, corners + 4 * tetrahedra->tetrahedra.size(), q.corners.begin());
    std::copy(tetrahedra->inverseRest.begin(), tetrahedra->inverseRest.end(), numbers(q.inverseRest));
  }
  std::copy(tetrahedra->hold.begin(), tetrahedra->hold.end(), numbers(q.hold));
  kernel::TetrahedronBody body = tetrahedronBody(*tetrahedra);
  body.count = static_cast<unsigned>(count);
  body.corners = q.corners.data();
  body.inverseRest = numbers(q.inverseRest), body.hold = numbers(q.hold);
  return body;
}

kernel::QuadBody quadBody(SteppedBody& stepped, const kernel::ContactCalls* contacts) {
  QuadArrays& q = *stepped.quads;
  kernel::QuadBody body;
  body.points = static_cast<unsigned>(q.position.size() * 2);
  body.springs = static_cast<unsigned>(q.a.size());
  body.a = q.a.data(), body.b = q.b.data(), body.apart = q.apart.data();
  body.position = numbers(q.position), body.velocity = numbers(q.velocity);
  body.force = numbers(q.force), body.earlierForce = numbers(q.earlierForce);
  body.acceleration = numbers(q.acceleration), body.inverseMass = numbers(q.inverseMass);
  body.restLength = numbers(q.restLength);
  body.extensionStiffness = numbers(q.extensionStiffness);
  // one array less to read
  body.compressionStiffness = numbers(q.sameStiffness ? q.extensionStiffness : q.compressionStiffness);
  body.inverseLength = numbers(q.inverseLength);
  body.dampHalf = numbers(q.dampHalf), body.dampFull = numbers(q.dampFull);
  body.volumes = quadVolumes(q, stepped.volumes);
  body.tetrahedra = quadTetrahedra(q, stepped.tetrahedra);
  body.damped = stepped.springs->damped;
  body.contacts = contacts;
  return body;
}

}  // namespace

bool canStepQuads() { return isAvailable(InstructionSet::Avx2); }

kernel::QuadBody loadQuads(SteppedBody& body, const kernel::ContactCalls* contacts) {
  load(*body.quads, *body.points, *body.springs);
  return quadBody(body, contacts);
}

void unloadQuads(SteppedBody& body) {
  fromQuads(body.quads->position, body.points->position);
  fromQuads(body.quads->velocity, body.points->velocity);
}

PointView viewOf(QuadArrays& quads) {
  return {numbers(quads.position), numbers(quads.velocity), numbers(quads.inverseMass), 1, 4};
}

void stepQuads(SteppedBody& body, double tick, int substeps) {
  kernel::ContactCalls calls;
  const kernel::QuadBody quads = loadQuads(body, &calls);
  BodyContacts contacts{&body, viewOf(*body.quads)};
  calls = contacts.calls();
  const double change = kernel::stepQuads(quads, tick, substeps);
  unloadQuads(body);
  body.errorRate = verletErrorRate(change, body.points->position.cols(), tick / substeps);
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "bullet/step_plan.h"

#include "bullet/group_stepping.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// A block of more springs than this would not stay in the cache next to the processor (about 0.5 kB a spring
/// with eight lanes); such bodies are stepped one by one.
constexpr std::size_t kLargestInLanes = 1000;

bool fitsLanes(const TickGroup& group) {
  return !hasTolerance(group) && group.stepper == Stepper::Verlet && isPlain(group.step) &&
         group.bodies[0]->springs.size() <= kLargestInLanes && group.bodies[0]->springs.size() > 0;
}

/// Bodies side by side go through the same triangles and tetrahedra.
int volumeKind(const SoftBodyData& body) {
  if (body.volumes.empty() && body.tetrahedra.empty()) return 0;
  return body.settings.scale.prod() < 0.0 ? -1 : 1;
}

}  // namespace

bool StepPlan::Candidate::fitsWith(const Candidate& other) const {
  return std::tie(network, substeps, damped, volumes) ==
         std::tie(other.network, other.substeps, other.damped, other.volumes);
}

bool StepPlan::Candidate::operator<(const Candidate& other) const {
  return std::tie(network, substeps, damped, volumes, group) <
         std::tie(other.network, other.substeps, other.damped, other.volumes, other.group);
}

void StepPlan::clear() {
  blocks_.clear();
  networkOf_.clear();
}

void StepPlan::number(const std::vector<TickGroup>& groups) {
  std::map<const SpringNetwork*, std::size_t> numbers;
  for (const TickGroup& group : groups) {
    const SpringNetwork* network = group.bodies.empty() ? nullptr : group.bodies[0]->network.get();
    networkOf_.push_back(numbers.try_emplace(network, numbers.size()).first->second);
  }
}

void StepPlan::stepOrCollect(std::vector<TickGroup>& groups, double tick) {
  candidates_.clear();
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups[i].asleep || groups[i].clustered) continue;
    if (fitsLanes(groups[i]))
      candidates_.push_back({networkOf_[i], groups[i].substeps, groups[i].bodies[0]->springs.damped,
                             volumeKind(*groups[i].bodies[0]), i});
    else
      stepGroup(groups[i], tick, factors_);
  }
  std::sort(candidates_.begin(), candidates_.end());
}

void StepPlan::stepBlock(std::vector<TickGroup>& groups, std::size_t begin, std::size_t end, double tick) {
  if (blocksUsed_ == blocks_.size()) blocks_.emplace_back();
  LaneBlock& block = blocks_[blocksUsed_++];
  block.lanes.resize(end - begin);
  for (std::size_t i = begin; i < end; ++i) {
    const SteppedBody& body = groups[candidates_[i].group].step.bodies[0];
    LaneBlock::Lane& lane = block.lanes[i - begin];
    if (lane.body.points != body.points) lane.revision = 0;
    lane.body = body;
  }
  stepLanes(block, scratch_, tick, candidates_[begin].substeps, set_);
  for (std::size_t i = begin; i < end; ++i)
    groups[candidates_[i].group].step.bodies[0].errorRate = block.lanes[i - begin].body.errorRate;
}

/// Bodies that are alone in their block have nothing to gain from it.
void StepPlan::stepRun(std::vector<TickGroup>& groups, std::size_t begin, std::size_t end, double tick) {
  const auto lanes = static_cast<std::size_t>(laneCount(set_));
  for (std::size_t i = begin; i < end; i += lanes) {
    const std::size_t stop = std::min(i + lanes, end);
    if (stop - i > 1)
      stepBlock(groups, i, stop, tick);
    else
      stepGroup(groups[candidates_[i].group], tick, factors_);
  }
}

void StepPlan::step(std::vector<TickGroup>& groups, double tick) {
  if (networkOf_.size() != groups.size()) number(groups);
  stepOrCollect(groups, tick);
  blocksUsed_ = 0;
  for (std::size_t begin = 0, end; begin < candidates_.size(); begin = end) {
    end = begin + 1;
    while (end < candidates_.size() && candidates_[end].fitsWith(candidates_[begin])) ++end;
    stepRun(groups, begin, end, tick);
  }
  for (TickGroup& group : groups)
    if (!group.asleep && !group.clustered) repeatIfMissed(group, tick, factors_);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "bullet/lone_groups.h"

#include "bullet/body_in_world.h"
#include "bullet/body_medium.h"
#include "bullet/surface_body.h"

#include <algorithm>
#include <cstddef>
#include <tuple>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Maximum number of springs of bodies in SIMD lanes. A block of larger ones would not fit into the cache
/// nearest to the processor (about 0.5 kB per spring with eight lanes). They are stepped one by one.
constexpr std::size_t kMaxSpringsInLanes = 1000;

/// A block has at most so many groups, and ends with the group by which it has so many springs: 64 bodies of
/// 8 points take 0.5 MB.
constexpr std::size_t kBlockGroups = 64, kBlockSprings = 4000;

bool canUseLanes(const LinkedGroup& group) {
  return !hasTolerance(group) && group.stepper == Stepper::Verlet && isPlain(group.step) &&
         group.bodies[0]->springs.size() <= kMaxSpringsInLanes && group.bodies[0]->springs.size() > 0;
}

/// Whether several threads can step the group together.
bool isDivided(const LinkedGroup& group) {
  const auto isLarge = [](const SoftBodyData* body) { return body->springs->division.isDivided(); };
  return group.stepper == Stepper::Verlet && std::any_of(group.bodies.begin(), group.bodies.end(), isLarge);
}

void countWork(const SoftBodyData& body, TickProfile& work) {
  const auto substeps = static_cast<std::size_t>(body.substeps);
  work.pointsStepped += pointCount(body);
  work.substeps += substeps;
  work.springSubsteps += body.springs.size() * substeps;
  work.contacts += body.contacts.size();
}

/// Adds the work of blocks. Their times are shares of `wallMs`: several threads may have stepped them at the
/// same time.
void addBlocks(const TickProfile& blocks, double wallMs, TickProfile& profile) {
  TickProfile work = blocks;
  const double sum = blocks.chooseMs + blocks.stepMs + blocks.writeMs;
  for (double TickProfile::*time : {&TickProfile::chooseMs, &TickProfile::stepMs, &TickProfile::writeMs})
    if (sum > 0.0) work.*time *= wallMs / sum;
  profile += work;
}

}  // namespace

void writeGroup(LinkedGroup& group, btScalar tick, TickProfile& work) {
  reportStepping(group, double(tick));
  for (SoftBodyData* body : group.bodies) {
    removeWaterMass(*body, double(tick));
    restoreIfUnsound(*body);
    countWork(*body, work);
  }
  writeGroupToBullet(group, tick);
  if (!group.inIsland) numberIsland(group.bodies);
}

// --- blocks ------------------------------------------------------------------------------------------------

void LoneGroups::collect(const AwakeGroups& groups) {
  lone_.clear();
  for (LinkedGroup* group : groups)
    if (!group->inIsland) lone_.push_back(group);
}

/// The work is that of the last tick: it only decides which threads step the group.
void LoneGroups::takeLarge() {
  double total = 0.0;
  for (const LinkedGroup* group : lone_) total += workOf(*group);
  const auto isSmall = [&](const LinkedGroup* group) {
    return !isDivided(*group) || workOf(*group) < kLargeShare * total;
  };
  const auto end = std::partition(lone_.begin(), lone_.end(), isSmall);
  large_.assign(end, lone_.end());
  lone_.erase(end, lone_.end());
}

void LoneGroups::stepLarge(double tick, const Parallel& parallel, TickProfile& profile) {
  LapTimer timer;
  for (LinkedGroup* group : large_) {
    chooseStepping(*group, tick);
    profile.chooseMs += timer.lap();
    parallel.together([&](Team& team) {
      group->step.team = &team;
      stepAlone(*group, tick, factors_);
      group->step.team = nullptr;
    });
    profile.stepMs += timer.lap();
    writeGroup(*group, static_cast<btScalar>(tick), profile);
    profile.writeMs += timer.lap();
  }
}

void LoneGroups::makeBlocks() {
  const auto before = [](const LinkedGroup* a, const LinkedGroup* b) {
    return std::tie(a->model, a) < std::tie(b->model, b);
  };
  if (!std::is_sorted(lone_.begin(), lone_.end(), before)) std::sort(lone_.begin(), lone_.end(), before);
  blocks_.clear();
  std::size_t springs = 0;
  for (std::size_t i = 0; i < lone_.size(); ++i) {
    if (blocks_.empty() || springs >= kBlockSprings || i - blocks_.back() == kBlockGroups) {
      blocks_.push_back(i);
      springs = 0;
    }
    springs += springCount(lone_[i]->bodies);
  }
  blocks_.push_back(lone_.size());
}

void LoneGroups::makeRuns(Block& block) const {
  AwakeGroups& groups = block.groups;
  const auto others = std::partition(groups.begin(), groups.end(),
                                     [](const LinkedGroup* group) { return canUseLanes(*group); });
  block.forLanes = static_cast<std::size_t>(others - groups.begin());
  const auto before = [](const LinkedGroup* a, const LinkedGroup* b) {
    return std::tie(a->model, a->substeps, a) < std::tie(b->model, b->substeps, b);
  };
  std::sort(groups.begin(), others, before);
  const auto fits = [](const LinkedGroup& a, const LinkedGroup& b) {
    return a.substeps == b.substeps && canShareLanes(a.step.bodies[0], b.step.bodies[0]);
  };
  const auto lanes = static_cast<std::size_t>(laneCount(set_));
  block.runs.clear();
  for (std::size_t i = 0, begin = 0; i < groups.size(); ++i) {
    const bool goesOn =
        i > begin && i < begin + lanes && i < block.forLanes && fits(*groups[begin], *groups[i]);
    if (goesOn) continue;
    begin = i;
    block.runs.push_back(i);
  }
  block.runs.push_back(groups.size());
}

/// A body that is alone in its lanes gains nothing from them.
void LoneGroups::stepRun(Block& block, std::size_t run, double tick) {
  const std::size_t begin = block.runs[run], end = block.runs[run + 1];
  AwakeGroups& groups = block.groups;
  if (end == begin + 1) return stepAlone(*groups[begin], tick, factors_);
  block.bodies.clear();
  for (std::size_t i = begin; i < end; ++i) block.bodies.push_back(&groups[i]->step.bodies[0]);
  stepLanes(block.bodies.data(), block.bodies.size(), block.lanes, tick, groups[begin]->substeps, set_);
  for (std::size_t i = begin; i < end; ++i) {
    groups[i]->bodies[0]->sumsValid = groups[i]->step.bodies[0].sums != nullptr;
    repeatIfMissed(*groups[i], tick, factors_);
  }
}

void LoneGroups::stepBlock(Block& block, double tick) {
  LapTimer timer;
  for (LinkedGroup* group : block.groups) chooseStepping(*group, tick);
  block.work.chooseMs = timer.lap();
  makeRuns(block);
  for (std::size_t run = 0; run + 1 < block.runs.size(); ++run) stepRun(block, run, tick);
  block.work.stepMs = timer.lap();
  for (LinkedGroup* group : block.groups) writeGroup(*group, static_cast<btScalar>(tick), block.work);
  block.work.writeMs = timer.lap();
}

void LoneGroups::step(const AwakeGroups& groups, double tick, const Parallel& parallel,
                      TickProfile& profile) {
  collect(groups);
  large_.clear();
  if (parallel.isOn()) takeLarge();
  stepLarge(tick, parallel, profile);
  makeBlocks();
  sum_ = TickProfile();
  LapTimer timer;
  parallel.forEach(blocks_.size() - 1, [&](std::size_t b) {
    scratch_.with([&](Block& block) {
      const auto first = lone_.begin();
      block.groups.assign(first + static_cast<std::ptrdiff_t>(blocks_[b]),
                          first + static_cast<std::ptrdiff_t>(blocks_[b + 1]));
      block.work = TickProfile();
      stepBlock(block, tick);
      const std::lock_guard<std::mutex> guard(lock_);
      sum_ += block.work;
    });
  });
  addBlocks(sum_, timer.lap(), profile);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

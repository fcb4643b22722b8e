// SPDX-License-Identifier: Zlib
#include "accuracy/targets.h"

#include "accuracy/convergence.h"
#include "text_format.h"

#include <algorithm>

namespace limber::bench {
namespace {

std::string verdict(bool hit) { return hit ? "hit " : "MISS"; }

/// The largest error among Limber's rows of some scenes must not exceed a bound.
struct ErrorTarget {
  const char* what;
  const char* scenes;  ///< start of their names
  const char* measure;
  const char* setting;
  bool usualTickOnly;
  double bound;
};

const ErrorTarget kErrorTargets[] = {
    {"sag of chains of any stiffness at any tick", "hanging chain", "sag", "auto", false, 1e-4},
    {"sag of a chain with 10 000 x end mass", "chain with", "sag", "auto", false, 1e-4},
    {"period, 30 ticks a period, as set by default", "oscillator", "period", "auto", true, 1e-4},
    {"period, stepping.periodTolerance = 1e-4", "oscillator", "period", "auto 1e-04", true, 1e-4},
    {"amplitude after 10 periods, by default", "oscillator", "amplitude", "auto", true, 1e-3},
    {"rest height, frictionless, any floor (m)", "rest on", "height", "auto", true, 1e-6},
    {"contact forces over weight, less 1", "rest on", "force", "auto", true, 1e-4},
    {"rebound of a dropped cube", "dropped cube", "rebound", "auto", true, 0.05},
    {"rebound speed of a bar from a wall", "bar against", "rebound", "auto", true, 0.05},
    {"rebound speed of a braced bar from a wall", "braced bar", "rebound", "auto", true, 0.05},
    {"incline, 1.03 mu: acceleration", "incline 1.03", "acceleration", "auto", true, 5e-3},
    {"incline, 0.97 mu: way in a second (m)", "incline 0.97", "creep", "auto", true, 1e-5},
};

std::string lineOf(const ErrorTarget& target, const Rows& rows) {
  const auto found = worst(select(rows, [&](const AccuracyRow& row) {
    return isLimber(row, target.setting) && startsWith(row.scene, target.scenes) &&
           row.measure == target.measure && (!target.usualTickOnly || isUsual(row));
  }));
  if (!found) return {};
  return format("  %s  %-50s <= %7.1e: %9.2e  (%s, 1/%.0f s)\n",
                verdict(found->error <= target.bound).c_str(), target.what, target.bound, found->error,
                found->scene.c_str(), 1 / found->dt);
}

/// An error that many times smaller than the best of btSoftBody's, in no more time: Limber's springs against
/// btSoftBody's whole tick, with Limber's whole tick beside it.
struct RatioTarget {
  const char* scenes;
  double ratio;
};

const RatioTarget kRatioTargets[] = {{"spinning cube", 100},     {"falling chain", 100},
                                     {"falling chain", 1000},    {"block cantilever", 100},
                                     {"block cantilever", 1000}, {"cloth", 100}};

std::string ratioText(const AccuracyRow& own, const AccuracyRow& soft, double ratio) {
  const bool hit = own.error * ratio <= soft.error && own.stepMicroseconds <= soft.tickMicroseconds;
  return verdict(hit) +
         format("  %-20s 1/%-4.0f of %-17s: 1/%-8.3g with limber %-9s us %.1f of %.1f (whole tick %.1f)\n",
                own.scene.c_str(), ratio, soft.setting.c_str(), soft.error / own.error, own.setting.c_str(),
                own.stepMicroseconds, soft.tickMicroseconds, own.tickMicroseconds);
}

/// Limber by default, and where that misses the best it can do in the time.
std::string ratioLines(const Rows& scene, double ratio) {
  const auto soft = best(select(scene, [](const AccuracyRow& row) { return row.engine == "btSoftBody"; }));
  const Rows limber = select(scene, [](const AccuracyRow& row) { return isLimber(row, "auto"); });
  if (!soft || limber.empty()) return {};
  std::string text = "  " + ratioText(limber[0], *soft, ratio);
  const auto other = best(select(scene, [&](const AccuracyRow& row) {
    return row.engine == "limber" && row.stepMicroseconds <= soft->tickMicroseconds;
  }));
  if (text.find("MISS") != std::string::npos && other && other->error < limber[0].error)
    text += "     in time: " + ratioText(*other, *soft, ratio);
  return text;
}

std::string ratioTargets(const Rows& rows) {
  std::string text;
  for (const RatioTarget& target : kRatioTargets)
    for (const auto& subject : subjects(rows))
      if (startsWith(subject.first, target.scenes))
        text += ratioLines(
            select(rows, [&](const AccuracyRow& row) { return row.scene == subject.first && isUsual(row); }),
            target.ratio);
  return text;
}

std::string orderTarget(const Rows& rows) {
  std::string text;
  for (const SubstepOrder& order : substepOrders(rows))
    if (order.kind == Kind::Free)
      text += format("  %s  order in free motion >= 1.9: %5.2f  (%s)\n", verdict(order.slope >= 1.9).c_str(),
                     order.slope, order.scene.c_str());
  return text;
}

}  // namespace

std::string targetTable(const Rows& rows) {
  std::string text = "\ntargets\n" + ratioTargets(rows);
  for (const ErrorTarget& target : kErrorTargets) text += lineOf(target, rows);
  return text + orderTarget(rows);
}

}  // namespace limber::bench

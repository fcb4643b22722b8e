// SPDX-License-Identifier: Zlib
#include "accuracy/accuracy_report.h"

#include "text_format.h"

#include <algorithm>

namespace limber::bench {
namespace {

std::string verdict(bool hit) { return hit ? "hit " : "MISS"; }

/// A bound for the largest error among Limber's rows of some scenes.
struct ErrorTarget {
  const char* title;
  const char* scenes;  ///< prefix of their names
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
    {"speed kept on tiled floors, 0.1 to 20 m/s", "slide on", "speed", "auto", true, 1e-3},
    {"hops on tiled floors (m)", "slide on", "hop", "auto", true, 1e-3},
    {"rolling on tiled floors beside one box (radii)", "roll on", "path", "auto", true, 1e-6},
    {"slope of 30 degrees, mu 0.2: acceleration", "slope of", "cube", "auto", true, 5e-3},
    {"frictionless cloth on that slope: acceleration", "slope of", "cloth", "auto", true, 5e-3},
};

std::string lineOf(const ErrorTarget& target, const Rows& rows) {
  const auto largest = worst(select(rows, [&](const AccuracyRow& row) {
    return isLimber(row, target.setting) && startsWith(row.scene, target.scenes) &&
           row.measure == target.measure && (!target.usualTickOnly || isUsual(row));
  }));
  if (!largest) return {};
  return format("  %s  %-50s <= %7.1e: %9.2e  (%s, 1/%.0f s)\n",
                verdict(largest->error <= target.bound).c_str(), target.title, target.bound, largest->error,
                largest->scene.c_str(), 1 / largest->dt);
}

/// Limber's error must be smaller than the best of btSoftBody by this ratio, in no more time. The time of
/// Limber's springs is compared with btSoftBody's whole tick; Limber's whole tick is also printed.
struct RatioTarget {
  const char* scenes;
  double ratio;
};

const RatioTarget kRatioTargets[] = {{"spinning cube", 100},     {"falling chain", 100},
                                     {"falling chain", 1000},    {"block cantilever", 100},
                                     {"block cantilever", 1000}, {"cloth", 100}};

std::string ratioText(const AccuracyRow& limberRow, const AccuracyRow& soft, double ratio) {
  const bool hit =
      limberRow.error * ratio <= soft.error && limberRow.stepMicroseconds <= soft.tickMicroseconds;
  return verdict(hit) +
         format("  %-20s 1/%-4.0f of %-17s: 1/%-8.3g with limber %-9s us %.1f of %.1f (whole tick %.1f)\n",
                limberRow.scene.c_str(), ratio, soft.setting.c_str(), soft.error / limberRow.error,
                limberRow.setting.c_str(), limberRow.stepMicroseconds, soft.tickMicroseconds,
                limberRow.tickMicroseconds);
}

/// Returns the result of Limber's default setting. If that misses the target, adds its best result in the
/// same time.
std::string ratioLines(const Rows& scene, double ratio) {
  const auto soft = best(select(scene, [](const AccuracyRow& row) { return row.engine == "btSoftBody"; }));
  const Rows limber = select(scene, [](const AccuracyRow& row) { return isLimber(row, "auto"); });
  if (!soft || limber.empty()) return {};
  std::string text = "  " + ratioText(limber[0], *soft, ratio);
  const auto inTime = best(select(scene, [&](const AccuracyRow& row) {
    return row.engine == "limber" && row.stepMicroseconds <= soft->tickMicroseconds;
  }));
  if (text.find("MISS") != std::string::npos && inTime && inTime->error < limber[0].error)
    text += "     in time: " + ratioText(*inTime, *soft, ratio);
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

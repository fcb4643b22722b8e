// SPDX-License-Identifier: Zlib
#include "stability/stability_summary.h"

#include "machine.h"
#include "text_format.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace limber::bench {
namespace {

using Rows = std::vector<StabilityRow>;
using Condition = std::function<bool(const StabilityRow&)>;

Rows select(const Rows& rows, const Condition& condition) {
  Rows chosen;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(chosen), condition);
  return chosen;
}

long count(const Rows& rows, const Condition& condition) {
  return std::count_if(rows.begin(), rows.end(), condition);
}

template <class Key>
std::vector<Key> unique(const Rows& rows, const std::function<Key(const StabilityRow&)>& key) {
  std::vector<Key> found;
  for (const StabilityRow& row : rows)
    if (std::find(found.begin(), found.end(), key(row)) == found.end()) found.push_back(key(row));
  return found;
}

using EngineName = std::pair<std::string, std::string>;  // engine and setting

std::vector<EngineName> enginesOf(const Rows& rows) {
  return unique<EngineName>(rows, [](const StabilityRow& r) { return EngineName(r.engine, r.setting); });
}

bool isShape(const StabilityRow& row, Shape shape) {
  return row.ran() && row.shape && row.shape->shape == shape;
}

/// Returns "3/40": the number of misses, and of rows that were tested.
std::string missRatio(const Rows& rows, const Condition& missed, const Condition& isTested) {
  const long all = count(rows, isTested);
  return all ? format("%ld/%ld", count(rows, missed), all) : std::string("-");
}

bool ran(const StabilityRow& row) { return row.ran(); }

std::string lineOf(const std::string& group, const EngineName& engine, const Rows& rows) {
  const auto lost = [](const StabilityRow& r) { return r.ran() && !r.finite; };
  const auto hasDrift = [](const StabilityRow& r) { return r.ran() && r.drift.has_value(); };
  const auto hasSpin = [](const StabilityRow& r) { return r.ran() && r.spinDrift.has_value(); };
  const auto hasShape = [](const StabilityRow& r) { return r.ran() && r.shape.has_value(); };
  const auto hasSide = [](const StabilityRow& r) { return r.ran() && r.wrongSide.has_value(); };
  return format(
      "%-14s %-12s %-17s %6ld %4ld %10s %9s %9s %9s %9s %9s %8ld %6ld %7.1f%%\n", group.c_str(),
      engine.first.c_str(), engine.second.c_str(), count(rows, ran),
      static_cast<long>(rows.size()) - count(rows, ran), missRatio(rows, lost, ran).c_str(),
      missRatio(rows, gainsEnergy, ran).c_str(), missRatio(rows, drifts, hasDrift).c_str(),
      missRatio(rows, losesSpin, hasSpin).c_str(), missRatio(rows, staysMisshapen, hasShape).c_str(),
      missRatio(rows, endsWrong, hasSide).c_str(),
      count(rows, [](const StabilityRow& r) { return isShape(r, Shape::Mirrored); }),
      count(rows, isHeldElsewhere),
      100.0 * static_cast<double>(count(rows, passes)) / static_cast<double>(std::max(1L, count(rows, ran))));
}

std::string heading() {
  return format("%-14s %-12s %-17s %6s %4s %10s %9s %9s %9s %9s %9s %8s %6s %8s\n", "group", "engine",
                "setting", "runs", "n/a", "non-finite", "energy", "momentum", "angular", "shape", "side",
                "mirrored", "held", "passed");
}

std::string table(const Rows& rows) {
  std::string text = heading();
  const auto groups = unique<std::string>(rows, [](const StabilityRow& r) { return r.group; });
  const auto ofEngine = [](const Rows& from, const EngineName& engine) {
    return select(from, [&](const StabilityRow& r) { return EngineName(r.engine, r.setting) == engine; });
  };
  for (const std::string& group : groups) {
    const Rows own = select(rows, [&](const StabilityRow& r) { return r.group == group; });
    for (const EngineName& engine : enginesOf(own)) text += lineOf(group, engine, ofEngine(own, engine));
  }
  text += "\n" + heading();
  for (const EngineName& engine : enginesOf(rows)) text += lineOf("all", engine, ofEngine(rows, engine));
  return text;
}

struct Target {
  const char* name;
  Condition missed, isTested;
};

std::vector<Target> targets() {
  return {{"non-finite: none", [](const StabilityRow& r) { return r.ran() && !r.finite; }, ran},
          {"energy at most 1.001 of start and work", gainsEnergy, ran},
          {"momentum drift at most 1e-6 in free flight", drifts,
           [](const StabilityRow& r) { return r.ran() && r.drift.has_value(); }},
          {"angular momentum within 1e-3 in free flight", losesSpin,
           [](const StabilityRow& r) { return r.ran() && r.spinDrift.has_value(); }},
          {"back in shape within 1e-3 of the size", staysMisshapen,
           [](const StabilityRow& r) { return r.ran() && r.shape.has_value(); }},
          {"on the right side of what was hit", endsWrong,
           [](const StabilityRow& r) { return r.ran() && r.wrongSide.has_value(); }}};
}

std::string targetLines(const Rows& rows) {
  std::string text = "\ntargets (missed of asked)\n";
  for (const Target& target : targets())
    for (const EngineName& engine : enginesOf(rows)) {
      if (engine.first != "limber") continue;
      const Rows own = select(
          rows, [&](const StabilityRow& r) { return r.engine == "limber" && r.setting == engine.second; });
      if (count(own, target.isTested) == 0) continue;
      const long missed = count(own, target.missed);
      text += format("  %-4s  %-45s limber %-9s %s\n", missed ? "MISS" : "hit", target.name,
                     engine.second.c_str(), missRatio(own, target.missed, target.isTested).c_str());
    }
  return text;
}

std::string flawsOf(const StabilityRow& row) {
  std::string text;
  if (!row.finite) return " non-finite";
  if (gainsEnergy(row)) text += format(" energy %.6gx (rounding %.1e)", row.energyRatio, row.rounding);
  if (drifts(row)) text += format(" drift %.2e", *row.drift);
  if (losesSpin(row)) text += format(" angular momentum off by %.2e", *row.spinDrift);
  if (staysMisshapen(row))
    text += format(" shape %s: off by %.2e", nameOf(row.shape->shape), row.shape->error);
  if (endsWrong(row)) text += format(" %zu points on the wrong side", *row.wrongSide);
  return text;
}

/// The first miss of a group and stepper; the others are in the CSV file.
std::string missLine(const Rows& missed) {
  const StabilityRow& row = missed[0];
  return format("  %-9s dt 1/%-3.0f %s seed %u:", row.setting.c_str(), 1.0 / row.dt, row.name.c_str(),
                row.seed) +
         flawsOf(row) + (missed.size() > 1 ? format("; %zu more", missed.size() - 1) : "") + "\n";
}

std::string missLines(const Rows& rows) {
  std::string text;
  const Rows missed =
      select(rows, [](const StabilityRow& r) { return r.engine == "limber" && r.ran() && !passes(r); });
  using Key = std::pair<std::string, std::string>;  // group and setting
  const auto key = [](const StabilityRow& r) { return Key(r.group, r.setting); };
  for (const Key& one : unique<Key>(missed, key))
    text += missLine(select(missed, [&](const StabilityRow& r) { return key(r) == one; }));
  return text.empty() ? text : "\nwhere Limber misses: the first of each group\n" + text;
}

std::string reasons(const Rows& rows) {
  std::string text;
  for (const EngineName& engine : enginesOf(rows)) {
    const Rows own = select(
        rows, [&](const StabilityRow& r) { return EngineName(r.engine, r.setting) == engine && !r.ran(); });
    for (const std::string& reason : unique<std::string>(own, [](const StabilityRow& r) { return r.reason; }))
      text += format("  %s %s, %ld runs: ", engine.first.c_str(), engine.second.c_str(),
                     count(own, [&](const StabilityRow& r) { return r.reason == reason; })) +
              reason + "\n";
  }
  return text.empty() ? text : "\nn/a\n" + text;
}

}  // namespace

std::string summariseStability(const std::vector<StabilityRow>& rows) {
  return describeMachine() +
         "\neach case at ticks of 1/30 and 1/60 s. Missed of asked: non-finite; energy above 1.001 of the "
         "start's "
         "and work;\nin free flight, momentum drift above 1e-6 and angular momentum above 1e-3; shape not "
         "within "
         "1e-3 of the size;\npoints on the wrong side of an obstacle. No misses, but counted: mirrored, back "
         "as "
         "mirror image;\nheld, by a balance of all springs or by its spin in another shape.\n\n" +
         table(rows) + targetLines(rows) + missLines(rows) + reasons(rows);
}

}  // namespace limber::bench

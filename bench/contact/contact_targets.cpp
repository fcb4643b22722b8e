// SPDX-License-Identifier: Zlib
#include "contact/contact_targets.h"

#include "contact/contact_engines.h"
#include "text_format.h"

#include <cmath>

namespace limber::bench {
namespace {

using Rows = std::vector<ContactRow>;

constexpr double kRealTime = 1e3 * kContactTick;  // ms

/// Returns nullptr if there is no such row, or it has an error.
const ContactRow* find(const Rows& rows, const std::string& engine, Role role, Crowd crowd = Crowd::Small) {
  for (const ContactRow& row : rows)
    if (row.engine == engine && row.role == role && row.crowd == crowd && row.ran()) return &row;
  return nullptr;
}

std::string line(const std::string& what, const std::optional<double>& value, double limit,
                 const char* unit = "") {
  if (!value) return format("  -     %-62s not measured\n", what.c_str());
  return format("  %-4s  %-62s %.3g%s\n", *value <= limit ? "hit" : "MISS", what.c_str(), *value, unit);
}

std::optional<double> softRatio(const ContactRow* row) { return row ? row->toSoftBody : std::nullopt; }

/// Returns the name of the scene: quick runs have fewer bodies than the target's.
std::string sceneName(const ContactRow* row, const char* fullName) { return row ? row->scene : fullName; }

std::string softBodyLines(const Rows& rows, const std::string& name) {
  const auto ratio = [&](Role role, Crowd crowd, double limit, const char* fullName, const char* text) {
    const ContactRow* row = find(rows, name, role, crowd);
    return line(sceneName(row, fullName) + text, softRatio(row), limit);
  };
  return ratio(Role::Rest, Crowd::Middle, 0.7, "512 cubes rest", ": at most 0.7 of btSoftBody 4 it") +
         ratio(Role::Rest, Crowd::Middle, 0.5, "512 cubes rest", ": at most 0.5 (stretch)") +
         ratio(Role::Rest, Crowd::Large, 0.6, "4096 cubes rest", ": at most 0.6") +
         ratio(Role::Airborne, Crowd::Small, 0.25, "64 cubes airborne", ": at most 0.25") +
         ratio(Role::Airborne, Crowd::Middle, 0.25, "512 cubes airborne", ": at most 0.25") +
         ratio(Role::Airborne, Crowd::Large, 0.25, "4096 cubes airborne", ": at most 0.25") +
         ratio(Role::Cloth, Crowd::Small, 0.5, "cloth", ": at most 0.5") +
         ratio(Role::Cloth, Crowd::Middle, 0.5, "soft cloth", ": at most 0.5");
}

std::string landingLine(const Rows& rows, const std::string& name) {
  const ContactRow* landing = find(rows, name, Role::Landing, Crowd::Middle);
  std::optional<double> share;
  if (landing) share = landing->tickWorst / landing->tickMedian;
  return line(sceneName(landing, "512 cubes landing") + ": worst tick at most 3 times the median", share,
              3.0);
}

std::string sleepLines(const Rows& rows, const std::string& name) {
  std::string text;
  for (const Crowd crowd : {Crowd::Small, Crowd::Middle, Crowd::Large}) {
    const ContactRow *awake = find(rows, name, Role::Rest, crowd),
                     *asleep = find(rows, name, Role::Asleep, crowd);
    std::optional<double> percent;
    if (awake && asleep) percent = 100.0 * asleep->tickMedian / awake->tickMedian;
    text += line(sceneName(asleep, "cubes asleep") + ": at most 2 % of awake", percent, 2.0, " %");
  }
  return text;
}

/// Names only the worst scene.
std::string sphereLine(const Rows& rows, const std::string& name) {
  const ContactRow* worst = nullptr;
  for (const ContactRow& row : rows) {
    if (row.engine != name || !row.toSpheres) continue;
    if (!worst || *row.toSpheres > *worst->toSpheres) worst = &row;
  }
  const std::string what = "faster than loose spheres everywhere" + (worst ? ": " + worst->scene : "");
  return line(what, worst ? worst->toSpheres : std::nullopt, std::nextafter(1.0, 0.0));
}

std::string realTimeLines(const Rows& rows, const std::string& name) {
  const ContactRow *airborne = find(rows, name, Role::Airborne, Crowd::Large),
                   *rest = find(rows, name, Role::Rest, Crowd::RealTime);
  const auto tick = [](const ContactRow* row) {
    return row ? std::optional<double>(row->tickMedian) : std::nullopt;
  };
  return line(sceneName(airborne, "4096 cubes airborne") + ": real time at 60 Hz, 16.67 ms", tick(airborne),
              kRealTime, " ms") +
         line(sceneName(rest, "2560 cubes rest") + ": real time at 60 Hz, 16.67 ms", tick(rest), kRealTime,
              " ms");
}

}  // namespace

std::string contactTargets(const std::vector<ContactRow>& rows) {
  std::string text;
  for (const std::string& name : limberNames())
    text += "\ntargets of " + name + ", one thread, in the same run\n" + softBodyLines(rows, name) +
            landingLine(rows, name) + sleepLines(rows, name) + sphereLine(rows, name) +
            realTimeLines(rows, name);
  return text;
}

}  // namespace limber::bench

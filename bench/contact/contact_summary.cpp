// SPDX-License-Identifier: Zlib
#include "contact/contact_summary.h"

#include "machine.h"
#include "text_format.h"

namespace limber::bench {
namespace {

const char* const kConditions =
    "\nticks of 1/60 s on one thread, in the thread's own time; the engines take turns, in rotating order; "
    "medians "
    "of the\nrepeats. btSoftBody, spheres: times over those of btSoftBody with 4 iterations (with --flags: "
    "of "
    "SDF_RS | VF_SS)\nand of loose spheres in the same run. Deepest: points in rigid bodies or, in the pile, "
    "bodies "
    "in one another,\nof a body's size. Strain: root mean square, of the springs along edges.\n";

std::string ratioText(const std::optional<double>& ratio) {
  return ratio ? format("%.2f", *ratio) : std::string("-");
}

std::string lineOf(const ContactRow& r) {
  if (!r.ran()) return format("  %-22s %s\n", r.engine.c_str(), r.error.c_str());
  const bool moves = r.role == Role::Airborne || r.role == Role::Landing;
  const std::string speed = moves ? "-" : format("%.1e", r.residualSpeed);
  const std::string strain = r.hasSprings ? format("%.2f %%", 100.0 * r.stretch) : "-";
  return format("  %-22s %9.3f %9.3f %8.3f %10s %10s %9.2f %% %10s %9s %6.0f %%\n", r.engine.c_str(),
                r.tickMedian, r.tickWorst, r.microsecondsPerPoint(), ratioText(r.toSoftBody).c_str(),
                ratioText(r.toSpheres).c_str(), 100.0 * r.penetration, speed.c_str(), strain.c_str(),
                100.0 * r.asleep);
}

std::string headingOf(const ContactRow& r) {
  return format("\n%s: %zu %s, %zu points\n  %-22s %9s %9s %8s %10s %10s %11s %10s %9s %8s\n",
                r.scene.c_str(), r.bodies, r.bodies == 1 ? "body" : "bodies", r.points, "", "median ms",
                "worst ms", "us/point", "btSoftBody", "spheres", "deepest", "speed m/s", "strain", "asleep");
}

/// Returns a warning if other processes were busy: through shared caches they affect the thread's times too.
std::string busyWarning(const std::vector<ContactRow>& rows) {
  constexpr double kBusy = 1.1;
  double wall = 0.0, own = 0.0;
  for (const ContactRow& row : rows) {
    wall += row.wallMedian;
    own += row.tickMedian;
  }
  if (wall <= kBusy * own) return {};
  return format("\nWARNING: the machine was busy: ticks took %.2f times their own time\n", wall / own);
}

}  // namespace

std::string summariseContact(const std::vector<ContactRow>& rows) {
  std::string text = describeMachine();
  text += kConditions;
  std::string scene;
  for (const ContactRow& row : rows) {
    if (row.scene != scene) text += headingOf(row);
    scene = row.scene;
    text += lineOf(row);
  }
  return text + busyWarning(rows);
}

}  // namespace limber::bench

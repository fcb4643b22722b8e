// SPDX-License-Identifier: Zlib
#include "accuracy/accuracy_report.h"

#include "accuracy/signals.h"
#include "text_format.h"

#include <algorithm>

namespace limber::bench {
namespace {

constexpr double kRounding = sizeof(btScalar) == sizeof(float) ? 2e-8 : 1e-11;

/// Returns the rows of a scene's first measure.
Rows mainRows(const Rows& rows, const std::string& scene) {
  Rows sceneRows = select(rows, [&](const AccuracyRow& row) { return row.scene == scene; });
  if (sceneRows.empty()) return sceneRows;
  return select(sceneRows,
                [first = sceneRows[0].measure](const AccuracyRow& row) { return row.measure == first; });
}

std::vector<std::string> orderedScenes(const Rows& rows) {
  std::vector<std::string> names;
  for (const AccuracyRow& row : rows)
    if (row.ordered && std::find(names.begin(), names.end(), row.scene) == names.end())
      names.push_back(row.scene);
  return names;
}

/// Returns the order of the errors of one engine and setting.
double tickOrder(const Rows& rows) {
  std::vector<double> steps, errors;
  for (const AccuracyRow& row : rows) {
    steps.push_back(row.dt);
    errors.push_back(row.error);
  }
  return order(steps, errors);
}

std::string tickCell(const Rows& scene, const std::string& engine, const std::string& setting) {
  const double slope = tickOrder(
      select(scene, [&](const AccuracyRow& row) { return row.engine == engine && row.setting == setting; }));
  return std::isfinite(slope) ? format(" %12.2f", slope) : format(" %12s", "-");
}

/// Returns the setting of btSoftBody with the smallest error at the finest tick.
std::string bestSoftBody(const Rows& scene) {
  double finest = 1e9;
  for (const AccuracyRow& row : scene) finest = std::min(finest, row.dt);
  const auto row = best(
      select(scene, [&](const AccuracyRow& r) { return r.engine == "btSoftBody" && r.dt < 1.01 * finest; }));
  return row ? row->setting : "";
}

std::string tickTable(const Rows& rows, Kind kind) {
  std::string text;
  for (const std::string& name : orderedScenes(rows)) {
    const Rows scene = mainRows(rows, name);
    if (scene[0].kind != kind) continue;
    const std::string soft = bestSoftBody(scene);
    text += format("  %-27s", name.c_str()) + tickCell(scene, "limber", "auto") +
            tickCell(scene, "limber", "verlet x8") + tickCell(scene, "btDeformable", "implicit") +
            tickCell(scene, "btDeformable", "explicit") + tickCell(scene, "btSoftBody", soft) + "  " + soft +
            "\n";
  }
  return text;
}

std::string substepTable(const std::vector<SubstepOrder>& orders, Kind kind) {
  std::string text;
  for (const SubstepOrder& order : orders) {
    if (order.kind != kind) continue;
    text += format("  %-27s", order.scene.c_str());
    text += format(" %6.2f ", order.slope);
    for (const double error : order.errors) text += format(" %9.2e", error);
    text += "\n";
  }
  return text;
}

/// Returns the order of the finest three steps with errors above rounding. Coarse steps may be too large to
/// show the order, and rounding hides the smallest errors.
double finestOrder(const std::vector<double>& steps, const std::vector<double>& errors) {
  std::vector<double> lastSteps, lastErrors;
  for (std::size_t i = steps.size(); i-- > 0 && lastSteps.size() < 3;) {
    if (errors[i] < kRounding) continue;
    lastSteps.push_back(steps[i]);
    lastErrors.push_back(errors[i]);
  }
  return order(lastSteps, lastErrors);
}

}  // namespace

std::vector<SubstepOrder> substepOrders(const Rows& rows) {
  std::vector<SubstepOrder> orders;
  for (const std::string& name : orderedScenes(rows)) {
    SubstepOrder entry{name, Kind::Free, {}, 0.0};
    std::vector<double> steps;
    for (const AccuracyRow& row : mainRows(rows, name)) {
      if (!isUsual(row) || row.engine != "limber" || !startsWith(row.setting, "verlet")) continue;
      entry.kind = row.kind;
      entry.errors.push_back(row.error);
      steps.push_back(1.0 / row.substeps);
    }
    if (steps.size() < 2) continue;
    entry.slope = finestOrder(steps, entry.errors);
    orders.push_back(entry);
  }
  return orders;
}

std::string convergenceTables(const Rows& rows) {
  const std::vector<SubstepOrder> orders = substepOrders(rows);
  if (orders.empty()) return {};
  std::string text =
      "\norder with the tick (slope of log error over log dt; Limber's substeps hardly depend on the tick)\n";
  text += format("  %-27s %12s %12s %12s %12s %12s\n", "", "limber auto", "verlet x8", "def. implicit",
                 "def. explicit", "btSoftBody");
  for (const Kind kind : {Kind::Free, Kind::Contact})
    text += std::string(kind == Kind::Free ? " free\n" : " contact\n") + tickTable(rows, kind);
  text += "\norder with Limber's substep (Verlet at 60 ticks a second; slope of the last three)\n";
  text += format("  %-27s %6s  %s\n", "", "order", "errors with 1, 2, 4, 8 ... times the substeps needed");
  for (const Kind kind : {Kind::Free, Kind::Contact})
    text += std::string(kind == Kind::Free ? " free\n" : " contact\n") + substepTable(orders, kind);
  return text;
}

}  // namespace limber::bench

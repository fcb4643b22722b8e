// SPDX-License-Identifier: Zlib
#include "accuracy/accuracy_report.h"

#include "accuracy/accuracy_row.h"
#include "machine.h"
#include "text_format.h"

namespace limber::bench {
namespace {

Rows ofEngine(const Rows& rows, const std::string& engine) {
  return select(rows, [&](const AccuracyRow& row) { return row.engine == engine; });
}

std::string ratio(const std::optional<AccuracyRow>& other, const AccuracyRow& limberRow) {
  if (!other) return format(" %9s", "");
  return format(" %9.3g", other->error / std::max(limberRow.error, 1e-16));
}

std::string cells(const std::optional<AccuracyRow>& row) {
  if (!row) return format(" | %-17s %9s %8s", "", "", "");
  return format(" | %-17s %9.2e %8.1f", row->setting.c_str(), row->error, row->tickMicroseconds);
}

std::string lineOf(const Rows& rows) {
  const Rows limber = select(rows, [](const AccuracyRow& row) { return isLimber(row, "auto"); });
  if (limber.empty()) return {};
  const AccuracyRow& limberRow = limber[0];
  const auto soft = best(ofEngine(rows, "btSoftBody")), deformable = best(ofEngine(rows, "btDeformable"));
  return format("%-29s %-12s %9.2e %8.1f %8.1f", limberRow.scene.c_str(), limberRow.measure.c_str(),
                limberRow.error, limberRow.stepMicroseconds, limberRow.tickMicroseconds) +
         cells(soft) + ratio(soft, limberRow) + cells(deformable) + ratio(deformable, limberRow) + "\n";
}

std::string table(const Rows& rows, Kind kind) {
  std::string text = format("%-29s %-12s %9s %8s %8s | %-17s %9s %8s %9s | %-17s %9s %8s %9s\n", "scene",
                            "error of", "limber", "us step", "us tick", "btSoftBody", "error", "us tick",
                            "ratio", "btDeformable", "error", "us tick", "ratio");
  for (const auto& [scene, measure] : subjects(rows))
    text += lineOf(select(rows, [&, s = scene, m = measure](const AccuracyRow& row) {
      return row.kind == kind && isUsual(row) && row.scene == s && row.measure == m;
    }));
  return text;
}

std::string remarks(const std::vector<Scene>& scenes) {
  std::string text;
  for (const Scene& scene : scenes)
    if (!scene.remark.empty()) text += "  " + scene.name + ": " + scene.remark + "\n";
  return text.empty() ? text : "\nfor orientation\n" + text;
}

}  // namespace

std::string summariseAccuracy(const std::vector<Scene>& scenes, const std::vector<AccuracyRow>& rows) {
  std::string text = describeMachine() + "\n";
  text +=
      "ticks of 1/60 s; limber auto beside the best setting of the others; ratio: their error over "
      "Limber's;\n";
  text += "us tick: median of the world's whole tick; us step: of it, Limber's springs\n";
  text += "\nfree motion\n" + table(rows, Kind::Free);
  text += "\nwith contacts\n" + table(rows, Kind::Contact);
  return text + remarks(scenes) + convergenceTables(rows) + targetTable(rows);
}

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#include "networks/models_table.h"

#include "analysis/analysis.h"
#include "clocks.h"
#include "machine.h"
#include "row_progress.h"
#include "scenes/end_checks.h"
#include "scenes/scene_list.h"
#include "text_format.h"

#include <limber/cook.h>
#include <limber/mesh.h>

#include <algorithm>
#include <stdexcept>

namespace limber::bench {
namespace {

constexpr const char* kModels[] = {"animal", "figure", "teapot", "head", "ogre", "bunny", "car", "puppet"};
constexpr std::uint64_t kModelSeed = 1000;
constexpr std::uint32_t kDropped = 4;
constexpr int kDropTicks = 8 * 60;

std::string fileOf(const std::string& name) { return LIMBER_MESH_DIR "/" + name + ".obj"; }

std::string formOf(const CookedMesh& cooked) {
  const SpringNetwork& network = *cooked.bodies.front().network;
  std::string form = network.kind == NetworkKind::Solid  ? "solid"
                     : network.kind == NetworkKind::Rope ? "rope"
                                                         : "cloth";
  if (cooked.report[1].find("wrapped") != std::string::npos) form += ", wrapped";
  if (cooked.report[1].find("thick as") != std::string::npos) form += ", thickened";
  return form;
}

/// Spreads the runs over all kinds of deformations.
void measureReturnsOf(const SpringNetwork& network, std::uint32_t runs, ModelRow& row) {
  const auto each = static_cast<std::uint32_t>((runs + kDeformations - 1) / kDeformations);
  for (std::size_t kind = 0; kind < kDeformations && each > 0; ++kind) {
    const ReturnRate rate = measureReturns(network, static_cast<Deformation>(kind), each, kModelSeed);
    row.runs += rate.runs;
    row.returned += rate.returned;
  }
}

void drop(const std::string& file, ModelRow& row) {
  scenes::SceneOptions options;
  options.meshFile = file;
  options.count = kDropped;
  const scenes::SceneResult scene = scenes::createMeshDrop(options);
  if (!scene) throw std::runtime_error(scene.error());
  for (int i = 0; i < kDropTicks; ++i) scenes::tick(**scene);
  for (std::size_t b = 0; b < (*scene)->soft->bodyCount(); ++b) {
    const SoftBody& body = *(*scene)->soft->body(b);
    if (body.network().kind == NetworkKind::Solid)
      row.shapeError = std::max(row.shapeError, scenes::shapeError(body).relativeRms);
  }
  row.end = scenes::checkEnd(**scene);
}

ModelRow measureModel(const std::string& name, std::uint32_t runs) {
  const Result<TriangleMesh> mesh = importMesh(fileOf(name));
  if (!mesh) throw std::runtime_error(mesh.error());
  const Stopwatch watch;
  const Result<CookedMesh> cooked = cook(*mesh);
  if (!cooked) throw std::runtime_error(name + ": " + cooked.error());
  ModelRow row;
  row.seconds = 1e-3 * watch.time().cpuMs;
  row.megabytes = peakMegabytes();
  row.mesh = name;
  row.form = formOf(*cooked);
  row.vertices = mesh->positions.size();
  row.bodies = cooked->bodies.size();
  for (const CookedBody& body : cooked->bodies) {
    row.points += body.network->restPoints.size();
    row.springs += body.network->springs.size();
    row.tetrahedra += body.network->tetrahedra.size();
  }
  if (cooked->bodies.front().network->kind == NetworkKind::Solid)
    measureReturnsOf(*cooked->bodies.front().network, runs, row);
  drop(fileOf(name), row);
  return row;
}

std::string returnsOf(const ModelRow& row) {
  return row.runs == 0 ? std::string("-") : format("%u/%u", row.returned, row.runs);
}

}  // namespace

std::vector<ModelRow> measureModels(const std::string& part, std::uint32_t runs) {
  std::vector<ModelRow> rows;
  RowProgress progress;
  for (const std::string name : kModels) {
    if (name.find(part) == std::string::npos) continue;
    progress.show(name, double(rows.size()) / double(std::size(kModels)));
    rows.push_back(measureModel(name, runs));
    progress.finish(name);
  }
  return rows;
}

std::string modelTable(const std::vector<ModelRow>& rows) {
  if (rows.empty()) return {};
  std::string text = "\nany mesh: cooked by cook(), four dropped\n";
  text += format("%-8s %-26s %6s %6s %6s %7s %5s %8s %6s %5s %7s  %s\n", "mesh", "form", "verts", "bodies",
                 "points", "springs", "tets", "returns", "s", "MB", "shape %", "end check");
  for (const ModelRow& r : rows)
    text +=
        format("%-8s %-26s %6zu %6zu %6zu %7zu %5zu %8s %6.1f %5.0f %7.2f  %s\n", r.mesh.c_str(),
               r.form.c_str(), r.vertices, r.bodies, r.points, r.springs, r.tetrahedra, returnsOf(r).c_str(),
               r.seconds, r.megabytes, 100.0 * r.shapeError, r.end.empty() ? "passed" : r.end.c_str());
  return text;
}

std::string modelTargets(const std::vector<ModelRow>& rows) {
  constexpr double kMinReturns = 0.99, kMaxShapeError = 0.01;
  std::string text;
  for (const ModelRow& r : rows) {
    const bool returns = r.runs == 0 || r.returned >= kMinReturns * r.runs;
    const bool hit = returns && r.shapeError <= kMaxShapeError && r.end.empty();
    text += format("  %-4s  %-78s %s, %.2f %%%s\n", hit ? "hit" : "MISS",
                   (r.mesh + ": returns >= 99 %, shape error <= 1 % after a drop").c_str(),
                   returnsOf(r).c_str(), 100.0 * r.shapeError, r.end.empty() ? "" : (", " + r.end).c_str());
  }
  return text;
}

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#include "cook/cook_options.h"

#include "cook/cook_report.h"
#include "cook/network_picture.h"
#include "mesh_reader.h"
#include "output_files.h"
#include "progress.h"
#include "scenes/networks.h"

#include <limber/mesh.h>
#include <limber/parallel.h>
#include <limber/render/png_file.h>
#include <limber/spring_network.h>

#include <chrono>
#include <cstdio>
#include <utility>

namespace limber::demo {
namespace {

TriangleMesh meshOf(WeldedMesh welded) {
  TriangleMesh mesh;
  mesh.positions = std::move(welded.points);
  mesh.triangles = std::move(welded.triangles);
  return mesh;
}

/// Adds a skin to the network: it is drawn as `mesh`, which differs from the mesh of the network.
Result<SharedNetwork> skinned(Result<SharedNetwork> network, const TriangleMesh& mesh,
                              const SkinSettings& settings) {
  return network ? withSkin(**network, mesh, settings) : network;
}

Result<SharedNetwork> cookMaterial(const TriangleMesh& mesh, const CookOptions& options) {
  const double tolerance = options.network.weldTolerance;
  if (tolerance == 0.0 && !options.skin) return buildMaterialNetwork(mesh, options.materialMesh);
  Result<WeldedMesh> welded = weld(mesh, tolerance);
  if (!welded) return Error{welded.error()};
  const SkinSettings skin = options.skin.value_or(SkinSettings{SkinKind::Barycentric, 32, tolerance});
  return skinned(buildMaterialNetwork(meshOf(std::move(*welded)), options.materialMesh), mesh, skin);
}

Result<SharedNetwork> cookSimplified(const TriangleMesh& mesh, WeldedMesh welded,
                                     const CookOptions& options) {
  if (options.network.progress) options.network.progress("simplify", 0.0);
  const Result<TriangleMesh> coarse = simplify(meshOf(std::move(welded)), options.points);
  if (!coarse) return Error{coarse.error()};
  if (options.network.progress) options.network.progress("simplify", 1.0);
  SkinSettings skin = options.skin.value_or(SkinSettings{});
  skin.weldTolerance = options.network.weldTolerance;
  return skinned(buildNetwork(*coarse, options.network), mesh, skin);
}

Result<SharedNetwork> cookMesh(const TriangleMesh& mesh, const CookOptions& options) {
  if (options.material) return cookMaterial(mesh, options);
  if (options.points == 0) return buildNetwork(mesh, options.network);
  Result<WeldedMesh> welded = weld(mesh, options.network.weldTolerance);
  if (!welded) return Error{welded.error()};
  // coarse enough: the vertices then lie on the points themselves
  if (welded->points.size() <= options.points) return buildNetwork(mesh, options.network);
  return cookSimplified(mesh, std::move(*welded), options);
}

}  // namespace

Result<SharedNetwork> cookBody(const CookOptions& options) {
  const Result<TriangleMesh> mesh = readMesh(options.meshFile);
  if (!mesh) return Error{mesh.error()};
  Result<SharedNetwork> network = cookMesh(*mesh, options);
  return network ? network : Error{options.meshFile + ": " + network.error()};
}

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kPatience = 0.3;  // s

ExitCode fail(const std::string& reason) {
  std::fprintf(stderr, "limber-cook: %s\n", reason.c_str());
  return kFailure;
}

/// Checks the output files before the work. Writes nothing.
std::string checkOutputFiles(const CookOptions& options) {
  const std::string none;
  const std::string& body = options.meshFile.empty() ? none : options.bodyFile;
  for (const std::string* file : {&body, &options.jsonFile, &options.pictureFile}) {
    const std::string reason = file->empty() ? std::string() : checkWritable(*file);
    if (!reason.empty()) return reason;
  }
  return {};
}

/// Returns the file of a body: BODY.limber, BODY-2.limber and so on.
std::string fileOfBody(const std::string& file, std::size_t body) {
  const std::string ending = ".limber";
  if (body == 0) return file;
  return file.substr(0, file.size() - ending.size()) + "-" + std::to_string(body + 1) + ending;
}

/// Cooks with cook() and writes all bodies. The report is about the largest one.
std::string makeBodies(const CookOptions& options, CookReport& report) {
  Result<CookedMesh> cooked = scenes::readBodies(options.meshFile, *options.automatic, {});
  if (!cooked) return cooked.error();
  report.network = cooked->bodies.front();
  report.choices.assign(cooked->report.begin(), cooked->report.end());
  for (std::size_t i = 0; i < cooked->bodies.size(); ++i) {
    const std::string file = fileOfBody(options.bodyFile, i);
    if (Result<void> saved = saveNetwork(*cooked->bodies[i], file); !saved) return saved.error();
    if (i > 0) report.choices.push_back("piece: " + file);
  }
  return {};
}

std::string makeBody(const CookOptions& options, CookReport& report) {
  const bool cook = !options.meshFile.empty();
  const Clock::time_point start = Clock::now();
  if (options.automatic) {
    const std::string reason = makeBodies(options, report);
    report.cookSeconds = secondsSince(start);
    return reason;
  }
  Result<SharedNetwork> network = cook ? cookBody(options) : loadNetwork(options.bodyFile);
  if (!network) return network.error();
  report.network = *network;
  report.cookSeconds = secondsSince(start);
  if (cook)
    report.choices.push_back(std::string(options.material ? "tetrahedra" : "braces") + ", because of " +
                             options.byHand);
  return cook ? saveNetwork(*report.network, options.bodyFile).error() : std::string();
}

void analyseBody(CookReport& report) {
  const Clock::time_point start = Clock::now();
  report.analysis = analyse(*report.network, report.settings);
  report.analysisSeconds = secondsSince(start);
}

std::string writeOutput(const CookOptions& options, const CookReport& report) {
  if (!options.quiet) std::fputs(reportText(report).c_str(), stdout);
  if (!options.pictureFile.empty()) {
    render::writePng(options.pictureFile, drawNetwork(*report.network, options.width, options.height));
  }
  return options.jsonFile.empty() ? std::string() : writeText(options.jsonFile, reportJson(report));
}

/// Returns the options with progress shown on `bars`, unless they are quiet.
CookOptions withProgress(CookOptions options, StageProgress& bars) {
  if (options.quiet) return options;
  const limber::Progress progress = [&bars](const char* what, double done) {
    bars.show(what, done);
    return true;
  };
  options.network.progress = options.materialMesh.progress = options.analysis.progress = progress;
  if (options.automatic) options.automatic->progress = progress;
  return options;
}

}  // namespace

ExitCode runCook(const CookOptions& request) {
  std::string reason = checkOutputFiles(request);
  if (!reason.empty()) return fail(reason);
  StageProgress bars(stderr, isTerminal(stderr), kPatience);
  ThreadPool threads;
  CookOptions options = withProgress(request, bars);
  options.network.parallel = options.analysis.parallel = threads.parallelFor();
  CookReport report;
  report.meshFile = options.meshFile;
  report.bodyFile = options.bodyFile;
  report.settings = options.analysis;
  reason = makeBody(options, report);
  bars.finish();
  if (!reason.empty()) return fail(reason);
  report.settings.runs = runsFor(options, report.network->restPoints.size());
  if (!options.quiet || !options.jsonFile.empty()) analyseBody(report);
  bars.finish();
  reason = writeOutput(options, report);
  return reason.empty() ? kSuccess : fail(reason);
}

}  // namespace limber::demo

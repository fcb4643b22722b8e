// SPDX-License-Identifier: Zlib
#include "cook/run_cook.h"

#include "cook/cook_body.h"
#include "cook/cook_report.h"
#include "cook/network_picture.h"
#include "cook/stage_progress.h"
#include "output_files.h"

#include <limber/network_file.h>
#include <limber/render/png_file.h>

#include <chrono>
#include <cstdio>
#include <utility>

namespace limber::demo {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kPatience = 0.3;  // s

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

ExitCode fail(const std::string& reason) {
  std::fprintf(stderr, "limber-cook: %s\n", reason.c_str());
  return kFailure;
}

/// Before the work, not after it. Writes nothing.
std::string checkPlaces(const CookOptions& options) {
  const std::string none;
  const std::string& body = options.meshFile.empty() ? none : options.bodyFile;
  for (const std::string* file : {&body, &options.jsonFile, &options.pictureFile}) {
    const std::string reason = file->empty() ? std::string() : checkPlace(*file);
    if (!reason.empty()) return reason;
  }
  return {};
}

std::string makeBody(const CookOptions& options, CookReport& report) {
  const bool cook = !options.meshFile.empty();
  const Clock::time_point start = Clock::now();
  Result<SharedNetwork> network = cook ? cookBody(options) : loadNetwork(options.bodyFile);
  if (!network) return network.error();
  report.network = *network;
  report.cookSeconds = secondsSince(start);
  return cook ? saveNetwork(*report.network, options.bodyFile) : std::string();
}

void analyseBody(CookReport& report) {
  const Clock::time_point start = Clock::now();
  report.analysis = analyse(*report.network, report.settings);
  report.analysisSeconds = secondsSince(start);
}

std::string tell(const CookOptions& options, const CookReport& report) {
  if (!options.quiet) std::fputs(reportText(report).c_str(), stdout);
  if (!options.pictureFile.empty()) {
    render::writePng(options.pictureFile, drawNetwork(*report.network, options.width, options.height));
  }
  return options.jsonFile.empty() ? std::string() : writeText(options.jsonFile, reportJson(report));
}

/// The options with their progress shown on `bars`, if at all.
CookOptions withProgress(CookOptions options, StageProgress& bars) {
  if (options.quiet) return options;
  const limber::Progress progress = [&bars](const char* what, double done) {
    bars.show(what, done);
    return true;
  };
  options.network.progress = options.materialMesh.progress = options.analysis.progress = progress;
  return options;
}

}  // namespace

ExitCode runCook(const CookOptions& asked) {
  std::string reason = checkPlaces(asked);
  if (!reason.empty()) return fail(reason);
  StageProgress bars(stderr, isTerminal(stderr), kPatience);
  const CookOptions options = withProgress(asked, bars);
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
  reason = tell(options, report);
  return reason.empty() ? kSuccess : fail(reason);
}

}  // namespace limber::demo

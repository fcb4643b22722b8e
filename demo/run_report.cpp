// SPDX-License-Identifier: Zlib
#include "run_report.h"

#include "output_files.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>

namespace limber::demo {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSchemaVersion = 2;

void printRow(const char* name, const Milliseconds& ms) {
  std::printf("%-12s%9.3f ms %9.3f ms\n", name, ms.mean(), ms.max);
}

void printSoftRow(const RunFigures& f) {
  const double ticks = f.tick.count ? static_cast<double>(f.tick.count) : 1.0;
  std::printf("%-12s%9.3f ms   (gather %.3f, springs %.3f, hand over %.3f, take back %.3f)\n", "  Limber",
              f.soft.totalMs() / ticks, f.soft.beforeStepMs() / ticks, f.soft.stepMs / ticks,
              f.soft.writeMs / ticks, f.soft.readBackMs / ticks);
}

void printShape(const ShapeFigures& shape) {
  if (shape.solids == 0) return;
  std::printf("shape       off by %.2f %% of size on average, %.2f %% at worst", 100.0 * shape.mean,
              100.0 * shape.worst);
  if (shape.insideOut > 0) std::printf("; %zu of %zu inside out", shape.insideOut, shape.solids);
  std::printf("\n");
}

const char* modeName(PictureMode mode) {
  if (mode == PictureMode::None) return "none";
  return mode == PictureMode::Shaded ? "shaded" : "wireframe";
}

/// Missing numbers are null in JSON.
Json orNull(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json optionsJson(const DemoOptions& o) {
  const scenes::SceneOptions& s = o.sceneOptions;
  return {{"seconds", o.seconds},
          {"fps", o.framesPerSecond},
          {"width", o.width},
          {"height", o.height},
          {"mode", modeName(o.mode)},
          {"seed", s.seed},
          {"count", s.count ? Json(*s.count) : Json(nullptr)},
          {"stiffness", orNull(s.stiffness)},
          {"damping", orNull(s.damping)},
          {"mass", orNull(s.mass)},
          {"scale", orNull(s.scale)},
          {"mesh", s.meshFile.empty() ? Json(nullptr) : Json(s.meshFile)}};
}

Json millisecondsJson(const Milliseconds& ms) {
  return {{"count", ms.count}, {"mean", ms.mean()}, {"max", ms.max}};
}

Json softJson(const RunFigures& f) {
  const double ticks = f.tick.count ? static_cast<double>(f.tick.count) : 1.0;
  return {{"gather", f.soft.beforeStepMs() / ticks},
          {"step", f.soft.stepMs / ticks},
          {"handOver", f.soft.writeMs / ticks},
          {"takeBack", f.soft.readBackMs / ticks},
          {"pointsStepped", static_cast<double>(f.soft.pointsStepped) / ticks},
          {"springSubsteps", static_cast<double>(f.soft.springSubsteps) / ticks}};
}

Json shapeJson(const ShapeFigures& shape) {
  if (shape.solids == 0) return nullptr;
  return {{"meanError", shape.mean},
          {"worstError", shape.worst},
          {"insideOut", shape.insideOut},
          {"solids", shape.solids}};
}

Json endJson(const RunFigures& f) {
  return {{"passed", f.endProblem.empty()},
          {"reason", f.endProblem.empty() ? Json(nullptr) : Json(f.endProblem)}};
}

Json runJson(const DemoOptions& options, const RunFigures& f) {
  Json json = {{"schema", kSchemaVersion}, {"scene", options.scene}, {"options", optionsJson(options)}};
  json["bodies"] = f.bodies;
  json["points"] = f.points;
  json["springs"] = f.springs;
  json["tickMs"] = millisecondsJson(f.tick);
  json["limberMsPerTick"] = softJson(f);
  json["renderMs"] = millisecondsJson(f.render);
  json["outputMs"] = millisecondsJson(f.output);
  json["gpuBufferBytes"] = f.gpuBufferBytes;
  json["bytesPerFrame"] = f.bytesPerFrame;
  json["ringWaits"] = f.ringWaits;
  json["ringStalls"] = f.ringStalls;
  json["driver"] = f.driver.empty() ? Json(nullptr) : Json(f.driver);
  json["simulatedSeconds"] = f.simulatedSeconds;
  json["wallSeconds"] = f.wallSeconds;
  json["realTimeFactor"] = f.realTimeFactor();
  json["realTimeFactorTicksOnly"] = f.tickRealTimeFactor();
  json["shape"] = shapeJson(f.shape);
  json["stateHash"] = hashText(f.stateHash);
  json["endCheck"] = endJson(f);
  return json;
}

}  // namespace

void printTable(const DemoOptions& options, const RunFigures& f) {
  std::printf("scene       %s: %zu bodies, %zu points, %zu springs\n", options.scene.c_str(), f.bodies,
              f.points, f.springs);
  std::printf("%-12s%12s %12s\n", "", "mean", "max");
  printRow("tick", f.tick);
  printSoftRow(f);
  if (f.render.count > 0) {
    printRow("render", f.render);
    std::printf("GPU buffers %9.2f MB   (%s)\n", static_cast<double>(f.gpuBufferBytes) / 1e6,
                f.driver.c_str());
    std::printf("streamed    %9.2f kB a frame (%llu of %llu waits for the GPU were real)\n",
                static_cast<double>(f.bytesPerFrame) / 1e3, static_cast<unsigned long long>(f.ringStalls),
                static_cast<unsigned long long>(f.ringWaits));
  }
  std::printf("speed       %9.2f s of simulation per second of wall time", f.realTimeFactor());
  if (f.render.count > 0) std::printf(" (%.2f without pictures)", f.tickRealTimeFactor());
  std::printf("\n");
  printShape(f.shape);
  std::printf("state       %s\n", hashText(f.stateHash).c_str());
  std::printf("end check   %s\n", f.endProblem.empty() ? "passed" : ("FAILED: " + f.endProblem).c_str());
}

std::string writeJson(const DemoOptions& options, const RunFigures& figures) {
  // the name of a mesh may contain bytes that are not UTF-8: these are replaced
  const std::string text = runJson(options, figures).dump(2, ' ', false, Json::error_handler_t::replace);
  return writeText(options.statsFile, text + "\n");
}

}  // namespace limber::demo

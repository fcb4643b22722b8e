// SPDX-License-Identifier: Zlib
#include "networks/networks.h"
#include "analysis/analysis.h"
#include "network/bracing.h"
#include "network/material.h"
#include "results.h"
#include "scenes/end_checks.h"
#include "scenes/scene_list.h"
#include "support/network_shapes.h"
#include "support/test_shapes.h"
#include "timing.h"

#include <limber/cook.h>
#include <limber/mesh.h>
#include <limber/network_analysis.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <tuple>

namespace limber::bench {
namespace {

constexpr const char* kDefaultRule = "pipeline (default)";
constexpr const char* kRandom = "random, as many";
const std::pair<const char*, BraceRule> kRules[] = {{"edges alone", BraceRule::None},
                                                    {"equal length", BraceRule::EqualLength},
                                                    {"two rings", BraceRule::TwoRing},
                                                    {kDefaultRule, BraceRule::Pipeline},
                                                    {kRandom, BraceRule::None}};
const char* const kKinds[kDeformations] = {"squash", "twist",   "noise",    "push",
                                           "mirror", "flatten", "inversion"};
constexpr std::uint64_t kSeed = 1000;  // of the deformations: none that the pipeline has tried

// --- mechanisms and self-stresses of the edges alone ---

/// Cauchy, Dehn, Alexandrov: convex without points inside flat faces, no mechanism; each such point adds one,
/// and one self-stress. A torus has six self-stresses by Euler's formula, a grid and a rope count for
/// themselves.
struct Expected {
  const char* name;
  SharedNetwork network;
  std::size_t mechanisms, selfStresses;
};

std::vector<Expected> expectedCounts() {
  using namespace network_shapes;
  return {{"cube8", bare(cube8()), 0, 0},         {"cube26", bare(cube26()), 6, 6},
          {"cube98", bare(cube98()), 54, 54},     {"ico42", bare(ico42()), 0, 0},
          {"ico162", bare(ico162()), 0, 0},       {"ico642", bare(ico642()), 0, 0},
          {"torus128", bare(torus128()), 0, 6},   {"hull60", bare(hull60()), 0, 0},
          {"cyl62", bare(cyl62()), 2, 2},         {"cyl60", bare(cyl60()), 0, 0},
          {"lshape90", bare(lshape90()), 36, 36}, {"star162", bare(star162()), 0, 0},
          {"noise162", bare(noise162()), 0, 0},   {"rabbit302", bare(rabbit302()), 0, 0},
          {"cloth100", bare(cloth100()), 97, 64}, {"rope20", rope20(), 36, 0},
          {"tube60", bare(tube60()), 0, 0}};
}

void measureCounts(const Options& options, Results& results) {
  for (const Expected& e : expectedCounts()) {
    if (!options.wantsScene(e.name)) continue;
    const SmallDeformations s = smallDeformations(*e.network);
    const Subject subject{"mechanisms", e.name, "Limber", "edges alone"};
    results.add(subject, "points", "", double(e.network->restPoints.size()));
    results.add(subject, "springs", "", double(e.network->springs.size()));
    results.add(subject, "rank", "", double(s.rank));
    results.add(subject, "mechanisms", "", double(s.mechanisms));
    results.add(subject, "mechanisms expected", "", double(e.mechanisms));
    results.add(subject, "self-stresses", "", double(s.selfStresses));
    results.add(subject, "self-stresses expected", "", double(e.selfStresses));
    results.add(subject, "softest mode", "", s.softest);
    results.add(subject, "stiffest mode", "", s.stiffest);
    results.add(subject, "differs from theory", "",
                s.mechanisms != e.mechanisms || s.selfStresses != e.selfStresses);
  }
}

// --- returns from large deformations ---

SharedNetwork cookWith(const TriangleMesh& mesh, BraceRule rule) {
  NetworkSettings settings;
  settings.braces = rule;
  return valueOf(buildNetwork(mesh, settings));
}

/// As many braces as asked for between random pairs that have no spring.
SharedNetwork withRandomBraces(const SpringNetwork& bare, std::size_t braces, double weight) {
  auto network = std::make_shared<SpringNetwork>(bare);
  std::set<std::pair<std::uint32_t, std::uint32_t>> taken;
  for (const NetworkSpring& s : bare.springs) taken.emplace(s.a, s.b);
  std::mt19937_64 engine(7);
  const std::size_t points = bare.restPoints.size();
  const std::size_t most = std::min(braces, points * (points - 1) / 2 - bare.springs.size());
  while (network->springs.size() < bare.springs.size() + most) {
    const auto a = static_cast<std::uint32_t>(engine() % points),
               b = static_cast<std::uint32_t>(engine() % points);
    if (a == b || !taken.emplace(std::min(a, b), std::max(a, b)).second) continue;
    network->springs.push_back({std::min(a, b), std::max(a, b), SpringKind::Brace, weight});
  }
  std::sort(
      network->springs.begin(), network->springs.end(),
      [](const NetworkSpring& s, const NetworkSpring& t) { return std::tie(s.a, s.b) < std::tie(t.a, t.b); });
  return network;
}

std::size_t countBraces(const SpringNetwork& network) {
  return static_cast<std::size_t>(std::count_if(network.springs.begin(), network.springs.end(),
                                                [](const auto& s) { return s.kind == SpringKind::Brace; }));
}

double bracesPerPoint(const SpringNetwork& network) {
  return double(countBraces(network)) / double(network.restPoints.size());
}

/// Returns the returns from deformations of each kind, with seeds that the pipeline has not tried.
std::array<ReturnRate, kDeformations> returnsOf(const SpringNetwork& network, std::uint32_t runs) {
  const auto each = static_cast<std::uint32_t>((runs + kDeformations - 1) / kDeformations);
  std::array<ReturnRate, kDeformations> rates;
  for (std::size_t kind = 0; kind < kDeformations; ++kind)
    rates[kind] = measureReturns(network, static_cast<Deformation>(kind), each, kSeed);
  return rates;
}

void addReturns(const Subject& subject, const std::array<ReturnRate, kDeformations>& rates,
                Results& results) {
  double runs = 0.0, returned = 0.0;
  for (std::size_t kind = 0; kind < kDeformations; ++kind) {
    runs += rates[kind].runs, returned += rates[kind].returned;
    results.add(subject, std::string("returns, ") + kKinds[kind], "%", 100.0 * rates[kind].rate());
  }
  results.add(subject, "returns", "%", runs > 0.0 ? 100.0 * returned / runs : 0.0);
  results.add(subject, "runs", "", runs);
}

/// Deforms a shape with the springs of a rule. Random braces are as many as those of the pipeline. Returns
/// the number of braces.
std::size_t measureShape(const network_shapes::NamedShape& shape, const char* rule, BraceRule braceRule,
                         std::size_t pipelineBraces, const AnalysisSettings& settings, Results& results) {
  const Stopwatch watch;
  SharedNetwork network = cookWith(shape.make(), braceRule);
  if (rule == kRandom) network = withRandomBraces(*network, pipelineBraces, braceWeight(NetworkSettings()));
  const double seconds = 1e-3 * watch.time().cpuMs;
  const std::size_t braces = countBraces(*network);
  const Subject subject{"returns", shape.name, "Limber", rule};
  const NetworkAnalysis a = analyse(*network, settings);
  results.add(subject, "points", "", double(network->restPoints.size()));
  results.add(subject, "edges", "", double(network->springs.size() - braces));
  results.add(subject, "braces", "", double(braces));
  results.add(subject, "braces per point", "", bracesPerPoint(*network));
  addReturns(subject, a.returns, results);
  results.add(subject, "mechanisms", "", double(a.mechanisms));
  results.add(subject, "self-stresses", "", double(a.selfStresses));
  results.add(subject, "rank", "", double(a.rank));
  results.add(subject, "softest over stiffest mode", "", a.modeRatio);
  results.add(subject, "softest mode", "", a.softestEigenvalue);
  results.add(subject, "stiffest mode", "", a.stiffestEigenvalue);
  if (a.globallyRigidKnown) results.add(subject, "globally rigid", "", a.globallyRigid);
  const double isotropy = measureModuli({*network}).isotropy;
  if (isotropy >= 0.0) results.add(subject, "isotropy", "", isotropy);
  results.add(subject, "braces outside the body", "", double(a.springsOutside));
  results.add(subject, "cooking", "s", seconds);
  return braces;
}

// --- large bodies and difficult meshes ---

constexpr std::uint32_t kRunsOfEach = 2;

/// Cooks a rabbit of so many points, and lets it return a few times to see that it is as good as other
/// bodies.
void measureLarge(double cell, std::uint32_t points, Results& results) {
  const TriangleMesh mesh = valueOf(simplify(test_shapes::rabbit(cell), points));
  const Stopwatch watch;
  const SharedNetwork network = valueOf(buildNetwork(mesh));
  const double seconds = 1e-3 * watch.time().cpuMs;
  const Subject subject{"cooking", format("rabbit, %u points", points), "Limber", kDefaultRule};
  results.add(subject, "points", "", static_cast<double>(network->restPoints.size()));
  results.add(subject, "braces per point", "", bracesPerPoint(*network));
  results.add(subject, "cooking", "s", seconds);
  results.add(subject, "memory so far", "MB", peakMegabytes());
  addReturns(subject, returnsOf(*network, kRunsOfEach * kDeformations), results);
}

constexpr const char* kModels[] = {"animal", "figure", "teapot", "head", "ogre", "bunny", "car", "puppet"};
constexpr std::uint32_t kDropped = 4;
constexpr int kDropTicks = 8 * 60;
constexpr int kTimedTicks = 2 * 60;  // they fall and bounce; no body sleeps yet

std::string fileOf(const std::string& name) { return LIMBER_MESH_DIR "/" + name + ".obj"; }

std::string formOf(const CookedMesh& cooked) {
  const SpringNetwork& network = *cooked.bodies.front();
  std::string form = network.kind == NetworkKind::Solid  ? "solid"
                     : network.kind == NetworkKind::Rope ? "rope"
                                                         : "cloth";
  if (cooked.report[1].find("wrapped") != std::string::npos) form += ", wrapped";
  if (cooked.report[1].find("thick as") != std::string::npos) form += ", thickened";
  return form;
}

using ScenePointer = std::unique_ptr<scenes::Scene>;

ScenePointer dropOf(const std::string& file, const CookSettings& cook) {
  scenes::SceneOptions options;
  options.meshFile = file;
  options.count = kDropped;
  options.cook = cook;
  return valueOf(scenes::createMeshDrop(options));
}

double tickMs(scenes::Scene& scene) {
  const Stopwatch watch;
  scenes::tick(scene);
  return watch.time().cpuMs;
}

/// Drops four bodies and adds their shape at the end, and the time of their ticks. Solids are compared with
/// braced ones of about as many points: the same drop, tick by tick in turn.
void drop(const std::string& file, const SpringNetwork& largest, const Subject& subject, Results& results) {
  const ScenePointer scene = dropOf(file, {});
  ScenePointer braced;
  if (!largest.tetrahedra.empty()) {
    CookSettings cook;
    cook.mode = CookMode::Braces;
    cook.points = static_cast<std::uint32_t>(largest.restPoints.size());
    braced = dropOf(file, cook);
  }
  std::vector<double> ticks, bracedTicks;
  for (int i = 0; i < kDropTicks; ++i) {
    ticks.push_back(tickMs(*scene));
    if (braced && i < kTimedTicks) bracedTicks.push_back(tickMs(*braced));
  }
  ticks.resize(kTimedTicks);
  if (braced) {
    results.add(subject, "tick over braces", "", sum(ticks) / sum(bracedTicks));
    results.add(subject, "points of those", "", double(braced->soft->body(0)->network().restPoints.size()));
  }
  double error = 0.0;
  for (std::size_t b = 0; b < scene->soft->bodyCount(); ++b) {
    const SoftBody& body = *scene->soft->body(b);
    if (body.network().kind == NetworkKind::Solid)
      error = std::max(error, scenes::shapeError(body).relativeRms);
  }
  results.add(subject, "shape error", "%", 100.0 * error);
  const std::string reason = scenes::checkEnd(*scene);
  results.add(subject, "failed end check", "", !reason.empty());
  if (!reason.empty()) results.note(subject, "end check", reason);
}

void addCounts(const CookedMesh& cooked, const Subject& subject, Results& results) {
  double points = 0.0, springs = 0.0, tetrahedra = 0.0;
  for (const SharedNetwork& body : cooked.bodies) {
    points += static_cast<double>(body->restPoints.size());
    springs += static_cast<double>(body->springs.size());
    tetrahedra += static_cast<double>(body->tetrahedra.size());
  }
  results.add(subject, "bodies", "", static_cast<double>(cooked.bodies.size()));
  results.add(subject, "points", "", points);
  results.add(subject, "springs", "", springs);
  results.add(subject, "tetrahedra", "", tetrahedra);
}

/// Cooks, deforms and drops a difficult mesh of meshes/. Sheets and ropes have no shape to return to.
void measureModel(const std::string& name, std::uint32_t runs, Results& results) {
  const TriangleMesh mesh = valueOf(importMesh(fileOf(name)));
  const Stopwatch watch;
  const Result<CookedMesh> cooked = cook(mesh);
  if (!cooked) throw std::runtime_error(name + ": " + cooked.error());
  const double seconds = 1e-3 * watch.time().cpuMs;
  const Subject subject{"any mesh", name, "Limber", "cook()"};
  results.note(subject, "form", formOf(*cooked));
  results.add(subject, "vertices", "", static_cast<double>(mesh.positions.size()));
  addCounts(*cooked, subject, results);
  results.add(subject, "cooking", "s", seconds);
  results.add(subject, "memory so far", "MB", peakMegabytes());
  const SpringNetwork& largest = *cooked->bodies.front();
  if (largest.kind == NetworkKind::Solid) addReturns(subject, returnsOf(largest, runs), results);
  drop(fileOf(name), largest, subject, results);
}

// --- the bench ---

/// These are cooked and deformed in fractions of a second.
bool isSmall(const std::string& mesh) {
  return mesh == "cube8" || mesh == "cube26" || mesh == "ico42" || mesh == "lshape90";
}

/// Deforms the shapes with each rule.
void measureReturnsOfShapes(const Options& options, Results& results) {
  AnalysisSettings settings;
  const auto runs = static_cast<std::size_t>(options.number("runs", options.quick ? 20 : 100));
  settings.runs = static_cast<std::uint32_t>((runs + kDeformations - 1) / kDeformations);  // of each kind
  settings.seed = static_cast<std::uint64_t>(options.number("seed", kSeed));
  Progress progress;
  for (const network_shapes::NamedShape& shape : network_shapes::solids()) {
    if (!options.wantsScene(shape.name) || (options.quick && !isSmall(shape.name))) continue;
    std::size_t braces = 0;
    for (const auto& [rule, braceRule] : kRules) {
      const bool needed = rule == kDefaultRule && options.wantsEngine("Limber", kRandom);
      if (!options.wantsEngine("Limber", rule) && !needed) continue;
      const std::size_t own = measureShape(shape, rule, braceRule, braces, settings, results);
      if (rule == kDefaultRule) braces = own;
      progress.finish(shape.name + std::string(" ") + rule);
    }
  }
}

void measureModels(const Options& options, Results& results) {
  Progress progress;
  for (const std::string name : kModels) {
    if (!options.wantsScene(name)) continue;
    measureModel(name, static_cast<std::uint32_t>(options.number("runs", 100)), results);
    progress.finish(name);
  }
}

void runNetworks(const Options& options, Results& results) {
  std::vector<std::string> usual = {"mechanisms", "returns", "masses", "skins", "materials"};
  if (!options.quick) usual.insert(usual.end(), {"large", "models"});  // they take minutes
  const auto wants = [&](const char* part) { return options.hasWord("part", part, usual); };
  if (wants("mechanisms")) measureCounts(options, results);
  if (wants("returns")) measureReturnsOfShapes(options, results);
  if (wants("masses")) measureMasses(options, results);
  if (wants("skins")) measureSkins(options, results);
  if (wants("materials")) measureMaterials(options, results);
  if (wants("large") && options.wantsScene("rabbit")) {
    measureLarge(0.03, 300, results);
    measureLarge(0.01, 5000, results);
  }
  if (wants("models")) measureModels(options, results);
}

std::vector<std::string> sceneNames(const Options& options) {
  std::vector<std::string> names;
  for (const network_shapes::NamedShape& shape : network_shapes::solids()) names.push_back(shape.name);
  names.insert(names.end(), {"cloth100", "rope20", "rabbit", "torus", "cube", "noise", "bar"});
  names.insert(names.end(), std::begin(kModels), std::end(kModels));
  names.erase(std::remove_if(names.begin(), names.end(),
                             [&](const std::string& n) { return !options.wantsScene(n); }),
              names.end());
  return names;
}

}  // namespace

Bench networksBench() {
  return {"networks",
          "which springs keep which shape; masses, skins, materials, any mesh",
          "12 minutes",
          {{"part",
            "parts to measure",
            {"mechanisms", "returns", "masses", "skins", "materials", "large", "models"},
            true},
           {"runs", "runs per shape and rule", 1, 1e6},
           {"seed", "of the deformations", 0, 1e15}},
          &sceneNames,
          &runNetworks};
}

}  // namespace limber::bench

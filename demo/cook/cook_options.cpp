// SPDX-License-Identifier: Zlib
#include "cook/cook_options.h"

#include "number_checks.h"
#include "scenes/networks.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace limber::demo {
namespace {

constexpr double kMaxPoints = 1e6;

/// The values that CLI11 sets; some need others.
struct CommandLine {
  CookOptions options;
  std::string report;
  std::string braces = "pipeline";
  std::string masses = "equal";
  std::string skin = "dense";
  std::string size = "960x720";
  SkinSettings skinSettings;
  CookSettings automatic;
  bool connect = false;
};

CLI::Validator limberFile() {
  const auto check = [](std::string& text) {
    return scenes::isLimberFile(text) ? std::string() : text + " does not end in .limber";
  };
  return CLI::Validator(check, "BODY.limber");
}

void addFiles(CLI::App& app, CommandLine& line) {
  CookOptions& o = line.options;
  app.add_option("MESH", o.meshFile, "any format assimp reads");
  app.add_option("-o,--out", o.bodyFile, "the body to write")->check(limberFile());
  app.add_option("--report", line.report, "cook nothing, analyse this body anew")->check(limberFile());
  app.add_option("--json", o.jsonFile, "write the report to this file");
  app.add_option("--picture", o.pictureFile,
                 "draw the network, springs coloured by kind, into this PNG file");
  app.add_option("--size", line.size, "of the picture, WIDTHxHEIGHT (default 960x720)")->check(pictureSize());
  app.add_flag("--quiet", o.quiet, "print errors only");
}

void addBraces(CLI::App& app, CommandLine& line) {
  NetworkSettings& n = line.options.network;
  app.add_option("--braces", line.braces, "none, equal-length, two-ring or pipeline (default)")
      ->check(CLI::IsMember(namesOf(kBraceRules)));
  app.add_option("--brace-weight", n.braceWeight,
                 "stiffness of a brace, times a spring's (default 0.5 with pipeline, else 1)")
      ->check(number(1e-6, 1e6));
  app.add_option("--max-braces", n.maxBracesPerPoint,
                 "per point at most, of solid pieces, pipeline only (default 1.5)")
      ->check(number(1e-3, 1e3));
  app.add_option("--seconds", n.timeLimit,
                 "pipeline adds no more braces after these; the body then depends on the machine's speed "
                 "(default: no limit)")
      ->check(number(1e-3, 1e6));
  app.add_option("--masses", line.masses, "shared out equal (default), by area, or by the solid's moments")
      ->check(CLI::IsMember(namesOf(kMassRules)));
  app.add_option("--weld", n.weldTolerance, "m: vertices nearer than this are one point (default 0)")
      ->check(number(0.0, 1e6));
}

void addDetail(CLI::App& app, CommandLine& line) {
  CookOptions& o = line.options;
  app.add_option("--points", o.points,
                 "about as many point masses (default: 150 to 400 by shape; by hand all of the mesh, with "
                 "--material 300)")
      ->check(wholeNumber(8, kMaxPoints));
  app.add_option(
         "--length", line.automatic.size,
         "m: longest side of the mesh (default: meshes of 0.2 to 5 units keep theirs, others become 1 m)")
      ->check(number(1e-3, 1e3));
  app.add_flag("--connect", line.connect,
               "rods hold far pieces together (default: each is a body, BODY-2.limber and so on)");
  app.add_option(
         "--skin", line.skin,
         "dense, sparse or barycentric (default: dense up to 5 000 vertices, else sparse; barycentric "
         "with --material)")
      ->check(CLI::IsMember(namesOf(kSkinKinds)));
  app.add_option("--neighbours", line.skinSettings.neighbours,
                 "points that a vertex rides on at most, with --skin sparse (default 32)")
      ->check(wholeNumber(4, 1000));
  app.add_flag("--material", o.material, "fill the body with tetrahedra, for materials by Young's modulus");
  app.add_option("--spacing", o.materialMesh.spacing, "m: of the tetrahedra, instead of --points")
      ->check(number(1e-6, 1e6));
}

void addAnalysis(CLI::App& app, CommandLine& line) {
  AnalysisSettings& a = line.options.analysis;
  app.add_option("--runs", a.runs,
                 "large deformations of each kind that the report tries (default 20, fewer for more than "
                 "1 000 points)")
      ->check(wholeNumber(0, 100000));
  app.add_option("--seed", a.seed, "of all deformations (default 1)")->check(wholeNumber(0, 1e15));
  app.add_option("--mass", a.totalMass, "kg, for the report (default 1)")->check(number(1e-6, 1e6));
  app.add_option("--stiffness", a.stiffness, "N/m of each spring, for the report (default 1000)")
      ->check(number(1e-6, 1e12));
}

bool given(const CLI::App& app, const char* option) { return app.count(option) > 0; }

/// Options with which the user chooses how the body is made.
constexpr std::initializer_list<const char*> kByHand{"--braces",   "--brace-weight", "--max-braces",
                                                     "--seconds",  "--masses",       "--weld",
                                                     "--material", "--spacing",      "--neighbours"};

constexpr std::initializer_list<const char*> kCooking{
    "--braces", "--brace-weight", "--max-braces", "--seconds", "--masses", "--weld",   "--points",
    "--skin",   "--neighbours",   "--material",   "--spacing", "--length", "--connect"};

constexpr char kByHandTitle[] =
    "By hand (any of these replaces the automatic choice: braces, or tetrahedra with --material)";

/// Returns the first of the options that is given, or an empty string.
std::string firstGiven(const CLI::App& app, std::initializer_list<const char*> options) {
  for (const char* option : options)
    if (given(app, option)) return option;
  return {};
}

/// Returns the reason why valid files do not fit together, or an empty string.
std::string fileConflict(const CLI::App& app) {
  if (given(app, "--report")) {
    std::string other = firstGiven(app, {"MESH", "--out"});
    if (other.empty()) other = firstGiven(app, kCooking);
    return other.empty() ? other : other + " has no meaning with --report: nothing is cooked";
  }
  if (!given(app, "MESH")) return "a MESH to cook is missing, or --report BODY.limber";
  if (scenes::isLimberFile(app.get_option("MESH")->as<std::string>())) {
    const std::string other = firstGiven(app, kCooking);
    if (!other.empty()) return other + " has no meaning for a .limber file, which is cooked already";
  }
  return given(app, "--out") ? std::string() : "-o BODY.limber is missing";
}

/// Returns the reason why other options do not fit together, or an empty string.
std::string conflict(const CLI::App& app, const CommandLine& line) {
  const std::string byHand = firstGiven(app, kByHand), automatic = firstGiven(app, {"--length", "--connect"});
  if (!byHand.empty() && !automatic.empty()) return automatic + " has no meaning with " + byHand;
  if (line.options.material) {
    const std::string other =
        firstGiven(app, {"--braces", "--brace-weight", "--max-braces", "--seconds", "--masses"});
    if (!other.empty()) return other + " has no meaning with --material";
    if (given(app, "--spacing") && given(app, "--points")) return "--spacing and --points say the same";
  } else {
    if (given(app, "--spacing")) return "--spacing needs --material";
    if (!byHand.empty() && given(app, "--skin") && !given(app, "--points")) return "--skin needs --points";
  }
  if (line.braces != "pipeline") {
    const std::string other = firstGiven(app, {"--max-braces", "--seconds"});
    if (!other.empty()) return other + " has no meaning with --braces " + line.braces;
  }
  if (given(app, "--neighbours") && line.skin != "sparse") return "--neighbours needs --skin sparse";
  if (given(app, "--size") && !given(app, "--picture")) return "--size needs --picture";
  return {};
}

/// Sets the values that depend on other options.
void complete(const CLI::App& app, CommandLine& line) {
  CookOptions& o = line.options;
  o.fewerRunsIfLarge = !given(app, "--runs");
  if (given(app, "--report")) o.bodyFile = line.report;
  o.network.braces = valueOf(kBraceRules, line.braces);
  o.network.masses = valueOf(kMassRules, line.masses);
  o.network.seed = o.analysis.seed;
  if (given(app, "--skin")) {
    o.skin = line.skinSettings;
    o.skin->kind = valueOf(kSkinKinds, line.skin);
    o.skin->weldTolerance = o.network.weldTolerance;
  }
  if (o.points > 0) o.materialMesh.points = o.points;
  o.byHand = firstGiven(app, kByHand);
  if (o.byHand.empty() && !o.meshFile.empty()) {
    o.automatic = line.automatic;
    o.automatic->points = o.points;
    if (line.connect) o.automatic->pieces = PieceRule::Connected;
    if (o.skin) o.automatic->skin = o.skin->kind;
  }
  parseSize(line.size, o.width, o.height);
}

}  // namespace

std::uint32_t runsFor(const CookOptions& options, std::size_t points) {
  constexpr double kMany = 1000.0;
  const std::uint32_t runs = options.analysis.runs;
  if (!options.fewerRunsIfLarge || static_cast<double>(points) <= kMany) return runs;
  const double share = std::pow(kMany / static_cast<double>(points), 1.5);
  return std::max(std::min(runs, 2u), static_cast<std::uint32_t>(runs * share));
}

ParsedCookOptions parseCookOptions(int argc, char** argv) {
  CLI::App app("Makes a soft body that keeps its shape of any mesh, and says how well it does.",
               "limber-cook");
  app.footer("Exit codes: 0 fine, 1 something failed, 2 wrong command line.");
  CommandLine line;
  addFiles(app, line);
  addBraces(app, line);
  addDetail(app, line);
  addAnalysis(app, line);
  for (const char* option : kByHand) app.get_option(option)->group(kByHandTitle);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kSuccess : kUsage;
  }
  std::string reason = fileConflict(app);
  if (reason.empty()) reason = conflict(app, line);
  if (!reason.empty()) {
    std::fprintf(stderr, "%s\nRun with --help for more information.\n", reason.c_str());
    return kUsage;
  }
  complete(app, line);
  return line.options;
}

}  // namespace limber::demo

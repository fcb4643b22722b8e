// SPDX-License-Identifier: Zlib
#include "cook/cook_options.h"
#include "cook/cook_report.h"
#include "cook/network_picture.h"
#include "import/temporary_folder.h"
#include "output_files.h"
#include "progress.h"
#include "scenes/networks.h"

#include <limber/network_builder.h>
#include <limber/spring_network.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

namespace limber::demo {
namespace {

namespace fs = std::filesystem;

ParsedCookOptions parse(std::vector<std::string> words) {
  words.insert(words.begin(), "limber-cook");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  return parseCookOptions(static_cast<int>(argv.size()), argv.data());
}

CookOptions parsed(const std::vector<std::string>& words) {
  const ParsedCookOptions options = parse(words);
  if (const auto* accepted = std::get_if<CookOptions>(&options)) return *accepted;
  ADD_FAILURE() << "refused";
  return {};
}

TEST(CookOptions, defaultsAreTheLibrarys) {
  const CookOptions o = parsed({"a.obj", "-o", "a.limber"});
  const NetworkSettings n;
  const AnalysisSettings a;
  EXPECT_EQ(o.meshFile, "a.obj");
  EXPECT_EQ(o.bodyFile, "a.limber");
  EXPECT_EQ(o.network.braces, n.braces);
  EXPECT_EQ(o.network.masses, n.masses);
  EXPECT_EQ(o.network.braceWeight, n.braceWeight);
  EXPECT_EQ(o.network.maxBracesPerPoint, n.maxBracesPerPoint);
  EXPECT_EQ(o.network.timeLimit, n.timeLimit);
  EXPECT_EQ(o.network.seed, n.seed);
  EXPECT_EQ(o.analysis.runs, a.runs);
  EXPECT_EQ(o.analysis.totalMass, a.totalMass);
  EXPECT_FALSE(o.material);
  EXPECT_FALSE(o.skin);
  EXPECT_EQ(o.points, 0u);
}

TEST(CookOptions, everyChoiceArrives) {
  const CookOptions o =
      parsed({"a.obj", "-o",           "a.limber", "--braces",     "pipeline", "--brace-weight",
              "0.5",   "--max-braces", "1.25",     "--seed",       "7",        "--seconds",
              "9",     "--masses",     "moments",  "--weld",       "0.001",    "--points",
              "80",    "--skin",       "sparse",   "--neighbours", "12",       "--runs",
              "3",     "--mass",       "2",        "--stiffness",  "500"});
  EXPECT_EQ(o.network.braceWeight, 0.5);
  EXPECT_EQ(o.network.maxBracesPerPoint, 1.25);
  EXPECT_EQ(o.network.timeLimit, 9.0);
  EXPECT_EQ(o.network.seed, 7u);
  EXPECT_EQ(o.analysis.seed, 7u);
  EXPECT_EQ(o.network.masses, MassRule::Moments);
  EXPECT_EQ(o.network.weldTolerance, 0.001);
  EXPECT_EQ(o.points, 80u);
  ASSERT_TRUE(o.skin);
  EXPECT_EQ(o.skin->kind, SkinKind::Sparse);
  EXPECT_EQ(o.skin->neighbours, 12u);
  EXPECT_EQ(o.skin->weldTolerance, 0.001);
  EXPECT_EQ(o.analysis.runs, 3u);
  EXPECT_EQ(o.analysis.totalMass, 2.0);
  EXPECT_EQ(o.analysis.stiffness, 500.0);
}

TEST(CookOptions, namesOfRules) {
  EXPECT_EQ(parsed({"a.obj", "-o", "a.limber", "--braces", "none"}).network.braces, BraceRule::None);
  EXPECT_EQ(parsed({"a.obj", "-o", "a.limber", "--braces", "equal-length"}).network.braces,
            BraceRule::EqualLength);
  EXPECT_EQ(parsed({"a.obj", "-o", "a.limber", "--braces", "two-ring"}).network.braces, BraceRule::TwoRing);
  EXPECT_EQ(parsed({"a.obj", "-o", "a.limber", "--masses", "area"}).network.masses, MassRule::Area);
}

TEST(CookOptions, materialTakesPointsOrASpacing) {
  EXPECT_EQ(parsed({"a.obj", "-o", "a.limber", "--material", "--points", "90"}).materialMesh.points, 90u);
  EXPECT_EQ(parsed({"a.obj", "-o", "a.limber", "--material", "--spacing", "0.2"}).materialMesh.spacing, 0.2);
}

TEST(CookOptions, aReportNeedsNoMesh) {
  const CookOptions o = parsed({"--report", "b.limber", "--runs", "5", "--picture", "b.png"});
  EXPECT_EQ(o.meshFile, "");
  EXPECT_EQ(o.bodyFile, "b.limber");
  EXPECT_EQ(o.analysis.runs, 5u);
}

TEST(CookOptions, largeBodiesAreTriedFewerTimesUnlessAskedFor) {
  CookOptions o = parsed({"a.obj", "-o", "a.limber"});
  EXPECT_EQ(runsFor(o, 1000), 20u);
  EXPECT_EQ(runsFor(o, 2000), 7u);
  EXPECT_EQ(runsFor(o, 5000), 2u);
  EXPECT_EQ(runsFor(parsed({"a.obj", "-o", "a.limber", "--runs", "30"}), 5000), 30u);
  o.analysis.runs = 0;
  EXPECT_EQ(runsFor(o, 5000), 0u);
}

CookReport exampleReport() {
  CookReport report;
  report.meshFile = "cube.obj";
  report.bodyFile = "cube.limber";
  ClothSettings cloth;
  cloth.columns = cloth.rows = 2;
  report.network = *buildCloth(cloth);
  NetworkAnalysis& a = report.analysis;
  a.kind = NetworkKind::Cloth;
  a.points = report.network->restPoints.size();
  a.braces = 3;
  a.rank = 17;
  a.mechanisms = 1;
  a.selfStresses = 2;
  a.rigidity = Rigidity::NearlyFlexible;
  a.returns[0] = {20, 19, 1};
  a.criticalTimeStep = 0.0032;
  a.standingStiffness = 12.5;
  a.mesh.vertices = 9;
  a.mesh.points = 9;
  a.mesh.openEdges = 4;
  a.remarks = {"the mesh has a hole"};
  return report;
}

TEST(CookReport, theTextNamesWhatMatters) {
  const std::string text = reportText(exampleReport());
  for (const char* part :
       {"cube.limber, made of cube.obj", "12 structural, 8 shear, 6 bending; 0.33 braces per point",
        "9 vertices, 8 triangles, on the points themselves", "rank 17, 1 mechanisms, 2 self-stresses",
        "nearly flexible", "19 of 20", "12.5 N/m", "0.0032 s critical", "! the mesh has a hole\n"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in\n" << text;
  }
}

TEST(CookReport, theJsonHasTheSameFigures) {
  const auto json = nlohmann::json::parse(reportJson(exampleReport()));
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["meshFile"], "cube.obj");
  EXPECT_EQ(json["network"]["points"], 9);
  EXPECT_EQ(json["network"]["springs"]["shear"], 8);
  EXPECT_EQ(json["analysis"]["mechanisms"], 1);
  EXPECT_EQ(json["analysis"]["rigidity"], "nearly flexible");
  EXPECT_EQ(json["analysis"]["returns"]["squash"]["mirrored"], 1);
  EXPECT_TRUE(json["analysis"]["returns"]["twist"].is_null());
  EXPECT_TRUE(json["analysis"]["globallyRigid"].is_null());
  EXPECT_EQ(json["analysis"]["remarks"][0], "the mesh has a hole");
}

TEST(CookReport, numbersThatAreNoneAreNull) {
  CookReport report = exampleReport();
  report.analysis.safeTimeStep = HUGE_VAL;
  EXPECT_TRUE(nlohmann::json::parse(reportJson(report))["analysis"]["safeTimeStep"].is_null());
}

TEST(NetworkScenery, eachKindHasItsSprings) {
  const SharedNetwork cloth = *buildCloth();
  const auto counts = springCounts(*cloth);
  EXPECT_EQ(springLines(*cloth, SpringKind::Structural).shape.lines.size(), 2 * counts[0]);
  const render::Scenery rods = springRods(*cloth, SpringKind::Shear, 0.01);
  EXPECT_EQ(rods.shape.pointCount, 12 * counts[1]);
  EXPECT_EQ(rods.points.size(), 3 * rods.shape.pointCount);
  EXPECT_EQ(rods.shape.triangles.size(), 3 * 12 * counts[1]);
  EXPECT_EQ(validate(rods.shape), "");
  EXPECT_TRUE(springRods(*cloth, SpringKind::Brace, 0.01).points.empty());
  EXPECT_TRUE(springLines(*cloth, SpringKind::Brace).points.empty());
}

TEST(PictureLegend, everyEntryHasItsColourAndItsLetters) {
  render::Image image;
  image.resize(200, 100);
  std::fill(image.rgba.begin(), image.rgba.end(), std::uint8_t{255});
  drawLegend(image, {{"12 brace", {1.0f, 0.0f, 0.0f}}, {"3 shear", {0.0f, 0.0f, 1.0f}}});
  std::set<std::array<int, 3>> colours;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      colours.insert({image.pixel(x, y)[0], image.pixel(x, y)[1], image.pixel(x, y)[2]});
  EXPECT_EQ(colours.size(), 4u);  // two squares, ink and paper
  EXPECT_EQ(colours.count({255, 0, 0}), 1u);
  EXPECT_EQ(colours.count({0, 0, 255}), 1u);
}

TEST(PictureLegend, ofASmallPictureIsACornerOfThatOfALargeOne) {
  render::Image small, large;
  small.resize(16, 16), large.resize(200, 40);
  for (render::Image* image : {&small, &large}) {
    std::fill(image->rgba.begin(), image->rgba.end(), std::uint8_t{255});
    drawLegend(*image, {{"a text that is far too long", {}}, {"and another", {}}, {"and more", {}}});
  }
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      for (int c = 0; c < 4; ++c) ASSERT_EQ(small.pixel(x, y)[c], large.pixel(x, y)[c]) << x << ' ' << y;
}

TEST(OutputFiles, placesAreCheckedWithoutATrace) {
  const TemporaryFolder folder;
  EXPECT_EQ(checkWritable(folder.path() + "/new.json"), "");
  EXPECT_EQ(checkWritable("new.json"), "");
  EXPECT_EQ(checkWritable(folder.path()), "cannot write " + folder.path() + ": it is a folder");
  const std::string nowhere = folder.path() + "/none/new.json";
  EXPECT_EQ(checkWritable(nowhere),
            "cannot write " + nowhere + ": there is no folder " + folder.path() + "/none");
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(OutputFiles, textsAreWrittenWholeOrNotAtAll) {
  const TemporaryFolder folder;
  const std::string file = folder.path() + "/a.json";
  EXPECT_EQ(writeText(file, "one\n"), "");
  EXPECT_EQ(writeText(file, "two\n"), "");
  std::ifstream stream(file);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), "two\n");
  EXPECT_NE(writeText(folder.path() + "/none/a.json", "three"), "");
  EXPECT_NE(writeText("/dev/full", "four"), "");
  fs::create_symlink("a.json", folder.path() + "/link.json");
  EXPECT_EQ(writeText(folder.path() + "/link.json", "five\n"), "");
  EXPECT_TRUE(fs::is_symlink(folder.path() + "/link.json"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2);
}

std::string progressText(const std::vector<std::pair<const char*, double>>& calls, double patience = 0.0) {
  std::FILE* file = std::tmpfile();
  StageProgress bars(file, true, patience);
  for (const auto& [stage, done] : calls) bars.show(stage, done);
  bars.finish();
  bars.finish();
  std::rewind(file);
  std::string text(8192, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  return text;
}

TEST(StageProgress, everyStageHasALineOfItsOwnThatFillsUp) {
  const std::string text = progressText({{"first", 0.0}, {"first", 0.5}, {"second", 0.2}, {"second", 1.0}});
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
  EXPECT_EQ(text.back(), '\n');
  EXPECT_NE(text.find("first "), std::string::npos);
  EXPECT_NE(text.find("second "), std::string::npos);
  EXPECT_EQ(progressText({}), "");
}

TEST(StageProgress, aStageThatBeginsAnewHasANewLine) {
  const std::string text = progressText({{"first", 0.8}, {"first", 0.1}, {"first", 1.0}});
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
}

TEST(StageProgress, whatIsOverAtOnceIsNotShown) {
  EXPECT_EQ(progressText({{"first", 0.0}, {"first", 0.5}, {"first", 1.0}, {"second", 0.5}}, 1000.0), "");
}

TEST(ReadBodies, cookedOnesAreLoadedAsTheyAre) {
  const TemporaryFolder folder;
  const std::string file = folder.path() + "/cloth.limber";
  const SharedNetwork cloth = *buildCloth();
  ASSERT_EQ(saveNetwork(*cloth, file).error(), "");
  const Result<CookedMesh> loaded = scenes::readBodies(file, {}, {});
  ASSERT_TRUE(loaded) << loaded.error();
  ASSERT_EQ(loaded->bodies.size(), 1u);
  EXPECT_EQ(toBytes(*loaded->bodies.front()), toBytes(*cloth));
  EXPECT_FALSE(scenes::isLimberFile("cloth.obj"));
  EXPECT_FALSE(scenes::isLimberFile(".limber"));
}

}  // namespace
}  // namespace limber::demo

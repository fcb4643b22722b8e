// SPDX-License-Identifier: Zlib
#include "command_list.h"

#include "command_line.h"
#include "contact/contact_summary.h"
#include "contact/contact_targets.h"
#include "contact/measure_contact.h"
#include "contact/memory_use.h"
#include "csv_table.h"

#include <cstdio>

namespace limber::bench {
namespace {

constexpr const char* kCsvName = "contact.csv";

struct Options {
  std::string out = "out/bench";
  bool quick = false, flags = false;
  std::string scene;  ///< part of the names of scenes; empty: all
  ContactLimits limits;
};

void addOptions(CLI::App& app, Options& options) {
  app.add_option("--out", options.out, "folder of contact.csv and contact.txt (default out/bench)");
  app.add_flag("--quick", options.quick, "few bodies, seconds in all: the times mean nothing");
  app.add_option("--scene", options.scene, "only scenes whose name has this in it");
  app.add_option("--repeats", options.limits.repeats, "repeats of each scene (default 3)")
      ->check(CLI::PositiveNumber);
  app.add_option("--patience", options.limits.timeLimit,
                 "seconds that an engine may take for a repeat of a scene (default 120)")
      ->check(CLI::PositiveNumber);
  app.add_flag("--flags", options.flags, "compare kinds of collision of btSoftBody instead");
}

std::vector<ContactScene> scenesOf(const Options& options) {
  std::vector<ContactScene> chosen;
  for (ContactScene& scene : allContactScenes(options.quick))
    if (scene.name.find(options.scene) != std::string::npos) chosen.push_back(std::move(scene));
  return chosen;
}

std::vector<ContactRow> measureAll(const std::vector<ContactScene>& scenes, const Options& options) {
  const std::vector<ContactEngine> engines = options.flags ? contactFlags() : contactEngines();
  CsvTable csv(options.out + "/" + kCsvName, contactColumns());
  RowProgress progress;
  std::vector<ContactRow> all;
  for (const ContactScene& scene : scenes) {
    for (ContactRow& row : measureContact(scene, engines, options.limits, progress)) {
      csv.add(contactCells(row));
      all.push_back(std::move(row));
    }
    progress.finish(scene.name);
  }
  return all;
}

}  // namespace

ExitCode runContact(int argc, char** argv) {
  CLI::App app("What do contacts cost?", "limber-bench contact");
  Options options;
  addOptions(app, options);
  if (const auto end = parse(app, argc, argv)) return *end;
  const std::vector<ContactScene> scenes = scenesOf(options);
  if (scenes.empty()) {
    std::fprintf(stderr, "limber-bench: no scene has '%s' in its name\n", options.scene.c_str());
    return kUsage;
  }
  if (!canWrite(options.out, kCsvName)) return kFailure;
  const std::vector<ContactRow> rows = measureAll(scenes, options);
  std::string summary = summariseContact(rows);
  if (!options.flags) summary += contactTargets(rows) + "\n" + describe(measureMemory(options.quick));
  publish(summary, options.out + "/contact.txt");
  return kSuccess;
}

}  // namespace limber::bench

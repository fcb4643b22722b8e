// SPDX-License-Identifier: Zlib
#include "bench.h"

#include "results.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <optional>

namespace limber::bench {
namespace {

std::string lowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool contains(const std::string& text, const std::string& part) {
  return lowerCase(text).find(lowerCase(part)) != std::string::npos;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) c == ',' ? void(parts.emplace_back()) : void(parts.back() += c);
  return parts;
}

bool isNumber(const std::string& text, double low, double high) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && value >= low && value <= high;
}

std::string allowedValues(const Key& key) {
  std::string text = key.isList ? "one or more, separated by commas, " : key.words.empty() ? "" : "one ";
  if (key.words.empty()) {
    char range[80];
    std::snprintf(range, sizeof range, "from %g to %g", key.low, key.high);
    return text + range;
  }
  text += "of ";
  for (const std::string& word : key.words) text += (word == key.words[0] ? "" : " | ") + word;
  return text;
}

/// Returns the reason why --set key=value is wrong, or an empty string.
std::string whyWrong(const std::vector<Key>& keys, const std::string& name, const std::string& value) {
  std::string known;
  for (const Key& key : keys) {
    known += (known.empty() ? "" : ", ") + key.name;
    if (key.name != name) continue;
    for (const std::string& part : key.isList ? split(value) : std::vector<std::string>{value}) {
      const bool isWord = std::find(key.words.begin(), key.words.end(), part) != key.words.end();
      if (key.words.empty() ? !isNumber(part, key.low, key.high) : !isWord)
        return "--set " + name + "=" + value + ": must be " + allowedValues(key);
    }
    return {};
  }
  return "--set " + name + ": there is no such key; this bench has: " + (known.empty() ? "none" : known);
}

std::string keyHelp(const std::vector<Key>& keys) {
  if (keys.empty()) return {};
  std::string text = "Keys of --set:\n";
  for (const Key& key : keys)
    text += "  " + key.name + std::string(key.name.size() < 18 ? 18 - key.name.size() : 1, ' ') + key.about +
            " (" + allowedValues(key) + ")\n";
  return text;
}

/// Checks --set and stores its pairs.
void storeSets(const Bench& bench, const std::vector<std::string>& pairs, Options& options) {
  for (const std::string& pair : pairs) {
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos) throw CLI::ValidationError("--set " + pair + ": must be key=value");
    const std::string name = pair.substr(0, equals), value = pair.substr(equals + 1);
    const std::string reason = whyWrong(bench.keys, name, value);
    if (!reason.empty()) throw CLI::ValidationError(reason);
    options.sets[name] = value;
  }
}

/// Returns the exit code if the program must end: after --help, or a wrong command line.
std::optional<ExitCode> parse(const Bench& bench, int argc, char** argv, Options& options) {
  CLI::App app(bench.about + "; " + bench.duration, "limber-bench " + bench.name);
  std::vector<std::string> pairs;
  app.add_option("--out", options.out, "folder of the results (default out/bench)");
  app.add_flag("--quick", options.quick, "seconds instead of minutes; the times then mean little");
  if (bench.scenes) {
    app.add_option("--scene", options.scene, "only scenes with this in their name");
    app.add_flag("--scenes", options.list, "list the scenes, measure nothing");
  }
  app.add_option("--engine", options.engines, "only engines with one of these in their name and setting")
      ->delimiter(',');
  app.add_option("--set", pairs, "key=value, a setting of the bench or of an engine; may be repeated");
  app.footer(keyHelp(bench.keys));
  try {
    app.parse(argc, argv);
    storeSets(bench, pairs, options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kSuccess : kUsage;
  }
  return std::nullopt;
}

/// Returns the options as they were given, without the folder of the results.
std::string optionsText(int argc, char** argv) {
  std::string text;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--out") ++i;
    if (word.rfind("--out", 0) != 0) text += (text.empty() ? "" : " ") + word;
  }
  return text.empty() ? "none" : text;
}

ExitCode run(const Bench& bench, int argc, char** argv) {
  Options options;
  if (const auto end = parse(bench, argc, argv, options)) return *end;
  std::vector<std::string> scenes;
  if (bench.scenes) scenes = bench.scenes(options);
  if (bench.scenes && scenes.empty()) {
    std::fprintf(stderr, "limber-bench: no scene has \"%s\" in its name\n", options.scene.c_str());
    return kUsage;
  }
  if (options.list) {
    for (const std::string& scene : scenes) std::printf("%s\n", scene.c_str());
    return kSuccess;
  }
  Results results(options.out, bench.name, optionsText(argc, argv));
  bench.run(options, results);
  if (results.empty()) {
    std::fprintf(stderr, "limber-bench: nothing was measured; is there such an engine?\n");
    return kUsage;
  }
  return kSuccess;
}

void printList(const std::vector<Bench>& benches, std::FILE* stream) {
  for (const Bench& bench : benches)
    std::fprintf(stream, "  %-10s %s; %s\n", bench.name.c_str(), bench.about.c_str(), bench.duration.c_str());
}

}  // namespace

bool Options::wantsScene(const std::string& name) const { return contains(name, scene); }

bool Options::wantsEngine(const std::string& engine, const std::string& setting) const {
  const std::string full = engine + " " + setting;
  return engines.empty() || std::any_of(engines.begin(), engines.end(),
                                        [&](const std::string& part) { return contains(full, part); });
}

std::string Options::word(const std::string& key, const std::string& otherwise) const {
  const auto found = sets.find(key);
  return found == sets.end() ? otherwise : found->second;
}

double Options::number(const std::string& key, double otherwise) const {
  return sets.count(key) ? std::stod(sets.at(key)) : otherwise;
}

std::vector<double> Options::numbers(const std::string& key, const std::vector<double>& otherwise) const {
  if (!sets.count(key)) return otherwise;
  std::vector<double> values;
  for (const std::string& part : split(sets.at(key))) values.push_back(std::stod(part));
  return values;
}

bool Options::hasWord(const std::string& key, const std::string& word,
                      const std::vector<std::string>& otherwise) const {
  const std::vector<std::string> all = sets.count(key) ? split(sets.at(key)) : otherwise;
  return std::find(all.begin(), all.end(), word) != all.end();
}

ExitCode runBench(const std::vector<Bench>& benches, int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "";
  if (name == "--help" || name == "-h" || name == "--list") {
    printList(benches, stdout);
    return kSuccess;
  }
  for (const Bench& bench : benches)
    if (name == bench.name) return run(bench, argc - 1, argv + 1);
  std::fprintf(stderr, "limber-bench: there is no bench \"%s\"\n", name.c_str());
  printList(benches, stderr);
  return kUsage;
}

}  // namespace limber::bench

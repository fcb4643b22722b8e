// SPDX-License-Identifier: Zlib
#pragma once

// What a bench declares, and the options that all benches share.

#include <limber/result.h>

#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace limber::bench {

/// 1: something failed; 2: the command line is wrong.
enum ExitCode : int { kSuccess = 0, kFailure = 1, kUsage = 2 };

/// A setting that --set changes: a number from `low` to `high`, or one of `words`.
struct Key {
  std::string name, about;
  std::vector<std::string> words;
  double low = 0.0, high = 0.0;
  bool isList = false;  ///< several, separated by commas

  Key(std::string key, std::string text, double from, double to, bool list = false)
      : name(std::move(key)), about(std::move(text)), low(from), high(to), isList(list) {}
  Key(std::string key, std::string text, std::vector<std::string> allowed, bool list = false)
      : name(std::move(key)), about(std::move(text)), words(std::move(allowed)), isList(list) {}
};

/// The command line of a run.
struct Options {
  std::string out = "out/bench";            ///< folder of the results
  bool quick = false;                       ///< seconds instead of minutes; the times then mean little
  bool list = false;                        ///< list the scenes, measure nothing
  std::string scene;                        ///< part of the names of the scenes; empty: all
  std::vector<std::string> engines;         ///< parts of "engine setting"; empty: all
  std::map<std::string, std::string> sets;  ///< valid values of --set

  bool wantsScene(const std::string& name) const;  ///< ignores upper and lower case
  bool wantsEngine(const std::string& engine, const std::string& setting = {}) const;
  double number(const std::string& key, double otherwise) const;
  std::string word(const std::string& key, const std::string& otherwise = {}) const;
  std::vector<double> numbers(const std::string& key, const std::vector<double>& otherwise) const;
  /// Returns whether a word is among those of a key, or of `otherwise` if the key is not set.
  bool hasWord(const std::string& key, const std::string& word,
               const std::vector<std::string>& otherwise) const;
};

class Results;

/// A bench that `limber-bench NAME` runs.
struct Bench {
  std::string name, about, duration;
  std::vector<Key> keys;
  /// Names of the scenes; empty: the bench has none to choose from.
  std::vector<std::string> (*scenes)(const Options&) = nullptr;
  void (*run)(const Options&, Results&) = nullptr;
};

/// Runs the bench that argv[1] names; an unknown name is refused with the list.
ExitCode runBench(const std::vector<Bench>& benches, int argc, char** argv);

/// Returns the part of the scenes that the options ask for.
template <class Scene>
std::vector<Scene> wantedScenes(std::vector<Scene> all, const Options& options) {
  std::vector<Scene> wanted;
  for (Scene& scene : all)
    if (options.wantsScene(scene.name)) wanted.push_back(std::move(scene));
  return wanted;
}

template <class Scene>
std::vector<std::string> namesOf(const std::vector<Scene>& scenes) {
  std::vector<std::string> names;
  for (const Scene& scene : scenes) names.push_back(scene.name);
  return names;
}

/// Returns the value. Throws std::runtime_error with the reason if there is none.
template <class T>
T valueOf(Result<T> result) {
  if (!result) throw std::runtime_error(result.error());
  return std::move(*result);
}

// --- the benches -------------------------------------------------------------------------------------------

Bench accuracyBench();   ///< errors and times in scenes with a known outcome
Bench contactBench();    ///< times of bodies that fly, land, rest, sleep, drape and pile up
Bench networksBench();   ///< braces, masses, skins, materials, any mesh
Bench springsBench();    ///< time of a spring, by instruction set
Bench stabilityBench();  ///< hard cases
Bench threadsBench();    ///< gain of several threads
Bench renderBench();     ///< drawing of many bodies
Bench scalingBench();    ///< the paper's Tables 1 and 2

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#include "fuzz/campaign.h"
#include "fuzz/dice.h"

#include <algorithm>

namespace limber::fuzz {
namespace {

/// Returns the sanitizer's name of the crash, so that shrinking does not end at another bug.
std::string crashKind(const Verdict& verdict) {
  if (verdict.law != "crash") return {};
  const std::size_t at = verdict.detail.find("AddressSanitizer: ");
  if (at == std::string::npos) return {};
  const std::size_t word = at + std::string("AddressSanitizer: ").size();
  return verdict.detail.substr(word, verdict.detail.find(' ', word) - word);
}

class Shrinker {
 public:
  Shrinker(const Story& story, const Verdict& verdict, const Effort& effort)
      : story_(story), law_(verdict.law), crash_(crashKind(verdict)), effort_(effort) {}

  Story run() {
    // until no single change succeeds; each round takes some hundred short plays
    for (int round = 0; round < 6; ++round) {
      const std::string before = toText(story_);
      dropChunks();
      cutFrames();
      simplify();
      if (toText(story_) == before) break;
    }
    return story_;
  }

 private:
  /// Replaces the story by the first of `tries` that fails in the same manner, if there is one.
  bool takeFirst(const std::vector<Story>& tries) {
    std::size_t best = tries.size();
    // as many at a time as processes; the search ends at the first failing batch
    for (std::size_t i = 0; i < tries.size() && best == tries.size();
         i += static_cast<std::size_t>(effort_.jobs)) {
      const std::size_t last = std::min(tries.size(), i + static_cast<std::size_t>(effort_.jobs));
      const std::vector<Story> batch(tries.begin() + static_cast<std::ptrdiff_t>(i),
                                     tries.begin() + static_cast<std::ptrdiff_t>(last));
      judge(batch, effort_, [&](std::size_t index, const Verdict& verdict) {
        if (verdict.law == law_ && crashKind(verdict) == crash_) best = std::min(best, i + index);
      });
    }
    if (best == tries.size()) return false;
    story_ = tries[best];
    return true;
  }

  /// Removes halves, then quarters, ..., then single steps (delta debugging).
  void dropChunks() {
    for (std::size_t size = std::max<std::size_t>(1, story_.steps.size() / 2);; size /= 2) {
      for (std::size_t end = story_.steps.size(); end > 0;) {
        const std::size_t begin = end > size ? end - size : 0;
        Story reduced = story_;
        reduced.steps.erase(reduced.steps.begin() + static_cast<std::ptrdiff_t>(begin),
                            reduced.steps.begin() + static_cast<std::ptrdiff_t>(end));
        takeFirst({reduced});
        end = std::min(begin, story_.steps.size());
      }
      if (size <= 1) return;
    }
  }

  /// Tries fewer frames, and all steps earlier.
  void cutFrames() {
    const auto time = std::find_if(story_.steps.begin(), story_.steps.end(),
                                   [](const Step& s) { return s.kind == Kind::Time; });
    if (time == story_.steps.end()) return;
    const auto index = static_cast<std::size_t>(time - story_.steps.begin());
    for (double fraction : {0.25, 0.5, 0.75, 0.9, 0.97}) {
      const int frames = story_.steps[index].whole("frames");
      Story shorter = story_;
      shorter.steps[index].set("frames", std::floor(frames * fraction));
      while (takeFirst({shorter}))
        shorter.steps[index].set("frames", std::floor(story_.steps[index].whole("frames") * fraction));
    }
    Story earlier = story_;
    for (Step& s : earlier.steps)
      if (s.at > 0) s.at /= 2;
    takeFirst({earlier});
  }

  /// Tries standard values for whole fields, then for single components, then shorter numbers.
  void simplify() {
    for (std::size_t i = 0; i < story_.steps.size(); ++i) {
      trySet(i, [](Step& s) { s.phase = Phase::Between; });
      trySet(i, [](Step& s) {
        if (s.at > 0) s.at = 0;
      });
      for (const Field& field : fieldsOf(story_.steps[i].kind)) {
        if (field.role == Role::Reference) continue;
        trySet(i, [&](Step& s) { fill(s, field, field.standard); });
        if (field.role == Role::Number || field.role == Role::Choice) continue;
        for (std::size_t axis = 0; axis < 3; ++axis)
          trySet(i, [&](Step& s) { s.values[field.offset + axis] = field.standard[axis]; });
        trySet(i, [&](Step& s) {
          for (std::size_t axis = 0; axis < 3; ++axis) shorten(s.values[field.offset + axis]);
        });
      }
    }
  }

  static void shorten(double& value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.1g", value);
    value = std::strtod(text, nullptr);
  }
  static void fill(Step& s, const Field& field, const std::array<double, 3>& values) {
    for (std::size_t i = 0; i < field.size(); ++i) s.values[field.offset + i] = values[i];
  }
  template <class Change>
  void trySet(std::size_t i, Change change) {
    Story simpler = story_;
    change(simpler.steps[i]);
    const Step &a = simpler.steps[i], &b = story_.steps[i];
    if (a.values != b.values || a.at != b.at || a.phase != b.phase) takeFirst({simpler});
  }

  Story story_;
  std::string law_, crash_;
  Effort effort_;
};

}  // namespace

Story shrink(const Story& story, const Verdict& verdict, const Effort& effort) {
  return Shrinker(story, verdict, effort).run();
}

}  // namespace limber::fuzz

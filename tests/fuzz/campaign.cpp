// SPDX-License-Identifier: Zlib
// Plays stories in child processes, so that a crash or an endless loop ends only one story.
#include "fuzz/campaign.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

namespace limber::fuzz {
namespace {

using Clock = std::chrono::steady_clock;

struct Child {
  pid_t process = -1;
  int pipe = -1;  ///< standard output and error, and at the end the verdict
  std::size_t story = 0;
  std::string output;
  Clock::time_point start;
};

/// On a busy machine a story gets a small share of a processor, so the limit is on processor time. This many
/// times the limit on the clock stops a story that waits for ever.
const double kWallClockFactor = 30.0;

void limitProcessorTime(double seconds) {
  const auto wholeSeconds = static_cast<rlim_t>(seconds + 1.0);
  const rlimit limit{wholeSeconds, wholeSeconds + 1};
  setrlimit(RLIMIT_CPU, &limit);
}

const char* const kVerdictMark = "\n=verdict=";

/// Whether memory has leaked, which the sanitizer then reports; false without a sanitizer.
bool leaks() {
#if defined(__SANITIZE_ADDRESS__)
  return __lsan_do_recoverable_leak_check() != 0;
#else
  return false;
#endif
}

[[noreturn]] void playInChild(const Story& story, int pipe, const Effort& effort) {
  limitProcessorTime(effort.seconds);
  dup2(pipe, STDERR_FILENO);
  dup2(pipe, STDOUT_FILENO);
  const std::optional<Failure> failure = checkStory(story, effort.laws);
  if (leaks()) std::abort();
  std::string text = kVerdictMark;
  if (failure) text += failure->law + "\n" + failure->detail;
  if (write(pipe, text.data(), text.size()) < 0) std::abort();
  // without the destructors of static objects, because the parent owns their networks
  _exit(0);
}

Child start(const Story& story, std::size_t index, const Effort& effort) {
  prepare(story);
  int ends[2];
  if (pipe(ends) != 0) std::abort();
  std::fflush(nullptr);
  Child child;
  child.process = fork();
  if (child.process < 0) std::abort();
  if (child.process == 0) {
    close(ends[0]);
    playInChild(story, ends[1], effort);
  }
  close(ends[1]);
  fcntl(ends[0], F_SETFL, O_NONBLOCK);
  child.pipe = ends[0];
  child.story = index;
  child.start = Clock::now();
  return child;
}

/// Reads the child's output. Returns false once the child has closed its end.
bool readOutput(Child& child) {
  char text[4096];
  for (;;) {
    const ssize_t count = read(child.pipe, text, sizeof text);
    if (count == 0) return false;
    if (count < 0) return true;
    child.output.append(text, static_cast<std::size_t>(count));
    // the start is kept: sanitizers report the cause first
    if (child.output.size() > 200000) child.output.resize(100000);
  }
}

Verdict verdictOf(const Child& child, int status, bool timedOut) {
  if (timedOut || (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)))
    return {"time", "it takes too long"};
  const std::size_t mark = child.output.rfind(kVerdictMark);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && mark != std::string::npos) {
    const std::string text = child.output.substr(mark + std::string(kVerdictMark).size());
    const std::size_t line = text.find('\n');
    if (line == std::string::npos) return {};
    return {text.substr(0, line), text.substr(line + 1)};
  }
  std::string how = WIFSIGNALED(status) ? "signal " + std::to_string(WTERMSIG(status))
                                        : "exit " + std::to_string(WEXITSTATUS(status));
  return {"crash", how + "\n" + child.output.substr(0, 4000)};
}

Verdict end(Child& child, bool timedOut) {
  if (timedOut) kill(child.process, SIGKILL);
  int status = 0;
  waitpid(child.process, &status, 0);
  if (!timedOut) readOutput(child);
  close(child.pipe);
  return verdictOf(child, status, timedOut);
}

}  // namespace

void judge(const std::vector<Story>& stories, const Effort& effort,
           const std::function<void(std::size_t, const Verdict&)>& report) {
  std::vector<Child> children;
  std::size_t next = 0;
  while (next < stories.size() || !children.empty()) {
    while (next < stories.size() && children.size() < static_cast<std::size_t>(effort.jobs)) {
      children.push_back(start(stories[next], next, effort));
      ++next;
    }
    std::vector<pollfd> waits;
    for (const Child& child : children) waits.push_back({child.pipe, POLLIN, 0});
    poll(waits.data(), waits.size(), 200);
    for (std::size_t i = children.size(); i-- > 0;) {
      const std::chrono::duration<double> elapsed = Clock::now() - children[i].start;
      const bool timedOut = elapsed.count() > kWallClockFactor * effort.seconds;
      if (readOutput(children[i]) && !timedOut) continue;
      const std::size_t story = children[i].story;
      const Verdict verdict = end(children[i], timedOut);
      children.erase(children.begin() + static_cast<std::ptrdiff_t>(i));
      report(story, verdict);
    }
  }
}

Verdict judge(const Story& story, const Effort& effort) {
  Verdict verdict;
  judge({story}, {1, effort.seconds, effort.laws},
        [&](std::size_t, const Verdict& result) { verdict = result; });
  return verdict;
}

}  // namespace limber::fuzz

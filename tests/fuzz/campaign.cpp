// SPDX-License-Identifier: Zlib
// Stories in processes of their own: one that crashes or hangs ends nothing but itself.
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
  int pipe = -1;  ///< what it says on standard error and its verdict, which ends it
  std::size_t story = 0;
  std::string said;
  Clock::time_point start;
};

/// A busy machine gives a story a small share of a processor: only its own time counts, and this many times
/// as long on the clock for one that waits for ever.
const double kPatience = 30.0;

void limitProcessorTime(double seconds) {
  const auto whole = static_cast<rlim_t>(seconds + 1.0);
  const rlimit limit{whole, whole + 1};
  setrlimit(RLIMIT_CPU, &limit);
}

const char* const kVerdictMark = "\n=verdict=";

/// Whether anything is lost, of which the sanitizer then tells; false where there is none.
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
  // without the destructors of statics, whose networks are the parent's
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

/// False once the child has closed its end.
bool listen(Child& child) {
  char text[4096];
  for (;;) {
    const ssize_t count = read(child.pipe, text, sizeof text);
    if (count == 0) return false;
    if (count < 0) return true;
    child.said.append(text, static_cast<std::size_t>(count));
    // a report of a sanitizer has its cause first
    if (child.said.size() > 200000) child.said.resize(100000);
  }
}

Verdict verdictOf(const Child& child, int status, bool late) {
  if (late || (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)))
    return {"time", "it takes too long"};
  const std::size_t mark = child.said.rfind(kVerdictMark);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && mark != std::string::npos) {
    const std::string text = child.said.substr(mark + std::string(kVerdictMark).size());
    const std::size_t line = text.find('\n');
    if (line == std::string::npos) return {};
    return {text.substr(0, line), text.substr(line + 1)};
  }
  std::string how = WIFSIGNALED(status) ? "signal " + std::to_string(WTERMSIG(status))
                                        : "exit " + std::to_string(WEXITSTATUS(status));
  return {"crash", how + "\n" + child.said.substr(0, 4000)};
}

Verdict end(Child& child, bool late) {
  if (late) kill(child.process, SIGKILL);
  int status = 0;
  waitpid(child.process, &status, 0);
  if (!late) listen(child);
  close(child.pipe);
  return verdictOf(child, status, late);
}

}  // namespace

void judge(const std::vector<Story>& stories, const Effort& effort,
           const std::function<void(std::size_t, const Verdict&)>& told) {
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
      const std::chrono::duration<double> past = Clock::now() - children[i].start;
      const bool late = past.count() > kPatience * effort.seconds;
      if (listen(children[i]) && !late) continue;
      const std::size_t story = children[i].story;
      const Verdict verdict = end(children[i], late);
      children.erase(children.begin() + static_cast<std::ptrdiff_t>(i));
      told(story, verdict);
    }
  }
}

Verdict judge(const Story& story, const Effort& effort) {
  Verdict verdict;
  judge({story}, {1, effort.seconds, effort.laws}, [&](std::size_t, const Verdict& told) { verdict = told; });
  return verdict;
}

}  // namespace limber::fuzz

// SPDX-License-Identifier: Zlib
#include "mesh_reader.h"

#if defined(__unix__) || defined(__APPLE__)

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>
#include <vector>

namespace limber::demo {
namespace {

// --- the answer: its sizes, then its arrays ----------------------------------------------------------------

/// Bytes of the reason, then entries of positions, normals, uvs and triangles. An empty reason: success.
using Sizes = std::array<std::uint64_t, 5>;

bool writeAll(int pipe, const void* data, std::size_t size) {
  const char* next = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = write(pipe, next, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    next += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

template <class Array>
bool writeArray(int pipe, const Array& array) {
  return writeAll(pipe, array.data(), array.size() * sizeof array[0]);
}

bool writeAnswer(int pipe, const Result<TriangleMesh>& result) {
  const std::string reason = result.error();
  const TriangleMesh none;
  const TriangleMesh& mesh = result ? *result : none;
  const Sizes sizes = {reason.size(), mesh.positions.size(), mesh.normals.size(), mesh.uvs.size(),
                       mesh.triangles.size()};
  return writeArray(pipe, sizes) && writeArray(pipe, reason) && writeArray(pipe, mesh.positions) &&
         writeArray(pipe, mesh.normals) && writeArray(pipe, mesh.uvs) && writeArray(pipe, mesh.triangles);
}

/// Moves `count` entries from the front of the bytes, if there are as many.
template <class Array>
bool takeArray(const std::vector<char>& bytes, std::size_t& at, std::uint64_t count, Array& array) {
  if (count > (bytes.size() - at) / sizeof array[0]) return false;
  array.resize(static_cast<std::size_t>(count));
  const std::size_t size = array.size() * sizeof array[0];
  if (size > 0) std::memcpy(static_cast<void*>(array.data()), bytes.data() + at, size);
  at += size;
  return true;
}

/// Returns the reader's result, or nothing if the bytes are none. Trusts nothing: a reader may have
/// overwritten its own memory.
std::optional<Result<TriangleMesh>> parseAnswer(const std::vector<char>& bytes) {
  Sizes sizes;
  if (bytes.size() < sizeof sizes) return {};
  std::memcpy(sizes.data(), bytes.data(), sizeof sizes);
  std::size_t at = sizeof sizes;
  std::string reason;
  TriangleMesh mesh;
  const bool whole =
      takeArray(bytes, at, sizes[0], reason) && takeArray(bytes, at, sizes[1], mesh.positions) &&
      takeArray(bytes, at, sizes[2], mesh.normals) && takeArray(bytes, at, sizes[3], mesh.uvs) &&
      takeArray(bytes, at, sizes[4], mesh.triangles) && at == bytes.size();
  if (!whole) return {};
  if (!reason.empty()) return Error{std::move(reason)};
  if (!validate(mesh)) return {};
  return mesh;
}

// --- the child ---------------------------------------------------------------------------------------------

/// Sanitizers reserve terabytes of address space.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitsMemory = false;
#else
constexpr bool kLimitsMemory = true;
#endif

void limit(int resource, std::uint64_t soft, std::uint64_t hard) {
  rlimit current{};
  getrlimit(resource, &current);
  const auto within = [&](std::uint64_t value) {
    return std::min(static_cast<rlim_t>(value), current.rlim_max);
  };
  const rlimit changed{within(soft), within(hard)};
  setrlimit(resource, &changed);
}

/// Returns the size of the program's address space, bytes; 0 where the system does not tell.
std::uint64_t addressSpace() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void limitChild(const ReadLimits& limits) {
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE, SIGXCPU}) std::signal(signal, SIG_DFL);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  const auto seconds = static_cast<std::uint64_t>(limits.seconds);
  limit(RLIMIT_CORE, 0, 0);
  limit(RLIMIT_CPU, seconds, seconds + 1);  // SIGXCPU, and a second later SIGKILL
  if (!kLimitsMemory) return;
  const std::uint64_t bytes = addressSpace() + limits.bytes;
  limit(RLIMIT_AS, bytes, bytes);
}

/// Ends without the destructors and exit handlers of the program, which belong to the parent.
[[noreturn]] void runChild(int pipe, const std::string& path, const ReadLimits& limits,
                           const MeshReader& reader) {
  limitChild(limits);
  try {
    _exit(writeAnswer(pipe, reader(path)) ? 0 : 1);
  } catch (...) {
    _exit(2);
  }
}

// --- the parent --------------------------------------------------------------------------------------------

using Clock = std::chrono::steady_clock;

std::string tookTooLong(int seconds) {
  return "the reader took more than " + std::to_string(seconds) + " s: the file is damaged or too large";
}

/// Reads until the child closes the pipe. Returns why it had to stop before; empty if it had not.
std::string readAll(int pipe, const ReadLimits& limits, std::vector<char>& bytes) {
  const Clock::time_point deadline = Clock::now() + std::chrono::seconds(limits.clockSeconds);
  std::array<char, 1 << 16> block;
  while (bytes.size() <= limits.bytes) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return tookTooLong(limits.clockSeconds);
    pollfd waiting{pipe, POLLIN, 0};
    if (poll(&waiting, 1, static_cast<int>(std::min<long long>(left, 60000))) <= 0) continue;
    const ssize_t count = read(pipe, block.data(), block.size());
    if (count == 0) return {};
    if (count > 0) bytes.insert(bytes.end(), block.data(), block.data() + count);
  }
  return "the mesh is larger than " + std::to_string(limits.bytes >> 20) + " MiB";
}

int waitFor(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  return status;
}

/// Returns why the child failed; empty if it did not.
std::string failureOf(int status, const ReadLimits& limits) {
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  if (WIFEXITED(status))
    return "the reader failed (exit code " + std::to_string(WEXITSTATUS(status)) + "): the file is damaged";
  const int signal = WTERMSIG(status);
  if (signal == SIGXCPU) return tookTooLong(limits.seconds);
  if (signal == SIGINT || signal == SIGTERM) return "the reader was stopped";
  return "the reader crashed (signal " + std::to_string(signal) + "): the file is damaged";
}

/// Returns why there is no answer; empty if `bytes` is one.
std::string receive(pid_t child, int pipe, const ReadLimits& limits, std::vector<char>& bytes) {
  const std::string reason = readAll(pipe, limits, bytes);
  if (!reason.empty()) kill(child, SIGKILL);
  const int status = waitFor(child);
  return reason.empty() ? failureOf(status, limits) : reason;
}

}  // namespace

Result<TriangleMesh> readMesh(const std::string& path, const ReadLimits& limits, const MeshReader& reader) {
  const auto fail = [&](const std::string& reason) {
    return Error{"cannot import '" + path + "': " + reason};
  };
  std::array<int, 2> ends;
  if (pipe(ends.data()) != 0) return fail(std::strerror(errno));
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    runChild(ends[1], path, limits, reader);
  }
  std::string reason = child < 0 ? std::strerror(errno) : "";
  close(ends[1]);
  std::vector<char> bytes;
  if (child > 0) reason = receive(child, ends[0], limits, bytes);
  close(ends[0]);
  if (!reason.empty()) return fail(reason);
  const std::optional<Result<TriangleMesh>> answer = parseAnswer(bytes);
  return answer ? *answer : fail("the reader gave a damaged mesh: the file is damaged");
}

}  // namespace limber::demo

#else

namespace limber::demo {

Result<TriangleMesh> readMesh(const std::string& path, const ReadLimits&, const MeshReader& reader) {
  return reader(path);
}

}  // namespace limber::demo

#endif

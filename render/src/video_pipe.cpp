// SPDX-License-Identifier: Zlib
#include "limber/render/video_pipe.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <random>
#include <stdexcept>
#include <system_error>
#include <vector>

extern char** environ;

namespace limber::render {
namespace {

constexpr int kPipeBytes = 1 << 20;

std::string findOnPath(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::string folders = path == nullptr ? "" : path;
  folders += ':';
  std::size_t start = 0;
  for (std::size_t end = folders.find(':'); end != std::string::npos; end = folders.find(':', start)) {
    std::string candidate = folders.substr(start, end - start) + "/" + program;
    if (end > start && access(candidate.c_str(), X_OK) == 0) {
      return candidate;
    }
    start = end + 1;
  }
  return {};
}

// Returns the file that ffmpeg writes, beside the video: its ending tells ffmpeg the format.
std::string partOf(const std::string& path) {
  const std::filesystem::path file(path);
  const std::string name = "part" + std::to_string(std::random_device{}()) + "-" + file.filename().string();
  return (file.parent_path() / name).string();
}

std::vector<std::string> ffmpegArguments(const VideoDesc& desc, const std::string& file) {
  const std::string size = std::to_string(desc.width) + "x" + std::to_string(desc.height);
  // Players need a pixel format with even sizes, so the picture is padded.
  return {"ffmpeg",      "-y",
          "-loglevel",   "error",
          "-f",          "rawvideo",
          "-pix_fmt",    "rgba",
          "-s",          size,
          "-r",          std::to_string(desc.framesPerSecond),
          "-i",          "-",
          "-vf",         "pad=ceil(iw/2)*2:ceil(ih/2)*2",
          "-c:v",        "libx264",
          "-preset",     desc.preset,
          "-crf",        std::to_string(desc.quality),
          "-pix_fmt",    "yuv420p",
          "-movflags",   "+faststart",
          "file:" + file};
}

// Blocks SIGPIPE on this thread and removes the pending one that a failed write leaves.
class PipeSignalGuard {
 public:
  PipeSignalGuard() {
    sigemptyset(&pipeSignal_);
    sigaddset(&pipeSignal_, SIGPIPE);
    sigset_t pending;
    sigpending(&pending);
    wasPending_ = sigismember(&pending, SIGPIPE) == 1;
    pthread_sigmask(SIG_BLOCK, &pipeSignal_, &old_);
  }
  ~PipeSignalGuard() {
    const timespec now{};
    while (!wasPending_ && sigtimedwait(&pipeSignal_, nullptr, &now) == -1 && errno == EINTR) {
    }
    pthread_sigmask(SIG_SETMASK, &old_, nullptr);
  }
  PipeSignalGuard(const PipeSignalGuard&) = delete;
  PipeSignalGuard& operator=(const PipeSignalGuard&) = delete;

 private:
  sigset_t pipeSignal_{};
  sigset_t old_{};
  bool wasPending_ = false;
};

class SpawnActions {
 public:
  SpawnActions(int input, int messages) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, input, STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, messages, STDERR_FILENO);
  }
  ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

pid_t spawn(const std::string& program, std::vector<std::string> arguments, int input, int messages) {
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);
  const SpawnActions actions(input, messages);
  pid_t process = -1;
  const int error = posix_spawn(&process, program.c_str(), actions.get(), nullptr, argv.data(), environ);
  if (error != 0) {
    throw std::runtime_error("cannot start " + program + ": " + std::strerror(error));
  }
  return process;
}

}  // namespace

bool VideoPipe::available() { return !findOnPath("ffmpeg").empty(); }

VideoPipe::VideoPipe(const VideoDesc& desc) : desc_(desc), part_(partOf(desc.path)) {
  const std::string program = findOnPath("ffmpeg");
  if (program.empty()) {
    throw std::runtime_error("cannot write " + desc.path +
                             ": there is no ffmpeg on PATH; install it or write PNG files instead");
  }
  messages_.reset(std::tmpfile());
  std::array<int, 2> ends{-1, -1};
  // Closed on exec, so that other child processes cannot keep the pipe open.
  if (messages_ == nullptr || pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error("cannot write " + desc.path + ": " + std::strerror(errno));
  }
  input_ = ends[1];
#ifdef F_SETPIPE_SZ
  // A larger pipe needs fewer writes per frame; its failure does no harm.
  fcntl(input_, F_SETPIPE_SZ, kPipeBytes);
#endif
  try {
    process_ = spawn(program, ffmpegArguments(desc, part_), ends[0], fileno(messages_.get()));
  } catch (...) {
    close(ends[0]);
    closeInput();
    throw;
  }
  close(ends[0]);
}

VideoPipe::~VideoPipe() {
  if (process_ >= 0 && end()) {
    std::rename(part_.c_str(), desc_.path.c_str());
  }
}

void VideoPipe::write(const Image& image) {
  if (image.width != desc_.width || image.height != desc_.height) {
    throw std::runtime_error("video frame of " + std::to_string(image.width) + " x " +
                             std::to_string(image.height) + " in a video of " + std::to_string(desc_.width) +
                             " x " + std::to_string(desc_.height));
  }
  if (input_ < 0) {
    throw std::runtime_error("video frame after the end of " + desc_.path);
  }
  const PipeSignalGuard guard;
  const std::uint8_t* next = image.rgba.data();
  std::size_t left = image.rgba.size();
  while (left > 0) {
    const ssize_t written = ::write(input_, next, left);
    if (written < 0 && errno != EINTR) {
      failWrite(errno);
    }
    if (written > 0) {
      next += written;
      left -= static_cast<std::size_t>(written);
    }
  }
}

void VideoPipe::finish() {
  if (process_ < 0) {
    return;
  }
  if (!end()) {
    throw std::runtime_error("ffmpeg failed to write " + desc_.path + ffmpegMessages());
  }
  if (std::rename(part_.c_str(), desc_.path.c_str()) != 0) {
    throw std::runtime_error("cannot write " + desc_.path + ": " + std::strerror(errno));
  }
}

void VideoPipe::failWrite(int error) {
  end();
  throw std::runtime_error("ffmpeg stopped while writing " + desc_.path + " (" + std::strerror(error) + ")" +
                           ffmpegMessages());
}

void VideoPipe::closeInput() noexcept {
  if (input_ >= 0) {
    close(input_);
  }
  input_ = -1;
}

bool VideoPipe::end() noexcept {
  closeInput();
  int status = 0;
  while (process_ >= 0 && waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  const bool encoded = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (!encoded) {
    std::remove(part_.c_str());
  }
  return encoded;
}

std::string VideoPipe::ffmpegMessages() const {
  std::array<char, 1024> text{};
  std::rewind(messages_.get());
  const std::size_t length = std::fread(text.data(), 1, text.size() - 1, messages_.get());
  return length == 0 ? "" : ": " + std::string(text.data(), length);
}

}  // namespace limber::render

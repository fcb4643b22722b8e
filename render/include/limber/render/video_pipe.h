// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/image.h"

#include <sys/types.h>
#include <cstdio>
#include <memory>
#include <string>

namespace limber::render {

struct VideoDesc {
  std::string path;  ///< Output file; its ending chooses the container (".mp4").
  int width = 0;
  int height = 0;
  int framesPerSecond = 60;
  std::string preset = "veryfast";  ///< Of libx264.
  int quality = 18;                 ///< Of libx264 (crf): smaller is better.
};

/// Sends frames to an ffmpeg process, started without a shell. If ffmpeg ends too early, that is an error; it
/// never ends this program with SIGPIPE. ffmpeg writes a file beside `path`, which replaces the one at `path`
/// once it is whole. Not safe for several threads at once.
class VideoPipe {
 public:
  /// True if there is an executable ffmpeg on PATH.
  static bool available();

  /// Throws std::runtime_error if ffmpeg is missing or cannot be started.
  explicit VideoPipe(const VideoDesc& desc);
  /// Closes the pipe and waits for ffmpeg; errors are lost (call finish() to get them).
  ~VideoPipe();
  VideoPipe(const VideoPipe&) = delete;
  VideoPipe& operator=(const VideoPipe&) = delete;

  /// Throws std::runtime_error if the size differs from the description or if ffmpeg has
  /// stopped reading; the text contains ffmpeg's messages.
  void write(const Image& image);
  /// Ends the video. Throws std::runtime_error if ffmpeg failed. Later calls do nothing.
  void finish();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  void closeInput() noexcept;
  /// Ends ffmpeg. Returns whether the video is whole; removes the file if it is not.
  bool end() noexcept;
  std::string ffmpegMessages() const;
  [[noreturn]] void failWrite(int error);

  VideoDesc desc_;
  std::string part_;
  std::unique_ptr<std::FILE, CloseFile> messages_;
  int input_ = -1;
  pid_t process_ = -1;
};

}  // namespace limber::render

// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <limber/render/image.h>
#include <limber/render/png_writer_thread.h>
#include <limber/render/video_pipe.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace limber::demo {

/// Where a run's pictures go: numbered PNG files, a video when there is an ffmpeg, and a contact sheet of a
/// dozen of them. Errors are std::runtime_error with the reason.
class PictureOutput {
 public:
  /// The folder must exist, see prepareFolder().
  PictureOutput(const DemoOptions& options, std::int64_t frameCount);

  /// An image to draw the next picture into; its memory may have been used before.
  render::Image blank() { return writer_.takeSpare(); }
  /// Frames come in order, from 0.
  void add(render::Image image);
  /// Waits for the files and writes the contact sheet.
  void finish();

  /// What went wrong with the video, which is no reason to lose the rest; or empty.
  const std::string& videoProblem() const { return videoProblem_; }
  /// One line for people: what is in the folder.
  std::string describe() const;

 private:
  void addTile(const render::Image& image);
  void addToVideo(const render::Image& image);
  void finishVideo();

  std::string folder_;
  std::int64_t frameCount_;
  std::int64_t next_ = 0;
  std::vector<render::Image> tiles_;
  render::PngWriterThread writer_;
  std::unique_ptr<render::VideoPipe> video_;
  std::string videoProblem_;
};

/// True if frame `i` of `count` is one of at most `tiles` (2 or more) on the contact sheet: the first, the
/// last, and some between, closer together at the start.
bool isTile(std::int64_t i, std::int64_t count, std::int64_t tiles);

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <limber/render/apng_file.h>
#include <limber/render/image.h>
#include <limber/render/png_writer_thread.h>
#include <limber/render/video_pipe.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace limber::demo {

/// Where a run's pictures go: numbered PNG files, a video when there is an ffmpeg, a small animated preview,
/// and a contact sheet of a dozen of them. Errors are std::runtime_error with the reason; the frames written
/// by then stay.
class PictureOutput {
 public:
  /// The folder must exist, see prepareFolder().
  PictureOutput(const DemoOptions& options, std::int64_t frameCount);

  /// An image to draw the next picture into; its memory may have been used before.
  render::Image blank() { return writer_.takeSpare(); }
  /// Frames come in order, from 0.
  void add(render::Image image);
  /// Waits for the files, ends video and preview, and writes the contact sheet.
  void finish();

  /// What went wrong with the video, which is no reason to lose the rest; or empty.
  const std::string& videoProblem() const { return videoProblem_; }
  /// One line for people: what is in the folder.
  std::string describe() const;

 private:
  void writeFrame(std::int64_t i, const render::Image& frame);  // on the thread of writer_
  void addTile(const render::Image& image);
  void tryVideo(const std::function<void()>& work);

  std::string folder_;
  std::int64_t frameCount_;
  std::int64_t next_ = 0;
  std::int64_t previewStride_;
  std::vector<render::Image> tiles_;
  std::unique_ptr<render::ApngWriter> preview_;  // used by the thread of writer_, which must end before it
  render::PngWriterThread writer_;
  std::unique_ptr<render::VideoPipe> video_;
  std::string videoProblem_;
};

/// Every how many frames one goes into the preview, so that it shows at most 15 a second.
int previewStride(int framesPerSecond);

/// True if frame `i` of `count` is one of at most `tiles` (2 or more) on the contact sheet: the first, the
/// last, and some between, closer together at the start.
bool isTile(std::int64_t i, std::int64_t count, std::int64_t tiles);

}  // namespace limber::demo

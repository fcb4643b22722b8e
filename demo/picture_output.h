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

/// The pictures of a run: numbered PNG files, a video if ffmpeg is installed, a small animated preview, and a
/// contact sheet of a dozen frames. Throws std::runtime_error with the reason; frames that are already
/// written stay.
class PictureOutput {
 public:
  /// The folder must exist, see prepareFolder().
  PictureOutput(const DemoOptions& options, std::int64_t frameCount);

  /// Returns an image for the next picture; its memory may be reused.
  render::Image blank() { return writer_.takeSpare(); }
  /// Adds the next frame; the first is number 0.
  void add(render::Image image);
  /// Waits for the files, ends video and preview, and writes the contact sheet.
  void finish();

  /// Returns the error of the video, or an empty string. It does not stop the other output.
  const std::string& videoProblem() const { return videoProblem_; }
  /// Returns one line that describes the content of the folder.
  std::string describe() const;

 private:
  void writeFrame(std::int64_t i, const render::Image& frame);  // called on the thread of writer_
  void addTile(const render::Image& image);
  void tryVideo(const std::function<void()>& work);

  std::string folder_;
  std::int64_t frameCount_;
  std::int64_t next_ = 0;
  std::int64_t previewStride_;
  std::vector<render::Image> tiles_;
  std::unique_ptr<render::ApngWriter>
      preview_;  // used by the thread of writer_, so it must be destroyed after writer_
  render::PngWriterThread writer_;
  std::unique_ptr<render::VideoPipe> video_;
  std::string videoProblem_;
};

/// Returns n, so that every n-th frame goes into the preview and it has at most 15 frames per second.
int previewStride(int framesPerSecond);

/// Returns true if frame `i` of `count` is on the contact sheet of at most `tiles` (2 or more): the first,
/// the last and some between, denser at the start.
bool isTile(std::int64_t i, std::int64_t count, std::int64_t tiles);

}  // namespace limber::demo

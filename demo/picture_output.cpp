// SPDX-License-Identifier: Zlib
#include "picture_output.h"

#include "output_files.h"

#include <limber/render/png_file.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace limber::demo {
namespace {

constexpr std::int64_t kTiles = 12;
constexpr double kTileExponent =
    1.5;  // more happens at the start: tile t of n is taken at (t / n)^1.5 of the run
constexpr int kTileColumns = 4;
constexpr int kTileWidth = 400;  // pixels
constexpr int kPreviewWidth = 480;
constexpr int kPreviewRate = 15;  // pictures per second, at most

std::unique_ptr<render::VideoPipe> openVideo(const DemoOptions& options) {
  if (!options.video || !render::VideoPipe::available()) return nullptr;
  render::VideoDesc desc;
  desc.path = options.outFolder + "/" + kVideoName;
  desc.width = options.width;
  desc.height = options.height;
  desc.framesPerSecond = options.framesPerSecond;
  return std::make_unique<render::VideoPipe>(desc);
}

std::unique_ptr<render::ApngWriter> openPreview(const DemoOptions& options) {
  if (!options.preview) return nullptr;
  render::ApngDesc desc;
  desc.path = options.outFolder + "/" + kPreviewName;
  desc.delayNumerator = static_cast<std::uint16_t>(previewStride(options.framesPerSecond));
  desc.delayDenominator = static_cast<std::uint16_t>(options.framesPerSecond);
  return std::make_unique<render::ApngWriter>(desc);
}

}  // namespace

PictureOutput::PictureOutput(const DemoOptions& options, std::int64_t frameCount)
    : folder_(options.outFolder),
      frameCount_(frameCount),
      previewStride_(previewStride(options.framesPerSecond)),
      preview_(openPreview(options)) {
  tryVideo([&] { video_ = openVideo(options); });
}

void PictureOutput::add(render::Image image) {
  if (isTile(next_, frameCount_, kTiles)) addTile(image);
  if (video_) tryVideo([&] { video_->write(image); });
  writer_.submit(std::move(image), [this, i = next_](const render::Image& frame) { writeFrame(i, frame); });
  ++next_;
}

void PictureOutput::writeFrame(std::int64_t i, const render::Image& frame) {
  render::writePng(folder_ + "/" + frameName(i), frame);
  if (preview_ && i % previewStride_ == 0)
    preview_->add(render::scaledDown(frame, std::min(kPreviewWidth, frame.width)));
}

void PictureOutput::addTile(const render::Image& image) {
  tiles_.push_back(render::scaledDown(image, std::min(kTileWidth, image.width)));
}

void PictureOutput::tryVideo(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& error) {
    videoProblem_ = error.what();
    video_.reset();
  }
}

void PictureOutput::finish() {
  writer_.finish();
  if (video_) tryVideo([&] { video_->finish(); });
  if (preview_) preview_->finish();
  if (tiles_.empty()) return;
  const int columns = std::min(kTileColumns, static_cast<int>(tiles_.size()));
  render::writePng(folder_ + "/" + kContactSheetName, render::contactSheet(tiles_, columns, tiles_[0].width));
}

std::string PictureOutput::describe() const {
  std::string text = folder_ + ": " + std::to_string(next_) + " frames, " + kContactSheetName;
  if (preview_) text += std::string(", ") + kPreviewName;
  if (video_) text += std::string(", ") + kVideoName;
  return text;
}

int previewStride(int framesPerSecond) { return (framesPerSecond + kPreviewRate - 1) / kPreviewRate; }

bool isTile(std::int64_t i, std::int64_t count, std::int64_t tiles) {
  if (count <= tiles) return true;
  for (std::int64_t t = 0; t < tiles; ++t) {
    const double fraction = static_cast<double>(t) / static_cast<double>(tiles - 1);
    if (i == static_cast<std::int64_t>(std::pow(fraction, kTileExponent) * static_cast<double>(count - 1)))
      return true;
  }
  return false;
}

}  // namespace limber::demo

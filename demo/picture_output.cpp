// SPDX-License-Identifier: Zlib
#include "picture_output.h"

#include "folders.h"

#include <limber/render/png_file.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace limber::demo {
namespace {

constexpr std::int64_t kTiles = 12;
constexpr double kTileCrowding = 1.5;  // most happens at the start: tile t of n is taken at (t / n)^1.5
constexpr int kTileColumns = 4;
constexpr int kTileWidth = 400;  // pixels

std::unique_ptr<render::VideoPipe> openVideo(const DemoOptions& options) {
  if (!options.video || !render::VideoPipe::available()) return nullptr;
  render::VideoDesc desc;
  desc.path = options.outFolder + "/" + kVideoName;
  desc.width = options.width;
  desc.height = options.height;
  desc.framesPerSecond = options.framesPerSecond;
  return std::make_unique<render::VideoPipe>(desc);
}

}  // namespace

PictureOutput::PictureOutput(const DemoOptions& options, std::int64_t frameCount)
    : folder_(options.outFolder), frameCount_(frameCount), video_(openVideo(options)) {}

void PictureOutput::add(render::Image image) {
  if (isTile(next_, frameCount_, kTiles)) addTile(image);
  addToVideo(image);
  writer_.submit(folder_ + "/" + frameName(next_), std::move(image));
  ++next_;
}

// a sheet of one picture is that picture at the size of a tile: small enough to keep
void PictureOutput::addTile(const render::Image& image) {
  tiles_.push_back(render::contactSheet({image}, 1, std::min(kTileWidth, image.width)));
}

void PictureOutput::addToVideo(const render::Image& image) {
  if (!video_) return;
  try {
    video_->write(image);
  } catch (const std::exception& error) {
    videoProblem_ = error.what();
    video_.reset();
  }
}

void PictureOutput::finishVideo() {
  if (!video_) return;
  try {
    video_->finish();
  } catch (const std::exception& error) {
    videoProblem_ = error.what();
    video_.reset();
  }
}

void PictureOutput::finish() {
  writer_.finish();
  finishVideo();
  if (tiles_.empty()) return;
  const int columns = std::min(kTileColumns, static_cast<int>(tiles_.size()));
  render::writePng(folder_ + "/" + kContactSheetName, render::contactSheet(tiles_, columns, tiles_[0].width));
}

std::string PictureOutput::describe() const {
  const std::string frames = std::to_string(next_) + " frames, " + kContactSheetName;
  return folder_ + ": " + frames + (video_ ? std::string(", ") + kVideoName : std::string());
}

bool isTile(std::int64_t i, std::int64_t count, std::int64_t tiles) {
  if (count <= tiles) return true;
  for (std::int64_t t = 0; t < tiles; ++t) {
    const double share = static_cast<double>(t) / static_cast<double>(tiles - 1);
    if (i == static_cast<std::int64_t>(std::pow(share, kTileCrowding) * static_cast<double>(count - 1)))
      return true;
  }
  return false;
}

}  // namespace limber::demo

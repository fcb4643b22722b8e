// SPDX-License-Identifier: Zlib
#include "limber/render/apng_file.h"

#include <png.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "apng_chunks.h"
#include "atomic_file.h"
#include "png_encoder.h"

namespace limber::render {
namespace {

// Filters are for smooth pictures; among transparent pixels they do harm.
constexpr PngStyle kSmall{6, PNG_FILTER_NONE};

bool differ(const Image& a, const Image& b, int x, int y) {
  return std::memcmp(a.pixel(x, y), b.pixel(x, y), 4) != 0;
}

// Around all pixels that differ; one pixel if none does, for a frame cannot be empty.
PixelArea changedArea(const Image& before, const Image& after) {
  int x0 = after.width, y0 = after.height, x1 = -1, y1 = -1;
  for (int y = 0; y < after.height; ++y) {
    for (int x = 0; x < after.width; ++x) {
      if (differ(before, after, x, y)) {
        x0 = std::min(x0, x);
        y0 = std::min(y0, y);
        x1 = std::max(x1, x);
        y1 = y;
      }
    }
  }
  return y1 < 0 ? PixelArea{0, 0, 1, 1} : PixelArea{x0, y0, x1 - x0 + 1, y1 - y0 + 1};
}

// An area of a frame, transparent where it is as before.
Image changes(const Image& before, const Image& after, const PixelArea& area) {
  Image out;
  out.resize(area.width, area.height);
  for (int y = 0; y < area.height; ++y) {
    for (int x = 0; x < area.width; ++x) {
      if (differ(before, after, area.x + x, area.y + y)) {
        std::memcpy(out.pixel(x, y), after.pixel(area.x + x, area.y + y), 4);
      }
    }
  }
  return out;
}

Image opaque(Image image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    image.rgba[i] = 255;
  }
  return image;
}

}  // namespace

ApngWriter::ApngWriter(const ApngDesc& desc) : desc_(desc), file_(std::make_unique<AtomicFile>(desc.path)) {}

ApngWriter::~ApngWriter() = default;

void ApngWriter::add(const Image& image) {
  const bool first = frames_ == 0;
  if (!first && (image.width != previous_.width || image.height != previous_.height)) {
    throw std::runtime_error("cannot write " + desc_.path + ": its pictures differ in size");
  }
  Image frame = opaque(image);
  const PixelArea area = first ? PixelArea{0, 0, frame.width, frame.height} : changedArea(previous_, frame);
  const Image part = first ? frame : changes(previous_, frame, area);
  const PngParts png = splitPng(encodePng(desc_.path, part, kSmall));
  if (first) {
    writeHead(png.head);
  }
  file_->write(frameControl(sequence_++, area, desc_.delayNumerator, desc_.delayDenominator));
  file_->write(first ? firstFrame(png.pixels) : laterFrame(sequence_++, png.pixels));
  previous_ = std::move(frame);
  ++frames_;
}

// How many frames there are turns out at the end.
void ApngWriter::writeHead(const std::vector<std::uint8_t>& head) {
  file_->write(head);
  animationControlAt_ = file_->size();
  file_->write(animationControl(0));
}

void ApngWriter::finish() {
  if (frames_ == 0) {
    throw std::runtime_error("cannot write " + desc_.path + ": it has no picture");
  }
  file_->write(imageEnd());
  file_->overwrite(animationControlAt_, animationControl(frames_));
  file_->commit();
}

}  // namespace limber::render

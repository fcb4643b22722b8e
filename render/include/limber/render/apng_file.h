// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/image.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace limber::render {

class AtomicFile;

struct ApngDesc {
  std::string path;                  ///< Should end in ".png": most programs need that to show it.
  std::uint16_t delayNumerator = 1;  ///< Each frame is shown for delayNumerator / delayDenominator s.
  std::uint16_t delayDenominator = 15;
};

/// Writes an animated PNG, 8 bits of red, green and blue in sRGB. Any browser plays it in an endless loop;
/// other programs show its first frame. A later frame stores only the pixels that differ from the frame
/// before. Equal frames make equal bytes. Format: PNG Specification, Third Edition, W3C 2025, 11.3.4 (acTL,
/// fcTL, fdAT).
///
/// The file appears at `path` when finish() succeeds, and not at all otherwise. Throws std::runtime_error
/// with the path and the reason (no such folder, no permission, disk full, ...); do not call add() or
/// finish() after an error. Not safe for several threads at once.
class ApngWriter {
 public:
  explicit ApngWriter(const ApngDesc& desc);
  /// Removes the temporary file if finish() was not called.
  ~ApngWriter();
  ApngWriter(const ApngWriter&) = delete;
  ApngWriter& operator=(const ApngWriter&) = delete;

  /// Appends a frame; alpha is ignored. Also throws if the image is empty or differs in size from the first
  /// frame.
  void add(const Image& image);
  /// Ends the file and renames it to `path`. Also throws if there is no frame.
  void finish();

 private:
  void writeHead(const std::vector<std::uint8_t>& head);

  ApngDesc desc_;
  std::unique_ptr<AtomicFile> file_;
  Image previous_;
  long animationControlOffset_ = 0;  // In the file, of the chunk with the number of frames.
  std::uint32_t frames_ = 0;
  std::uint32_t sequence_ = 0;  // Number of the next frame chunk; the format requires it.
};

}  // namespace limber::render

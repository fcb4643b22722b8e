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
  std::string path;                  ///< Ends in ".png" for most programs to show it.
  std::uint16_t delayNumerator = 1;  ///< Each frame is shown for delayNumerator / delayDenominator s.
  std::uint16_t delayDenominator = 15;
};

/// Writes an animated PNG, 8 bits of red, green and blue in sRGB, played in an endless loop by any
/// browser (other programs show its first frame). Of each later frame only the pixels are kept that
/// differ from the one before. Equal frames make equal bytes. Format: PNG Specification, Third Edition,
/// W3C 2025, 11.3.4 (acTL, fcTL, fdAT).
///
/// Appears at `path` when finished, and not at all otherwise. Errors are std::runtime_error naming the
/// path and the reason (no such folder, no permission, disk full, ...); add() or finish() must not be
/// called after one. Not safe for several threads at once.
class ApngWriter {
 public:
  explicit ApngWriter(const ApngDesc& desc);
  /// Leaves nothing behind if finish() has not been called.
  ~ApngWriter();
  ApngWriter(const ApngWriter&) = delete;
  ApngWriter& operator=(const ApngWriter&) = delete;

  /// Appends a frame; alpha is ignored. An error, too, if it is empty or not of the first one's size.
  void add(const Image& image);
  /// Ends the file and gives it its name. An error, too, if it has no frame.
  void finish();

 private:
  void writeHead(const std::vector<std::uint8_t>& head);

  ApngDesc desc_;
  std::unique_ptr<AtomicFile> file_;
  Image previous_;
  long animationControlAt_ = 0;  // Where in the file the number of frames is.
  std::uint32_t frames_ = 0;
  std::uint32_t sequence_ = 0;  // Counts the chunks of frames, as the format asks for.
};

}  // namespace limber::render

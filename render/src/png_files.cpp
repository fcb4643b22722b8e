// SPDX-License-Identifier: Zlib
// Writes PNG files, animated ones, and those of a thread of its own.

#include "limber/render/apng_file.h"
#include "limber/render/image.h"
#include "limber/render/png_file.h"
#include "limber/render/png_writer_thread.h"
#include "pixels.h"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace limber::render {
namespace {

using Bytes = std::vector<std::uint8_t>;

[[noreturn]] void failWrite(const std::string& path, const std::string& reason) {
  throw std::runtime_error("cannot write " + path + ": " + reason);
}

[[noreturn]] void failRead(const std::string& path, const char* reason) {
  throw std::runtime_error("cannot read " + path + ": " + reason);
}

constexpr int kMaxLinks = 40;  // as Linux

// Returns what a path leads to, through links. Throws if that is a folder or a device: renaming a file to it
// would replace it.
std::string fileAt(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::path target = path;
  for (int links = 0; fs::is_symlink(target, error); ++links) {
    if (links == kMaxLinks) {
      failWrite(path, "too many levels of symbolic links");
    }
    target = target.parent_path() / fs::read_symlink(target, error);
  }
  if (fs::exists(target, error) && !fs::is_regular_file(target, error)) {
    failWrite(path, "it is no regular file");
  }
  return target.string();
}

}  // namespace

/// A file that is complete or absent: it is written under a temporary name next to `path` and renamed by
/// commit(), or removed without it. Throws std::runtime_error with the path and the reason; after an error,
/// only the destructor may be called.
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path)
      : path_(fileAt(path)),
        temporary_(path_ + ".part" + std::to_string(std::random_device{}())),
        file_(std::fopen(temporary_.c_str(), "wb")) {
    require(file_ != nullptr);
  }
  ~AtomicFile() {
    if (!named_) {
      file_.reset();
      std::remove(temporary_.c_str());
    }
  }
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends bytes.
  void write(const Bytes& bytes) {
    require(std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size());
  }
  /// Returns the number of bytes written so far.
  long size() const { return std::ftell(file_.get()); }
  /// Overwrites bytes from an offset on; nothing can be appended after that.
  void overwrite(long offset, const Bytes& bytes) {
    // Seeking writes the buffered bytes, and that can fail, too.
    require(std::fseek(file_.get(), offset, SEEK_SET) == 0);
    write(bytes);
  }
  /// Ends the file and renames it to `path`.
  void commit() {
    // Closing also writes the buffered bytes.
    require(std::fclose(file_.release()) == 0 && std::rename(temporary_.c_str(), path_.c_str()) == 0);
    named_ = true;
  }

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void require(bool ok) const {
    if (!ok) {
      failWrite(path_, std::strerror(errno));
    }
  }

  std::string path_;
  std::string temporary_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  bool named_ = false;
};

namespace {

// Fast: zlib's level 3 without filters. Small: level 6 with filters.
enum class PngSize { Fast, Small };

// Returns the bytes of a PNG file with the pixels of an image, 4 or (PNG_FORMAT_RGB) 3 bytes each, in sRGB.
// Throws std::runtime_error with `path` and libpng's reason.
Bytes encodePng(const std::string& path, const Image& image, const Bytes& pixels, std::uint32_t format,
                PngSize size) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = format;
  header.flags = size == PngSize::Fast ? PNG_IMAGE_FLAG_FAST : 0;
  png_alloc_size_t count = PNG_IMAGE_PNG_SIZE_MAX(header);
  Bytes bytes(count);
  if (png_image_write_to_memory(&header, bytes.data(), &count, 0, pixels.data(), 0, nullptr) == 0) {
    failWrite(path, header.message);
  }
  bytes.resize(count);
  return bytes;
}

bool isOpaque(const Image& image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    if (image.rgba[i] != 255) {
      return false;
    }
  }
  return true;
}

Bytes rgbOf(const Image& image) {
  Bytes rgb(image.rgba.size() / 4 * 3);
  for (std::size_t from = 0, to = 0; to < rgb.size(); from += 4, to += 3) {
    std::copy_n(&image.rgba[from], 3, &rgb[to]);
  }
  return rgb;
}

}  // namespace

void writePng(const std::string& path, const Image& image) {
  if (image.width < 1 || image.height < 1) {
    failWrite(path, "the image is empty");
  }
  AtomicFile file(path);
  file.write(isOpaque(image) ? encodePng(path, image, rgbOf(image), PNG_FORMAT_RGB, PngSize::Fast)
                             : encodePng(path, image, image.rgba, PNG_FORMAT_RGBA, PngSize::Fast));
  file.commit();
}

Image readPng(const std::string& path) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&header, path.c_str()) == 0) {
    failRead(path, header.message);
  }
  header.format = PNG_FORMAT_RGBA;
  Image image;
  image.resize(static_cast<int>(header.width), static_cast<int>(header.height));
  if (png_image_finish_read(&header, nullptr, image.rgba.data(), 0, nullptr) == 0) {
    failRead(path, header.message);
  }
  return image;
}

namespace {

// The chunks of an animated PNG (PNG Specification, Third Edition, 5.3 and 11.3.4), each whole: length,
// type, data and CRC.

constexpr std::size_t kSignatureBytes = 8;
constexpr std::size_t kTypeBytes = 4;
constexpr std::size_t kChunkFrame = 12;  // Length, type and CRC.
constexpr std::uint32_t kForEver = 0;
constexpr std::uint8_t kKeep = 0;  // dispose_op: the frame stays below the next one.
constexpr std::uint8_t kOver = 1;  // blend_op: transparent pixels show the frame before.

void put16(Bytes& bytes, std::uint32_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8 & 255));
  bytes.push_back(static_cast<std::uint8_t>(value & 255));
}

void put32(Bytes& bytes, std::uint32_t value) {
  put16(bytes, value >> 16);
  put16(bytes, value & 65535);
}

std::uint32_t get32(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 |
         std::uint32_t{bytes[3]};
}

Bytes chunk(const char* type, const Bytes& data) {
  Bytes bytes;
  bytes.reserve(data.size() + kChunkFrame);
  put32(bytes, static_cast<std::uint32_t>(data.size()));
  bytes.insert(bytes.end(), type, type + kTypeBytes);
  bytes.insert(bytes.end(), data.begin(), data.end());
  // The CRC covers the type and the data.
  const uLong crc = crc32(0, &bytes[4], static_cast<uInt>(bytes.size() - 4));
  put32(bytes, static_cast<std::uint32_t>(crc));
  return bytes;
}

/// The signature and all chunks of a PNG file before its pixels, and its pixels as one zlib stream.
struct PngParts {
  Bytes head;
  Bytes pixels;
};

PngParts splitPng(const Bytes& png) {
  PngParts parts;
  parts.head.assign(png.begin(), png.begin() + kSignatureBytes);
  std::size_t size = 0;
  for (std::size_t at = kSignatureBytes; at < png.size(); at += size) {
    const std::uint8_t* begin = &png[at];
    size = get32(begin) + kChunkFrame;
    if (std::memcmp(begin + 4, "IDAT", kTypeBytes) == 0) {
      parts.pixels.insert(parts.pixels.end(), begin + 8, begin + size - 4);
    } else if (std::memcmp(begin + 4, "IEND", kTypeBytes) != 0) {
      parts.head.insert(parts.head.end(), begin, begin + size);
    }
  }
  return parts;
}

/// Returns acTL: the number of frames, in an endless loop.
Bytes animationControl(std::uint32_t frames) {
  Bytes data;
  put32(data, frames);
  put32(data, kForEver);
  return chunk("acTL", data);
}

/// Returns fcTL: the next frame is drawn over an area of the frame before, stays, and is shown for numerator
/// / denominator s.
Bytes frameControl(std::uint32_t sequence, const PixelArea& area, std::uint16_t delayNumerator,
                   std::uint16_t delayDenominator) {
  Bytes data;
  put32(data, sequence);
  for (const int value : {area.width, area.height, area.x, area.y}) {
    put32(data, static_cast<std::uint32_t>(value));
  }
  put16(data, delayNumerator);
  put16(data, delayDenominator);
  data.push_back(kKeep);
  data.push_back(kOver);
  return chunk("fcTL", data);
}

/// Returns fdAT, a later frame's pixels.
Bytes laterFrame(std::uint32_t sequence, const Bytes& pixels) {
  Bytes data;
  data.reserve(4 + pixels.size());
  put32(data, sequence);
  data.insert(data.end(), pixels.begin(), pixels.end());
  return chunk("fdAT", data);
}

bool differ(const Image& a, const Image& b, int x, int y) {
  return std::memcmp(a.pixel(x, y), b.pixel(x, y), 4) != 0;
}

// Returns the smallest area with all pixels that differ. If there are none it is one pixel, because a frame
// cannot be empty.
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

// Returns an area of a frame; pixels that have not changed are transparent.
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
    failWrite(desc_.path, "its pictures differ in size");
  }
  Image frame = opaque(image);
  const PixelArea area = first ? PixelArea{0, 0, frame.width, frame.height} : changedArea(previous_, frame);
  const Image part = first ? frame : changes(previous_, frame, area);
  const PngParts png = splitPng(encodePng(desc_.path, part, part.rgba, PNG_FORMAT_RGBA, PngSize::Small));
  if (first) {
    writeHead(png.head);
  }
  file_->write(frameControl(sequence_++, area, desc_.delayNumerator, desc_.delayDenominator));
  file_->write(first ? chunk("IDAT", png.pixels) : laterFrame(sequence_++, png.pixels));
  previous_ = std::move(frame);
  ++frames_;
}

// The number of frames is not known yet: finish() overwrites it.
void ApngWriter::writeHead(const Bytes& head) {
  file_->write(head);
  animationControlOffset_ = file_->size();
  file_->write(animationControl(0));
}

void ApngWriter::finish() {
  if (frames_ == 0) {
    failWrite(desc_.path, "it has no picture");
  }
  file_->write(chunk("IEND", {}));
  file_->overwrite(animationControlOffset_, animationControl(frames_));
  file_->commit();
}

// --- a thread that writes ----------------------------------------------------------------------------------

PngWriterThread::PngWriterThread() {
  thread_ = std::thread([this] { run(); });
}

PngWriterThread::~PngWriterThread() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void PngWriterThread::submit(std::string path, Image image) {
  submit(std::move(image), [path = std::move(path)](const Image& picture) { writePng(path, picture); });
}

void PngWriterThread::submit(Image image, std::function<void(const Image&)> work) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return queue_.size() < kQueueLimit || error_ != nullptr; });
  throwPendingError(lock);
  queue_.push_back({std::move(image), std::move(work)});
  lock.unlock();
  changed_.notify_all();
}

Image PngWriterThread::takeSpare() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (spares_.empty()) {
    return {};
  }
  Image spare = std::move(spares_.back());
  spares_.pop_back();
  return spare;
}

void PngWriterThread::finish() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return queue_.empty() && !busy_; });
  throwPendingError(lock);
}

void PngWriterThread::throwPendingError(std::unique_lock<std::mutex>& lock) {
  if (error_ == nullptr) {
    return;
  }
  const std::exception_ptr error = std::exchange(error_, nullptr);
  lock.unlock();
  std::rethrow_exception(error);
}

void PngWriterThread::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
    if (queue_.empty()) {
      return;
    }
    Job job = std::move(queue_.front());
    queue_.pop_front();
    busy_ = true;
    lock.unlock();
    changed_.notify_all();
    std::exception_ptr error;
    try {
      job.work(job.image);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    busy_ = false;
    if (error_ == nullptr) {
      error_ = error;
    }
    if (spares_.size() < kQueueLimit) {
      spares_.push_back(std::move(job.image));
    }
    changed_.notify_all();
  }
}

}  // namespace limber::render

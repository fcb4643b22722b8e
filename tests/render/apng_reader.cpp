// SPDX-License-Identifier: Zlib
#include "apng_reader.h"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace limber::render {
namespace {

using Bytes = std::vector<std::uint8_t>;

const Bytes kSignature{137, 80, 78, 71, 13, 10, 26, 10};

struct Chunk {
  std::string type;
  Bytes data;
};

void require(bool good, const std::string& problem) {
  if (!good) throw std::runtime_error(problem);
}

std::uint32_t number(const Bytes& bytes, std::size_t at, std::size_t size = 4) {
  require(at + size <= bytes.size(), "cut off");
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | bytes[at + i];
  return value;
}

void append(Bytes& bytes, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(value >> shift & 255));
}

std::uint32_t crcOf(const Chunk& chunk) {
  Bytes bytes(chunk.type.begin(), chunk.type.end());
  bytes.insert(bytes.end(), chunk.data.begin(), chunk.data.end());
  return static_cast<std::uint32_t>(crc32(0, bytes.data(), static_cast<uInt>(bytes.size())));
}

std::vector<Chunk> readChunks(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  require(bytes.size() > 8 && std::equal(kSignature.begin(), kSignature.end(), bytes.begin()), "no PNG");
  std::vector<Chunk> chunks;
  for (std::size_t at = 8; at < bytes.size();) {
    const std::size_t size = number(bytes, at);
    require(at + size + 12 <= bytes.size(), "cut off");
    const auto type = bytes.begin() + static_cast<std::ptrdiff_t>(at) + 4;
    chunks.push_back({{type, type + 4}, {type + 4, type + 4 + static_cast<std::ptrdiff_t>(size)}});
    require(crcOf(chunks.back()) == number(bytes, at + 8 + size), "wrong CRC of " + chunks.back().type);
    at += size + 12;
  }
  return chunks;
}

void appendChunk(Bytes& png, const Chunk& chunk) {
  append(png, static_cast<std::uint32_t>(chunk.data.size()));
  png.insert(png.end(), chunk.type.begin(), chunk.type.end());
  png.insert(png.end(), chunk.data.begin(), chunk.data.end());
  append(png, crcOf(chunk));
}

// Decodes pixels with libpng, as a separate picture.
Image decode(const Chunk& header, std::uint32_t width, std::uint32_t height, const Bytes& pixels) {
  Chunk newHeader{"IHDR", {}};
  append(newHeader.data, width);
  append(newHeader.data, height);
  newHeader.data.insert(newHeader.data.end(), header.data.begin() + 8, header.data.end());
  Bytes png = kSignature;
  for (const Chunk& chunk : {newHeader, Chunk{"IDAT", pixels}, Chunk{"IEND", {}}}) appendChunk(png, chunk);
  png_image reader{};
  reader.version = PNG_IMAGE_VERSION;
  require(png_image_begin_read_from_memory(&reader, png.data(), png.size()) != 0, reader.message);
  reader.format = PNG_FORMAT_RGBA;
  Image image;
  image.resize(static_cast<int>(reader.width), static_cast<int>(reader.height));
  require(png_image_finish_read(&reader, nullptr, image.rgba.data(), 0, nullptr) != 0, reader.message);
  return image;
}

void drawOver(Image& canvas, const Image& part, const ApngFrame& frame) {
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      const std::uint8_t* pixel = part.pixel(x, y);
      require(pixel[3] == 0 || pixel[3] == 255, "half transparent");
      if (pixel[3] == 255) {
        std::copy(pixel, pixel + 4,
                  canvas.pixel(static_cast<int>(frame.x) + x, static_cast<int>(frame.y) + y));
      }
    }
  }
}

class Reader {
 public:
  void take(const Chunk& chunk) {
    if (chunk.type == "IHDR") header_ = chunk;
    if (chunk.type == "acTL") takeAnimation(chunk.data);
    if (chunk.type == "fcTL") takeFrame(chunk.data);
    if (chunk.type == "IDAT") takePixels(chunk.data, true);
    if (chunk.type == "fdAT") {
      takeSequence(chunk.data);
      takePixels({chunk.data.begin() + 4, chunk.data.end()}, false);
    }
  }
  Apng finish() {
    require(animated_ && apng_.frames.size() == count_, "not as many frames as acTL says");
    for (std::size_t i = 0; i < apng_.frames.size(); ++i) {
      ApngFrame& frame = apng_.frames[i];
      drawOver(canvas_, decode(header_, frame.width, frame.height, pixels_[i]), frame);
      frame.shown = canvas_;
    }
    return std::move(apng_);
  }

 private:
  void takeAnimation(const Bytes& data) {
    require(!header_.data.empty() && apng_.frames.empty() && data.size() == 8, "acTL in the wrong place");
    animated_ = true;
    count_ = number(data, 0);
    apng_.plays = number(data, 4);
    canvas_.resize(static_cast<int>(number(header_.data, 0)), static_cast<int>(number(header_.data, 4)));
  }
  void takeSequence(const Bytes& data) { require(number(data, 0) == sequence_++, "wrong sequence number"); }
  void takeFrame(const Bytes& data) {
    require(animated_ && data.size() == 26, "fcTL in the wrong place");
    takeSequence(data);
    const ApngFrame frame{number(data, 4),
                          number(data, 8),
                          number(data, 12),
                          number(data, 16),
                          static_cast<std::uint16_t>(number(data, 20, 2)),
                          static_cast<std::uint16_t>(number(data, 22, 2)),
                          {}};
    require(frame.x + frame.width <= static_cast<std::uint32_t>(canvas_.width) &&
                frame.y + frame.height <= static_cast<std::uint32_t>(canvas_.height),
            "a frame outside the picture");
    require(data[24] == 0 && data[25] == 1, "not kept and blended over");
    apng_.frames.push_back(frame);
    pixels_.emplace_back();
  }
  void takePixels(const Bytes& data, bool first) {
    require(!apng_.frames.empty() && (apng_.frames.size() == 1) == first, "pixels in the wrong place");
    pixels_.back().insert(pixels_.back().end(), data.begin(), data.end());
  }

  Chunk header_;
  Apng apng_;
  std::vector<Bytes> pixels_;
  Image canvas_;
  bool animated_ = false;
  std::uint32_t count_ = 0;
  std::uint32_t sequence_ = 0;
};

}  // namespace

Apng readApng(const std::string& path) {
  const std::vector<Chunk> chunks = readChunks(path);
  require(chunks.front().type == "IHDR" && chunks.back().type == "IEND", "no IHDR or IEND");
  Reader reader;
  for (const Chunk& chunk : chunks) reader.take(chunk);
  return reader.finish();
}

}  // namespace limber::render

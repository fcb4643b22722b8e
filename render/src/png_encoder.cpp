// SPDX-License-Identifier: Zlib
#include "png_encoder.h"

#include <png.h>

#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <new>
#include <stdexcept>

namespace limber::render {
namespace {

using Bytes = std::vector<std::uint8_t>;
using ErrorText = std::array<char, 256>;

constexpr std::size_t kBufferBytes = 1 << 16;

// libpng reports errors by leaving through longjmp, so no object with a destructor may live in the
// functions that call it, and no exception may pass through it.
void onError(png_structp png, png_const_charp text) {
  auto& out = *static_cast<ErrorText*>(png_get_error_ptr(png));
  std::snprintf(out.data(), out.size(), "%s", text);
  png_longjmp(png, 1);
}

void onWarning(png_structp, png_const_charp) {}

bool append(Bytes& bytes, const std::uint8_t* data, std::size_t size) noexcept {
  try {
    bytes.insert(bytes.end(), data, data + size);
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

void onWrite(png_structp png, png_bytep data, std::size_t size) {
  if (!append(*static_cast<Bytes*>(png_get_io_ptr(png)), data, size)) {
    png_error(png, "out of memory");
  }
}

void onFlush(png_structp) {}

void writeHeader(png_structp png, png_infop info, const Image& image, const PngStyle& style) {
  png_set_compression_level(png, style.level);
  png_set_compression_buffer_size(png, kBufferBytes);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, style.filters);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 8,
               PNG_COLOR_TYPE_RGBA, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, info);
}

bool encode(Bytes& bytes, const Image& image, const PngStyle& style, ErrorText& error) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &error, onError, onWarning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &bytes, onWrite, onFlush);
  writeHeader(png, info, image, style);
  for (int y = 0; y < image.height; ++y) {
    png_write_row(png, image.pixel(0, y));
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

std::vector<std::uint8_t> encodePng(const std::string& path, const Image& image, const PngStyle& style) {
  Bytes bytes;
  ErrorText error{"out of memory"};
  if (!encode(bytes, image, style, error)) {
    throw std::runtime_error("cannot write " + path + ": " + error.data());
  }
  return bytes;
}

}  // namespace limber::render

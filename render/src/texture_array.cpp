// SPDX-License-Identifier: Zlib
#include "texture_array.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "texture_resample.h"

namespace limber::render {
namespace {

GLsizei levelsFor(int size) {
  GLsizei levels = 1;
  while ((size >> levels) > 0) {
    ++levels;
  }
  return levels;
}

}  // namespace

TextureArray::TextureArray(const Gl& gl, int size)
    : gl_(gl), size_(size), levels_(levelsFor(size)), texture_(make(1)) {}

GlTexture TextureArray::make(std::uint32_t layers) const {
  std::size_t bytes = 0;
  for (GLsizei level = 0; level < levels_; ++level) {
    const auto side = static_cast<std::size_t>(size_ >> level);
    bytes += 4 * side * side * layers;
  }
  GLuint name = 0;
  gl_.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  GlTexture texture(gl_, name, bytes);
  gl_.TextureStorage3D(name, levels_, GL_SRGB8_ALPHA8, size_, size_, static_cast<GLsizei>(layers));
  gl_.TextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl_.TextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TextureParameteri(name, GL_TEXTURE_WRAP_S, GL_REPEAT);
  gl_.TextureParameteri(name, GL_TEXTURE_WRAP_T, GL_REPEAT);
  return texture;
}

void TextureArray::grow() {
  GLint limit = 0;
  gl_.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &limit);
  if (capacity_ >= static_cast<std::uint32_t>(limit)) {
    throw std::runtime_error("this driver holds no more than " + std::to_string(limit) + " textures");
  }
  const std::uint32_t capacity = std::min(2 * capacity_, static_cast<std::uint32_t>(limit));
  GlTexture larger = make(capacity);
  for (GLint level = 0; level < levels_; ++level) {
    const GLsizei side = size_ >> level;
    gl_.CopyImageSubData(texture_.name(), GL_TEXTURE_2D_ARRAY, level, 0, 0, 0, larger.name(),
                         GL_TEXTURE_2D_ARRAY, level, 0, 0, 0, side, side, static_cast<GLsizei>(count_));
  }
  texture_ = std::move(larger);
  capacity_ = capacity;
}

std::uint32_t TextureArray::add(int width, int height, const std::uint8_t* rgba) {
  if (width < 1 || height < 1 || rgba == nullptr) {
    throw std::runtime_error("a texture needs at least one pixel, not " + std::to_string(width) + " x " +
                             std::to_string(height));
  }
  if (count_ == capacity_) {
    grow();
  }
  const std::vector<std::uint8_t> square = resampleToSquare(width, height, rgba, size_);
  gl_.TextureSubImage3D(texture_.name(), 0, 0, 0, static_cast<GLint>(count_), size_, size_, 1, GL_RGBA,
                        GL_UNSIGNED_BYTE, square.data());
  gl_.GenerateTextureMipmap(texture_.name());
  return count_++;
}

}  // namespace limber::render

// SPDX-License-Identifier: Zlib
#include "pixels.h"

#include <gtest/gtest.h>

namespace limber::render {
namespace {

TEST(TextureResample, SameSizeIsACopy) {
  const std::vector<std::uint8_t> pixels{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
  EXPECT_EQ(resampleToSquare(2, 2, pixels.data(), 2), pixels);
}

TEST(TextureResample, PlainColourStaysWhateverTheSize) {
  const std::vector<std::uint8_t> pixels{200, 100, 50, 128, 200, 100, 50, 128, 200, 100, 50, 128};
  for (const int size : {1, 2, 5, 16}) {
    const std::vector<std::uint8_t> out = resampleToSquare(3, 1, pixels.data(), size);
    ASSERT_EQ(out.size(), 4u * static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
    for (std::size_t i = 0; i < out.size(); ++i) {
      EXPECT_EQ(out[i], pixels[i % 4]);
    }
  }
}

TEST(TextureResample, BlackAndWhiteMeetInLinearLight) {
  const std::vector<std::uint8_t> pixels{0, 0, 0, 255, 255, 255, 255, 255};
  EXPECT_NEAR(resampleToSquare(2, 1, pixels.data(), 1)[0], 188, 1);
}

}  // namespace
}  // namespace limber::render

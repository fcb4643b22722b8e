// SPDX-License-Identifier: Zlib
// Files of pictures, and pictures in other sizes.
#include "limber/render/image.h"

#include "import/temporary_folder.h"
#include "limber/render/png_file.h"
#include "limber/render/png_writer_thread.h"
#include "pictures.h"
#include "pixels.h"
#include "support/file_size_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace limber::render {
namespace {

namespace fs = std::filesystem;
using test::noise;

class ImageFile : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder / name).string(); }
  std::size_t fileCount() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }

  TemporaryFolder made;
  fs::path folder = made.path();
};

TEST_F(ImageFile, PngRoundTrip) {
  const Image image = noise(37, 21);
  writePng(path("a.png"), image);
  const Image back = readPng(path("a.png"));
  EXPECT_EQ(back.width, 37);
  EXPECT_EQ(back.height, 21);
  EXPECT_EQ(back.rgba, image.rgba);
  EXPECT_EQ(fileCount(), 1u) << "the temporary file must be gone";
}

TEST_F(ImageFile, MissingFolderIsNamed) {
  try {
    writePng(path("no/such/a.png"), noise(4, 4));
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("no/such/a.png: No such file"), std::string::npos)
        << error.what();
  }
}

TEST_F(ImageFile, FullDiskIsAnErrorAndLeavesNoHalfFile) {
  const limber::test::FileSizeLimit limit(1000);
  EXPECT_THROW(writePng(path("a.png"), noise(64, 64)), std::runtime_error);
  EXPECT_THROW(writePng(path("b.png"), noise(18, 18)), std::runtime_error) << "fails only when closing";
  EXPECT_EQ(fileCount(), 0u);
}

TEST_F(ImageFile, EmptyImageAndBadFileAreErrors) {
  EXPECT_THROW(writePng(path("a.png"), Image{}), std::runtime_error);
  EXPECT_THROW(readPng(path("none.png")), std::runtime_error);
}

TEST_F(ImageFile, WriterThreadWritesAllInOrderAndHandsBackMemory) {
  PngWriterThread writer;
  for (int i = 0; i < 8; ++i) {
    Image image = writer.takeSpare();
    image = noise(20 + i, 10);
    writer.submit(path(std::to_string(i) + ".png"), std::move(image));
  }
  writer.finish();
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(readPng(path(std::to_string(i) + ".png")).width, 20 + i);
  }
  EXPECT_FALSE(writer.takeSpare().rgba.empty());
}

TEST_F(ImageFile, WriterThreadDoesOtherWorkInOrder) {
  PngWriterThread writer;
  std::vector<int> widths;
  for (int i = 1; i <= 8; ++i) {
    writer.submit(noise(i, 2), [&](const Image& image) { widths.push_back(image.width); });
  }
  writer.finish();
  EXPECT_EQ(widths, (std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8}));
  writer.submit(noise(1, 1), [](const Image&) { throw std::runtime_error("no"); });
  EXPECT_THROW(writer.finish(), std::runtime_error);
}

TEST_F(ImageFile, WriterThreadReportsItsErrorOnceAndGoesOn) {
  PngWriterThread writer;
  writer.submit(path("missing/a.png"), noise(4, 4));
  EXPECT_THROW(writer.finish(), std::runtime_error);
  writer.submit(path("b.png"), noise(4, 4));
  EXPECT_NO_THROW(writer.finish());
  EXPECT_EQ(readPng(path("b.png")).width, 4);
}

TEST_F(ImageFile, WriterThreadWritesWhatIsQueuedBeforeItEnds) {
  {
    PngWriterThread writer;
    writer.submit(path("a.png"), noise(200, 200));
    writer.submit(path("b.png"), noise(4, 4));
  }
  EXPECT_EQ(fileCount(), 2u);
}

TEST(ScaledDown, TakesTheMeanInLinearLight) {
  Image image;
  image.resize(4, 2);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 4; ++x) {
      std::fill_n(image.pixel(x, y), 3, static_cast<std::uint8_t>(x == y ? 255 : 0));
    }
  }
  const Image half = scaledDown(image, 2);
  ASSERT_EQ(half.width, 2);
  ASSERT_EQ(half.height, 1);
  const std::vector<std::uint8_t> expected{188, 188, 188, 255, 0, 0, 0, 255};
  EXPECT_EQ(half.rgba, expected) << "half the light of white is 188 in sRGB, not 128";
}

TEST(ScaledDown, FlatStaysFlatWhereSizesDoNotDivide) {
  Image image;
  image.resize(1000, 10);
  std::fill(image.rgba.begin(), image.rgba.end(), std::uint8_t{77});
  const Image small = scaledDown(image, 480);
  EXPECT_EQ(small.height, 4);
  for (std::size_t i = 0; i < small.rgba.size(); ++i) {
    ASSERT_EQ(small.rgba[i], i % 4 == 3 ? 255 : 77) << i;
  }
}

TEST(ScaledDown, EveryLevelComesBackAtItsOwnSize) {
  Image levels;
  levels.resize(256, 1);
  for (int i = 0; i < 256; ++i) {
    std::fill_n(levels.pixel(i, 0), 3, static_cast<std::uint8_t>(i));
    levels.pixel(i, 0)[3] = 255;
  }
  EXPECT_EQ(scaledDown(levels, 256).rgba, levels.rgba);
  EXPECT_EQ(scaledDown(levels, 1).height, 1) << "never empty";
  EXPECT_THROW(scaledDown(Image{}, 1), std::runtime_error);
  EXPECT_THROW(scaledDown(levels, 0), std::runtime_error);
}

TEST(ContactSheet, PlacesTilesAndGaps) {
  std::vector<Image> images(5);
  for (std::size_t i = 0; i < images.size(); ++i) {
    images[i].resize(80, 40);
    std::fill(images[i].rgba.begin(), images[i].rgba.end(), static_cast<std::uint8_t>(40 * i));
  }
  const Image sheet = contactSheet(images, 3, 20);
  EXPECT_EQ(sheet.width, 3 * 20 + 2 * 4);
  EXPECT_EQ(sheet.height, 2 * 10 + 4);
  EXPECT_EQ(sheet.pixel(10, 5)[0], 0);
  EXPECT_EQ(sheet.pixel(24 + 10, 5)[0], 40);
  EXPECT_EQ(sheet.pixel(24 + 10, 14 + 5)[0], 160);
  EXPECT_EQ(sheet.pixel(22, 5)[0], 255) << "the gap";
  EXPECT_EQ(sheet.pixel(60, 18)[0], 255) << "the short row";
  EXPECT_THROW(contactSheet({}, 3), std::runtime_error);
}

// --- sizes -------------------------------------------------------------------------------------------------

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

// SPDX-License-Identifier: Zlib
#include "limber/render/apng_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "apng_reader.h"
#include "import/temporary_folder.h"
#include "limber/render/png_file.h"
#include "pictures.h"
#include "support/file_size_limit.h"

namespace limber::render {
namespace {

using limber::test::FileSizeLimit;
using test::errorOf;

constexpr int kWidth = 31;
constexpr int kHeight = 17;

Image opaqueNoise(std::uint32_t seed, int width = kWidth, int height = kHeight) {
  Image image = test::noise(width, height, seed);
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    image.rgba[i] = 255;
  }
  return image;
}

Image changed(Image image, int x, int y) {
  image.pixel(x, y)[1] ^= 1;
  return image;
}

class ApngFile : public ::testing::Test {
 protected:
  ApngDesc desc() const { return {path, 2, 30}; }
  void write(const std::vector<Image>& images) const {
    ApngWriter writer(desc());
    for (const Image& image : images) {
      writer.add(image);
    }
    writer.finish();
  }
  std::string bytes() const {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::size_t fileCount() const {
    const std::filesystem::directory_iterator files(folder.path());
    return static_cast<std::size_t>(std::distance(files, {}));
  }

  TemporaryFolder folder;
  std::string path = folder.path() + "/a.png";
};

TEST_F(ApngFile, EveryFrameComesBackPixelByPixel) {
  const Image base = opaqueNoise(1);
  const std::vector<Image> images{base,           opaqueNoise(2), changed(opaqueNoise(2), 3, 4),
                                  opaqueNoise(3), opaqueNoise(3), base};
  write(images);
  const Apng apng = readApng(path);
  ASSERT_EQ(apng.frames.size(), images.size());
  EXPECT_EQ(apng.plays, 0u) << "for ever";
  for (std::size_t i = 0; i < images.size(); ++i) {
    EXPECT_EQ(apng.frames[i].shown.rgba, images[i].rgba) << i;
    EXPECT_EQ(apng.frames[i].delayNumerator, 2);
    EXPECT_EQ(apng.frames[i].delayDenominator, 30);
  }
  EXPECT_EQ(fileCount(), 1u) << "the temporary file must be gone";
}

TEST_F(ApngFile, OnlyWhatChangedIsKept) {
  const Image first = opaqueNoise(1);
  const Image second = changed(changed(first, 5, 16), 30, 2);
  write({first, second, second, changed(second, 0, 0)});
  const Apng apng = readApng(path);
  ASSERT_EQ(apng.frames.size(), 4u);
  const auto areaOf = [&](std::size_t i) {
    const ApngFrame& f = apng.frames[i];
    return std::vector<std::uint32_t>{f.x, f.y, f.width, f.height};
  };
  EXPECT_EQ(areaOf(0), (std::vector<std::uint32_t>{0, 0, kWidth, kHeight}));
  EXPECT_EQ(areaOf(1), (std::vector<std::uint32_t>{5, 2, 26, 15}));
  EXPECT_EQ(areaOf(2), (std::vector<std::uint32_t>{0, 0, 1, 1}))
      << "nothing changed, but a frame is not empty";
  EXPECT_EQ(areaOf(3), (std::vector<std::uint32_t>{0, 0, 1, 1}));
  EXPECT_LT(bytes().size(), 2 * 3u * kWidth * kHeight) << "two changed pixels are not a second picture";
}

TEST_F(ApngFile, OtherProgramsSeeTheFirstFrame) {
  write({opaqueNoise(1), opaqueNoise(2)});
  EXPECT_EQ(readPng(path).rgba, opaqueNoise(1).rgba);
}

TEST_F(ApngFile, AlphaIsIgnored) {
  Image transparent = opaqueNoise(1);
  transparent.pixel(4, 5)[3] = 0;
  Image secondTransparent = opaqueNoise(2);
  secondTransparent.pixel(4, 5)[3] = 7;
  write({transparent, secondTransparent});
  const Apng apng = readApng(path);
  EXPECT_EQ(apng.frames[0].shown.rgba, opaqueNoise(1).rgba);
  EXPECT_EQ(apng.frames[1].shown.rgba, opaqueNoise(2).rgba);
}

TEST_F(ApngFile, LargePicturesComeBack) {
  const std::vector<Image> images{opaqueNoise(1, 400, 300), opaqueNoise(2, 400, 300)};
  write(images);
  const Apng apng = readApng(path);
  ASSERT_EQ(apng.frames.size(), 2u);
  EXPECT_EQ(apng.frames[1].shown.rgba, images[1].rgba);
}

TEST_F(ApngFile, EqualFramesMakeEqualBytes) {
  write({opaqueNoise(1), opaqueNoise(2)});
  const std::string once = bytes();
  write({opaqueNoise(1), opaqueNoise(2)});
  EXPECT_EQ(bytes(), once);
}

TEST_F(ApngFile, IsNotThereUnlessFinished) {
  {
    ApngWriter writer(desc());
    writer.add(opaqueNoise(1));
  }
  EXPECT_EQ(fileCount(), 0u);
}

TEST_F(ApngFile, WhatCannotBeIsAnErrorWithTheName) {
  const std::string missing = folder.path() + "/no/such/a.png";
  EXPECT_EQ(errorOf([&] { ApngWriter writer({missing}); }),
            "cannot write " + missing + ": No such file or directory");
  EXPECT_EQ(errorOf([&] {
              write({opaqueNoise(1), opaqueNoise(1, kWidth, kHeight + 1)});
            }),
            "cannot write " + path + ": its pictures differ in size");
  EXPECT_EQ(errorOf([&] { write({}); }), "cannot write " + path + ": it has no picture");
  EXPECT_NE(errorOf([&] { write({Image{}}); }).find("cannot write " + path + ": "), std::string::npos);
  EXPECT_EQ(fileCount(), 0u);
}

TEST_F(ApngFile, FullDiskIsAnErrorAndLeavesNoHalfFile) {
  const std::string expected = "cannot write " + path + ": File too large";
  {
    const FileSizeLimit limit(20000);
    EXPECT_EQ(errorOf([&] {
                ApngWriter writer(desc());
                for (std::uint32_t i = 0; i < 1000; ++i) {
                  writer.add(opaqueNoise(i));
                }
                ADD_FAILURE() << "adding must fail already";
              }),
              expected);
    EXPECT_EQ(fileCount(), 0u);
  }
  const FileSizeLimit limit(1000);  // smaller than the buffer: the error occurs only at the end
  EXPECT_EQ(errorOf([&] { write({opaqueNoise(1)}); }), expected);
  EXPECT_EQ(fileCount(), 0u);
}

}  // namespace
}  // namespace limber::render

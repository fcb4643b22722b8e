// SPDX-License-Identifier: Zlib
#include "limber/render/video_pipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "import/temporary_folder.h"
#include "pictures.h"

namespace limber::render {
namespace {

namespace fs = std::filesystem;
using test::errorOf;

// Puts a new folder first on PATH, in which a test may create its own ffmpeg.
class VideoPipeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* path = std::getenv("PATH");
    oldPath = path == nullptr ? "" : path;
  }
  void TearDown() override { setenv("PATH", oldPath.c_str(), 1); }
  void installFfmpeg(const std::string& script) {
    const fs::path program = folder / "ffmpeg";
    std::ofstream(program) << "#!/bin/sh\n" << script << "\n";
    fs::permissions(program, fs::perms::owner_all);
    setenv("PATH", (folder.string() + ":" + oldPath).c_str(), 1);
  }
  VideoDesc desc() const {
    VideoDesc video;
    video.path = (folder / "out file; with $odd.mp4").string();
    video.width = 640;
    video.height = 480;
    return video;
  }
  static Image frame(std::uint8_t value) {
    Image image;
    image.resize(640, 480);
    std::fill(image.rgba.begin(), image.rgba.end(), value);
    return image;
  }

  TemporaryFolder made;
  fs::path folder = made.path();
  std::string oldPath;
};

TEST_F(VideoPipeTest, MissingFfmpegIsAClearError) {
  setenv("PATH", folder.c_str(), 1);
  EXPECT_FALSE(VideoPipe::available());
  const std::string text = errorOf([&] { VideoPipe pipe(desc()); });
  EXPECT_NE(text.find("no ffmpeg on PATH"), std::string::npos) << text;
}

TEST_F(VideoPipeTest, FramesArriveWholeAndInOrder) {
  installFfmpeg("for last; do :; done\nexec cat > \"${last#file:}\"");
  ASSERT_TRUE(VideoPipe::available());
  VideoPipe pipe(desc());
  for (std::uint8_t i = 0; i < 5; ++i) {
    pipe.write(frame(i));
  }
  pipe.finish();
  pipe.finish();
  std::ifstream file(desc().path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const std::size_t frameBytes = 4u * 640u * 480u;
  ASSERT_EQ(bytes.size(), 5 * frameBytes);
  EXPECT_EQ(bytes[3 * frameBytes], 3);
  EXPECT_EQ(bytes[4 * frameBytes - 1], 3);
}

TEST_F(VideoPipeTest, DyingFfmpegIsReportedWithItsWords) {
  installFfmpeg("echo 'Unknown encoder' >&2\nexit 1");
  const std::string text = errorOf([&] {
    VideoPipe pipe(desc());
    for (int i = 0; i < 10; ++i) {
      pipe.write(frame(1));
    }
  });
  EXPECT_NE(text.find("ffmpeg stopped"), std::string::npos) << text;
  EXPECT_NE(text.find("Unknown encoder"), std::string::npos) << text;
}

TEST_F(VideoPipeTest, FailureAtTheEndIsReportedByFinish) {
  installFfmpeg(
      "for last; do :; done\nhead -c 9 > \"${last#file:}\"\ncat > /dev/null\necho 'disk full' >&2\nexit 1");
  std::ofstream(desc().path) << "an older video";
  const std::string text = errorOf([&] {
    VideoPipe pipe(desc());
    pipe.write(frame(1));
    pipe.finish();
  });
  EXPECT_NE(text.find("failed to write"), std::string::npos) << text;
  EXPECT_NE(text.find("disk full"), std::string::npos) << text;
  EXPECT_EQ(fs::file_size(desc().path), 14u) << "the older one stays";
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2) << "and ffmpeg; half a video goes";
}

TEST_F(VideoPipeTest, WrongFrameSizeIsRefused) {
  installFfmpeg("cat > /dev/null");
  VideoPipe pipe(desc());
  Image small;
  small.resize(2, 2);
  EXPECT_THROW(pipe.write(small), std::runtime_error);
}

}  // namespace
}  // namespace limber::render

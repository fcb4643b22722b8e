// SPDX-License-Identifier: Zlib
#include "picture_output.h"

#include "import/temporary_folder.h"
#include "output_files.h"
#include "render/apng_reader.h"
#include "run_report.h"
#include "support/file_size_limit.h"

#include <limber/render/png_file.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>

namespace limber::demo {
namespace {

namespace fs = std::filesystem;
using test::FileSizeLimit;

constexpr int kWidth = 64, kHeight = 36;  // a frame has about 9 kB as noise, about 0.1 kB in one colour

render::Image uniform(std::uint8_t level, int width = kWidth, int height = kHeight) {
  render::Image image;
  image.resize(width, height);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = i % 4 == 3 ? 255 : level;
  return image;
}

render::Image noise(std::uint32_t seed, int width = kWidth, int height = kHeight) {
  render::Image image = uniform(0, width, height);
  std::uint32_t state = seed;
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    state = state * 1664525u + 1013904223u;
    if (i % 4 != 3) image.rgba[i] = static_cast<std::uint8_t>(state >> 24);
  }
  return image;
}

class Pictures : public ::testing::Test {
 protected:
  Pictures() {
    options.outFolder = folder.path();
    options.width = kWidth;
    options.height = kHeight;
    options.video = false;
  }
  /// Returns the error, or an empty string.
  std::string write(const std::vector<render::Image>& frames) {
    try {
      PictureOutput output(options, static_cast<std::int64_t>(frames.size()));
      for (const render::Image& frame : frames) output.add(frame);
      output.finish();
      videoProblem = output.videoProblem();
      description = output.describe();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return {};
  }
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(options.outFolder)) names.insert(entry.path().filename());
    return names;
  }
  std::string path(const std::string& name) const { return options.outFolder + "/" + name; }
  std::string bytes(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void expectFrames(const std::vector<render::Image>& frames, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i) {
      const std::string name = frameName(static_cast<std::int64_t>(i));
      EXPECT_EQ(render::readPng(path(name)).rgba, frames[i].rgba) << name;
    }
  }

  TemporaryFolder folder;
  DemoOptions options;
  std::string videoProblem, description;
};

std::vector<render::Image> noiseImages(std::uint32_t count) {
  std::vector<render::Image> images;
  for (std::uint32_t i = 0; i < count; ++i) images.push_back(noise(i));
  return images;
}

TEST_F(Pictures, previewShowsEverySecondOfThirtyFramesASecond) {
  std::vector<render::Image> frames;
  for (std::uint32_t i = 0; i < 7; ++i) frames.push_back(noise(i, 640, 360));
  EXPECT_EQ(write(frames), "");
  const render::Apng preview = render::readApng(path(kPreviewName));
  ASSERT_EQ(preview.frames.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(preview.frames[i].shown.rgba, render::scaledDown(frames[2 * i], 480).rgba) << i;
    EXPECT_EQ(preview.frames[i].delayNumerator, 2);
    EXPECT_EQ(preview.frames[i].delayDenominator, 30);
  }
  EXPECT_NE(description.find(kPreviewName), std::string::npos);
}

TEST_F(Pictures, smallOnesAreNotScaledUp) {
  options.framesPerSecond = 10;
  const std::vector<render::Image> frames = noiseImages(3);
  EXPECT_EQ(write(frames), "");
  const render::Apng preview = render::readApng(path(kPreviewName));
  ASSERT_EQ(preview.frames.size(), 3u);
  EXPECT_EQ(preview.frames[2].shown.rgba, frames[2].rgba);
  EXPECT_EQ(preview.frames[2].delayNumerator, 1);
  EXPECT_EQ(preview.frames[2].delayDenominator, 10);
}

TEST_F(Pictures, previewCanBeLeftOut) {
  options.preview = false;
  EXPECT_EQ(write(noiseImages(2)), "");
  EXPECT_EQ(files(), (std::set<std::string>{"frame-0000.png", "frame-0001.png", kContactSheetName}));
  EXPECT_EQ(description.find(kPreviewName), std::string::npos);
}

TEST(Preview, showsAtMostFifteenPicturesASecond) {
  for (int rate = 1; rate <= 240; ++rate) {
    const int stride = previewStride(rate);
    EXPECT_LE(rate, 15 * stride);
    EXPECT_GT(rate, 15 * (stride - 1)) << "and no fewer than need be";
  }
}

TEST_F(Pictures, areTheSameBytesEachTime) {
  EXPECT_EQ(write(noiseImages(20)), "");
  std::vector<std::string> before;
  for (const std::string& name : files()) before.push_back(bytes(name));
  EXPECT_EQ(before.size(), 22u);
  EXPECT_EQ(prepareFolder(options.outFolder), "");
  EXPECT_TRUE(files().empty()) << "all are known as ours";
  EXPECT_EQ(write(noiseImages(20)), "");
  std::size_t i = 0;
  for (const std::string& name : files()) EXPECT_TRUE(bytes(name) == before[i++]) << name;
}

TEST_F(Pictures, framesWrittenBeforeTheDiskIsFullStay) {
  const std::vector<render::Image> frames{uniform(1), uniform(2), uniform(3), noise(4),
                                          noise(5),   noise(6),   noise(7)};
  const FileSizeLimit limit(5000);
  EXPECT_EQ(write(frames), "cannot write " + path("frame-0003.png") + ": File too large");
  EXPECT_EQ(files(), (std::set<std::string>{"frame-0000.png", "frame-0001.png", "frame-0002.png"}));
  expectFrames(frames, 3);
}

TEST_F(Pictures, framesStayWhenThePreviewFindsTheDiskFull) {
  const std::vector<render::Image> frames = noiseImages(20);
  const FileSizeLimit limit(30000);
  EXPECT_EQ(write(frames), "cannot write " + path(kPreviewName) + ": File too large");
  EXPECT_FALSE(fs::exists(path(kPreviewName)));
  EXPECT_GE(files().size(), 7u);
  expectFrames(frames, files().size());
}

TEST_F(Pictures, framesStayWhenTheContactSheetFindsTheDiskFull) {
  const std::vector<render::Image> frames = noiseImages(12);
  options.preview = false;
  const FileSizeLimit limit(30000);
  EXPECT_EQ(write(frames), "cannot write " + path(kContactSheetName) + ": File too large");
  EXPECT_EQ(files().size(), 12u);
  expectFrames(frames, 12);
}

/// The folder no longer exists, as after removal of a disk.
TEST_F(Pictures, lostFolderIsAnErrorWithTheName) {
  options.outFolder = folder.path() + "/lost";
  const std::string first = options.outFolder + "/preview.png";
  EXPECT_EQ(write(noiseImages(2)), "cannot write " + first + ": No such file or directory");
  options.preview = false;
  EXPECT_EQ(write(noiseImages(2)), "cannot write " + path("frame-0000.png") + ": No such file or directory");
}

/// Runs with an ffmpeg that the test provides.
class Video : public Pictures {
 protected:
  Video() {
    options.video = true;
    setenv("PATH", (programs.path() + ":" + oldPath).c_str(), 1);
  }
  ~Video() override { setenv("PATH", oldPath.c_str(), 1); }
  void installFfmpeg(const std::string& text) const {
    fs::permissions(programs.write("ffmpeg", text), fs::perms::owner_all);
  }
  void expectAllButTheVideo(const std::vector<render::Image>& frames) const {
    EXPECT_EQ(files().size(), frames.size() + 2);
    EXPECT_FALSE(fs::exists(path(kVideoName)));
    expectFrames(frames, frames.size());
    EXPECT_EQ(render::readApng(path(kPreviewName)).frames.size(), (frames.size() + 1) / 2);
    EXPECT_NO_THROW(render::readPng(path(kContactSheetName)));
    EXPECT_EQ(description.find(kVideoName), std::string::npos);
  }

  TemporaryFolder programs;
  std::string oldPath = std::getenv("PATH");
};

TEST_F(Video, failureLosesNothingElse) {
  installFfmpeg(
      "#!/bin/sh\nfor v; do :; done\nhead -c 9 >\"${v#file:}\"\necho 'No space left on device' >&2\nexit "
      "1\n");
  const std::vector<render::Image> frames = noiseImages(9);
  EXPECT_EQ(write(frames), "");
  EXPECT_NE(videoProblem.find(path(kVideoName)), std::string::npos) << videoProblem;
  EXPECT_NE(videoProblem.find("No space left on device"), std::string::npos) << videoProblem;
  expectAllButTheVideo(frames);
}

TEST_F(Video, programThatCannotBeStartedLosesNothingElse) {
  installFfmpeg("no program");
  const std::vector<render::Image> frames = noiseImages(3);
  EXPECT_EQ(write(frames), "");
  EXPECT_NE(videoProblem.find("Exec format error"), std::string::npos) << videoProblem;
  expectAllButTheVideo(frames);
}

TEST_F(Video, isThereWhenAllIsWell) {
  installFfmpeg("#!/bin/sh\nfor v; do :; done\nexec cat >\"${v#file:}\"\n");
  EXPECT_EQ(write(noiseImages(3)), "");
  EXPECT_EQ(videoProblem, "");
  EXPECT_EQ(bytes(kVideoName).size(), 3u * 4u * kWidth * kHeight);
  EXPECT_NE(description.find(kVideoName), std::string::npos);
}

TEST_F(Pictures, figuresAreWrittenWholeOrNotAtAll) {
  options.statsFile = folder.write("stats.json", "old");
  {
    const FileSizeLimit limit(100);
    EXPECT_EQ(writeJson(options, {}), "cannot write " + options.statsFile + ": File too large");
  }
  EXPECT_EQ(files(), (std::set<std::string>{"stats.json"}));
  EXPECT_EQ(bytes("stats.json"), "old");
  EXPECT_EQ(writeJson(options, {}), "");
  EXPECT_EQ(bytes("stats.json").front(), '{');
  options.statsFile = "/dev/full";
  EXPECT_EQ(writeJson(options, {}), "cannot write /dev/full: No space left on device");
}

}  // namespace
}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#include "demo_options.h"
#include "import/temporary_folder.h"
#include "number_checks.h"
#include "output_files.h"
#include "picture_output.h"
#include "progress.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace limber::demo {
namespace {

TEST(ContactSheet, hasTheFirstTheLastAndTwelveInAll) {
  for (const std::int64_t count : {13, 61, 181, 241, 1000}) {
    int tiles = 0;
    for (std::int64_t i = 0; i < count; ++i) tiles += isTile(i, count, 12);
    EXPECT_TRUE(isTile(0, count, 12));
    EXPECT_TRUE(isTile(count - 1, count, 12));
    EXPECT_LE(tiles, 12);
    EXPECT_GE(tiles, count >= 61 ? 12 : 9);
  }
}

TEST(ContactSheet, shortRunsAreShownWhole) {
  for (std::int64_t i = 0; i < 7; ++i) EXPECT_TRUE(isTile(i, 7, 12));
}

TEST(Progress, barFillsUp) {
  EXPECT_EQ(barText(0.0, 4), "[----]");
  EXPECT_EQ(barText(0.5, 4), "[##--]");
  EXPECT_EQ(barText(1.0, 4), "[####]");
}

TEST(Progress, durationsAreReadable) {
  EXPECT_EQ(durationText(0.2), "1 s");
  EXPECT_EQ(durationText(59.0), "59 s");
  EXPECT_EQ(durationText(65.0), "1 min 05 s");
}

std::string progressText(bool terminal, int steps, int done) {
  std::FILE* file = std::tmpfile();
  {
    Progress progress(file, terminal);
    for (int i = 0; i <= done; ++i) progress.show(i, steps);
  }
  std::rewind(file);
  std::string text(8192, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  return text;
}

TEST(Progress, plainLinesHaveNoControlCharacters) {
  const std::string text = progressText(false, 1000, 1000);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 10);
  EXPECT_EQ(text.find('\r'), std::string::npos);
}

TEST(Progress, barStaysOnOneLine) {
  const std::string text = progressText(true, 1000, 1000);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_NE(text.find(" left"), std::string::npos);
  EXPECT_EQ(text.back(), '\n');
}

TEST(Progress, barThatIsCutShortEndsItsLine) {
  const std::string text = progressText(true, 1000, 300);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_EQ(text.back(), '\n');
  EXPECT_EQ(progressText(true, 1000, -1), "") << "nothing to end";
}

TEST(PictureSize, isReadOrRefused) {
  int width = 0, height = 0;
  EXPECT_TRUE(parseSize("960x540", width, height));
  EXPECT_EQ(width, 960);
  EXPECT_EQ(height, 540);
  for (const char* bad :
       {"", "x", "960", "960x", "x540", "-1x5", "9.5x5", "960x540x", "9999999999x1", " 1x1"}) {
    EXPECT_FALSE(parseSize(bad, width, height)) << bad;
  }
}

TEST(PictureChoices, camerasAreReadOrRefused) {
  CameraChoice choice;
  EXPECT_EQ(parseCamera("orbit", choice), "");
  EXPECT_EQ(choice.path, CameraPath::Orbit);
  EXPECT_EQ(parseCamera("1,2.5,-3,0,1e-1,0", choice), "");
  EXPECT_EQ(choice.path, CameraPath::Fixed);
  EXPECT_EQ(choice.eye, Eigen::Vector3d(1, 2.5, -3));
  EXPECT_EQ(choice.target, Eigen::Vector3d(0, 0.1, 0));
  EXPECT_EQ(parseCamera("auto", choice), "");
  EXPECT_EQ(choice.path, CameraPath::Auto);
  for (const char* bad : {"", "round", "1,2,3", "1,2,3,4,5", "1,2,3,4,5,6,7", "1,2,3,4,5,x", "1,2,nan,4,5,6",
                          "1,2,3,1,2,3", "1,2,3,4,5,"})
    EXPECT_NE(parseCamera(bad, choice), "") << bad;
}

TEST(PictureChoices, overlaysAreReadOrRefused) {
  OverlayChoice choice;
  EXPECT_EQ(parseOverlay("contacts,velocities,islands", choice), "");
  EXPECT_TRUE(choice.contacts && choice.velocities && !choice.boxes && !choice.constraints);
  EXPECT_EQ(parseOverlay("none", choice), "");
  EXPECT_FALSE(choice.contacts || choice.velocities);
  EXPECT_EQ(parseOverlay("contacts,speeds", choice),
            "\"speeds\" is not one of contacts, velocities, boxes, constraints, islands");
  EXPECT_NE(parseOverlay("", choice), "");
}

TEST(PictureChoices, contextsAreReadOrRefused) {
  render::ContextDesc desc;
  EXPECT_EQ(parseContext("osmesa", desc), "");
  EXPECT_EQ(desc.backend, render::Backend::OSMesa);
  EXPECT_EQ(parseContext("surfaceless", desc), "");
  EXPECT_EQ(desc.backend, render::Backend::EglSurfaceless);
  EXPECT_EQ(parseContext("egl:2", desc), "");
  EXPECT_EQ(desc.backend, render::Backend::Egl);
  EXPECT_EQ(desc.eglDevice, 2);
  EXPECT_EQ(parseContext("auto", desc), "");
  EXPECT_EQ(desc.backend, render::Backend::Auto);
  for (const char* bad : {"", "gl", "egl:", "egl:x", "egl:1234"})
    EXPECT_NE(parseContext(bad, desc), "") << bad;
}

TEST(Folders, onlyOurOwnOldPicturesGo) {
  namespace fs = std::filesystem;
  const TemporaryFolder made;
  const fs::path folder = made.path();
  for (const char* name : {"frame-0001.png", "frame-12345.png", "frame-0001.txt", "frame-holiday.png",
                           "mine.png", kPreviewName}) {
    made.write(name, "x");
  }
  EXPECT_EQ(prepareFolder(folder.string()), "");
  EXPECT_FALSE(fs::exists(folder / "frame-0001.png"));
  EXPECT_FALSE(fs::exists(folder / "frame-12345.png"));
  EXPECT_FALSE(fs::exists(folder / kPreviewName));
  EXPECT_TRUE(fs::exists(folder / "frame-0001.txt"));
  EXPECT_TRUE(fs::exists(folder / "frame-holiday.png"));
  EXPECT_TRUE(fs::exists(folder / "mine.png"));
  EXPECT_FALSE(fs::exists(folder / kContactSheetName));
  fs::create_directories(folder / kPreviewName);
  EXPECT_NE(prepareFolder(folder.string()).find("preview.png: it is a folder"), std::string::npos);
}

TEST(Folders, whatCannotBeWrittenIsRefusedWithTheReason) {
  EXPECT_EQ(prepareFolder("/dev/null/x"), "cannot use the folder /dev/null/x: Not a directory");
}

}  // namespace
}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#include "limber/render/stream_buffer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "limber/render/gl_context.h"
#include "limber/render/gl_debug_messages.h"

namespace limber::render {
namespace {

class StreamBufferTest : public ::testing::Test {
 protected:
  void TearDown() override {
    EXPECT_NO_THROW(checkGlErrors(gl, "end of the test"));
    EXPECT_EQ(messages.complaints(), 0u) << messages.lastComplaint();
  }
  std::vector<float> read(const StreamBuffer& buffer, const StreamFrame& frame) const {
    std::vector<float> values(frame.floatCount);
    gl.GetNamedBufferSubData(buffer.name(), frame.byteOffset,
                             static_cast<GLsizeiptr>(values.size() * sizeof(float)), values.data());
    return values;
  }

  std::unique_ptr<GlContext> context = createContext();
  Gl gl = loadGl(*context);
  DebugMessages messages{gl};
};

TEST_F(StreamBufferTest, RegionsAreAlignedAndApart) {
  StreamBufferDesc desc;
  desc.floatsPerFrame = 100;
  StreamBuffer buffer(gl, desc);
  std::vector<GLintptr> offsets;
  for (int i = 0; i < 4; ++i) {
    const StreamFrame frame = buffer.beginFrame();
    EXPECT_EQ(frame.floatCount, 100u);
    EXPECT_EQ(frame.byteOffset % 256, 0);
    offsets.push_back(frame.byteOffset);
    buffer.endFrame();
  }
  EXPECT_GE(offsets[1] - offsets[0], 400);
  EXPECT_GE(offsets[2] - offsets[1], 400);
  EXPECT_EQ(offsets[3], offsets[0]);
  EXPECT_EQ(buffer.counters().frames, 4u);
  EXPECT_EQ(buffer.counters().waits, 1u);
  EXPECT_EQ(buffer.bytes(), 3u * 512u);
}

TEST_F(StreamBufferTest, WhatIsWrittenReachesTheBuffer) {
  StreamBufferDesc desc;
  desc.floatsPerFrame = 10;
  StreamBuffer buffer(gl, desc);
  const StreamFrame frame = buffer.beginFrame();
  for (std::size_t i = 0; i < frame.floatCount; ++i) {
    frame.data[i] = static_cast<float>(i);
  }
  EXPECT_EQ(read(buffer, frame)[7], 7.0f);
  buffer.endFrame();
  buffer.drain();
}

TEST_F(StreamBufferTest, PoisonFillsEachRegionBeforeItIsHandedOut) {
  StreamBufferDesc desc;
  desc.floatsPerFrame = 10;
  desc.poison = true;
  StreamBuffer buffer(gl, desc);
  for (int i = 0; i < 5; ++i) {
    const StreamFrame frame = buffer.beginFrame();
    for (const float value : read(buffer, frame)) {
      EXPECT_TRUE(std::isnan(value));
    }
    frame.data[0] = 1.0f;
    buffer.endFrame();
  }
}

TEST_F(StreamBufferTest, TwoOpenFramesAreRefused) {
  StreamBufferDesc desc;
  desc.floatsPerFrame = 10;
  StreamBuffer buffer(gl, desc);
  buffer.beginFrame();
  EXPECT_THROW(buffer.beginFrame(), std::logic_error);
  buffer.cancelFrame();
  EXPECT_THROW(buffer.endFrame(), std::logic_error);
}

}  // namespace
}  // namespace limber::render

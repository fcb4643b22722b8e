// SPDX-License-Identifier: Zlib
#include "render/baselines/baseline.h"

#include "staged_baseline.h"

#include <cstddef>
#include <stdexcept>
#include <vector>

namespace limber::bench {
namespace {

using namespace render;

class NaivePoints final : public StagedBaseline {
 public:
  explicit NaivePoints(Renderer& renderer) : StagedBaseline(renderer) {
    if (renderer.computesOnCpu())
      throw std::runtime_error("naive points need a renderer with ComputeOn::Gpu");
  }

  void beginFrame() override;
  std::size_t bytes() const override;

 private:
  GLuint bufferFor(std::size_t instance, std::size_t bytes);
  DrawItem upload(const InstanceGroup& group, std::uint32_t indexInGroup);
  void uploadAll() override;
  void drawPicture(const DrawOptions& options, bool shadows) override {
    parts_.drawPicture(options, shadows);
  }

  std::vector<GlBuffer> buffers_;  // By instance.
};

void NaivePoints::beginFrame() {
  layOut();
  parts_.reserveComputed();
  openFrame();
}

GLuint NaivePoints::bufferFor(std::size_t instance, std::size_t bytes) {
  if (instance >= buffers_.size()) buffers_.resize(instance + 1);
  if (buffers_[instance].bytes() != bytes)
    buffers_[instance] = makeBuffer(parts_.gl, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT);
  return buffers_[instance].name();
}

DrawItem NaivePoints::upload(const InstanceGroup& group, std::uint32_t indexInGroup) {
  const GpuShape& shape = parts_.shapes[group.shape];
  const std::uint32_t instance = group.firstInstance + indexInGroup;
  const std::uint32_t skinnedBefore = indexInGroup * shape.skinnedPointCount;
  const auto bytes = static_cast<GLsizeiptr>(3 * sizeof(float) * shape.pointCount);
  const GLuint buffer = bufferFor(instance, static_cast<std::size_t>(bytes));
  parts_.gl.NamedBufferSubData(buffer, 0, bytes,
                               staged(group.firstPoint + std::size_t{indexInGroup} * shape.pointCount));
  const PointRange points{buffer, 0, bytes, 0};
  return {&shape,
          instance,
          1,
          points,
          shape.skinned() ? parts_.placeRange().from(group.firstPlace + skinnedBefore) : points,
          parts_.normalRange().from(group.firstNormal + skinnedBefore),
          group.textured};
}

void NaivePoints::uploadAll() {
  parts_.items.clear();
  for (const InstanceGroup& group : parts_.layout.groups) {
    for (std::uint32_t i = 0; i < group.instanceCount; ++i) parts_.items.push_back(upload(group, i));
  }
  parts_.stats.bytesStreamed = 3 * sizeof(float) * parts_.layout.pointCount;
}

std::size_t NaivePoints::bytes() const {
  std::size_t sum = 0;
  for (const GlBuffer& buffer : buffers_) sum += buffer.bytes();
  return sum;
}

}  // namespace

std::unique_ptr<Baseline> makeNaivePoints(Renderer& renderer) {
  return std::make_unique<NaivePoints>(renderer);
}

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "limber/render/renderer.h"

namespace limber::render {

/// The data of an instance that the shaders read.
struct InstanceRecord {
  float red = 0.0f, green = 0.0f, blue = 0.0f;  ///< Linear.
  float layer = -1.0f;                          ///< Of the texture array; below 0: no texture.
  Material material;
};

/// The instances of one shape in one frame; their data is contiguous in all buffers.
struct InstanceGroup {
  std::uint32_t shape = 0;
  std::uint32_t firstInstance = 0;
  std::uint32_t instanceCount = 0;
  std::uint32_t firstPoint = 0;
  std::uint32_t firstPlace = 0;  ///< For skinned shapes.
  std::uint32_t firstNormal = 0;
  bool textured = false;  ///< True if any instance has a texture.
};

/// The sizes of a shape that the layout needs.
struct ShapeExtent {
  std::uint32_t pointCount = 0;
  std::uint32_t skinnedPointCount = 0;  ///< Equals pointCount without a skin.
  bool skinned = false;
  std::uint32_t normalCount = 0;  ///< 0 if it needs none.
};

/// The indices of all instances of one frame. It is independent of the table, so that instances can be added
/// and removed while a frame is open.
struct FrameLayout {
  struct Slice {
    std::uint32_t generation = 0;
    std::uint32_t firstPoint = UINT32_MAX;
    std::uint32_t firstPlace = 0;
    std::uint32_t firstNormal = 0;
  };

  std::vector<InstanceGroup> groups;    ///< One per shape that has instances.
  std::vector<InstanceRecord> records;  ///< One per instance.
  std::vector<Slice> slices;            ///< By InstanceId::index.
  std::size_t pointCount = 0;           ///< Streamed.
  std::size_t skinnedPointCount = 0;    ///< Of skinned instances.
  std::size_t normalCount = 0;

  /// Returns null if the instance is not part of the frame.
  const Slice* find(InstanceId id) const;
};

/// The existing instances. Ids of removed instances are rejected, although their slots are reused.
class InstanceTable {
 public:
  InstanceId add(ShapeId shape, const InstanceLook& look);
  void setLook(InstanceId id, const InstanceLook& look);
  void remove(InstanceId id);
  std::size_t size() const { return slots_.size() - free_.size(); }
  /// Returns true if an existing instance has this shape.
  bool uses(std::uint32_t shape) const;
  /// Returns the shape of an existing instance. All functions with an id throw std::runtime_error for other
  /// ids.
  std::uint32_t shapeOf(InstanceId id) const;

  /// Returns true if the result of layOut() would differ from the last one.
  bool changed() const { return changed_; }
  /// Computes the layout. Throws std::runtime_error if there are too many points; `layout` is then invalid.
  void layOut(const std::vector<ShapeExtent>& shapes, FrameLayout& layout);

 private:
  struct Slot {
    std::uint32_t generation = 0;
    std::uint32_t shape = UINT32_MAX;  ///< UINT32_MAX while free.
    InstanceLook look;
  };

  Slot& living(InstanceId id);
  InstanceGroup layOutShape(std::uint32_t shape, const ShapeExtent& extent, FrameLayout& layout) const;

  std::vector<Slot> slots_;
  std::vector<std::uint32_t> free_;
  bool changed_ = true;
};

}  // namespace limber::render

// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "limber/render/renderer.h"

namespace limber::render {

/// What the shaders read about an instance.
struct InstanceRecord {
  float red = 0.0f, green = 0.0f, blue = 0.0f;  ///< Linear.
  float layer = -1.0f;                          ///< Of the texture array; below 0: no texture.
};

/// The instances of one shape in one frame; they lie one after the other everywhere.
struct InstanceGroup {
  std::uint32_t shape = 0;
  std::uint32_t firstInstance = 0;
  std::uint32_t instanceCount = 0;
  std::uint32_t firstPoint = 0;
  std::uint32_t firstPlace = 0;  ///< Of skinned ones.
  std::uint32_t firstNormal = 0;
  bool textured = false;  ///< Any of them.
};

/// Per shape, what the layout has to know.
struct ShapeExtent {
  std::uint32_t pointCount = 0;
  std::uint32_t placeCount = 0;  ///< Equals pointCount without a skin.
  bool skinned = false;
  bool needsNormals = false;
};

/// Where every instance of one frame lies. Made from the table, then independent of it, so that
/// instances may come and go while a frame is open.
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
  std::size_t placeCount = 0;           ///< Of skinned instances.
  std::size_t normalCount = 0;

  /// Null if the instance is not part of the frame.
  const Slice* find(InstanceId id) const;
};

/// The living instances. Ids of removed ones are refused for ever, though their slots are reused.
class InstanceTable {
 public:
  InstanceId add(ShapeId shape, const InstanceLook& look);
  void setLook(InstanceId id, const InstanceLook& look);
  void remove(InstanceId id);
  std::size_t size() const { return slots_.size() - free_.size(); }
  /// Whether a living instance has this shape.
  bool uses(std::uint32_t shape) const;
  /// The shape of a living instance. All functions taking an id throw std::runtime_error for
  /// others.
  std::uint32_t shapeOf(InstanceId id) const;

  /// True if layOut() would give something else than the last time.
  bool changed() const { return changed_; }
  /// Throws std::runtime_error, leaving `layout` unusable, if there are too many points to count.
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

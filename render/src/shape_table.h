// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gpu_shape.h"
#include "instance_table.h"

namespace limber::render {

/// The living shapes. As with instances, ids of removed ones are refused though their slots are reused.
class ShapeTable {
 public:
  ShapeId add(GpuShape shape);
  /// The id must be good and the shape without instances.
  void remove(ShapeId id);
  /// Throws std::runtime_error naming `caller` unless the id is that of a living shape.
  void require(ShapeId id, const char* caller) const;

  const GpuShape& operator[](std::uint32_t index) const { return shapes_[index]; }
  /// Changes when another shape takes the index.
  std::uint32_t generation(std::uint32_t index) const { return generations_[index]; }
  /// By index; without points where there is no shape.
  const std::vector<ShapeExtent>& extents() const { return extents_; }
  std::size_t bytes() const;

 private:
  std::vector<GpuShape> shapes_;
  std::vector<ShapeExtent> extents_;
  std::vector<std::uint32_t> generations_;
  std::vector<std::uint32_t> free_;
};

}  // namespace limber::render

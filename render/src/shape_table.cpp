// SPDX-License-Identifier: Zlib
#include "shape_table.h"

#include <stdexcept>
#include <string>
#include <utility>

namespace limber::render {

ShapeId ShapeTable::add(GpuShape shape) {
  if (free_.empty()) {
    free_.push_back(static_cast<std::uint32_t>(shapes_.size()));
    shapes_.emplace_back();
    extents_.emplace_back();
    generations_.push_back(0);
  }
  const std::uint32_t index = free_.back();
  free_.pop_back();
  extents_[index] = {shape.pointCount, shape.placeCount, shape.skinned(), shape.needsNormals()};
  shapes_[index] = std::move(shape);
  return {index, generations_[index]};
}

void ShapeTable::remove(ShapeId id) {
  shapes_[id.index] = {};
  extents_[id.index] = {};
  ++generations_[id.index];
  free_.push_back(id.index);
}

void ShapeTable::require(ShapeId id, const char* caller) const {
  if (id.index >= shapes_.size() || generations_[id.index] != id.generation ||
      shapes_[id.index].pointCount == 0) {
    throw std::runtime_error(std::string(caller) + ": there is no shape with this id");
  }
}

std::size_t ShapeTable::bytes() const {
  std::size_t sum = 0;
  for (const GpuShape& shape : shapes_) {
    sum += shape.bytes();
  }
  return sum;
}

}  // namespace limber::render

// SPDX-License-Identifier: Zlib
#include "instance_table.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "pixels.h"

namespace limber::render {
namespace {

// The indices in the shaders are limited to 2^32 floats.
constexpr std::size_t kMaxPoints = UINT32_MAX / 3;

void requireCountable(const FrameLayout& layout) {
  if (std::max({layout.pointCount, layout.skinnedPointCount, layout.normalCount}) > kMaxPoints) {
    throw std::runtime_error("too many points for one frame: more than " + std::to_string(kMaxPoints));
  }
}

InstanceRecord recordOf(const InstanceLook& look) {
  InstanceRecord record{srgbToLinear(look.colour.x), srgbToLinear(look.colour.y), srgbToLinear(look.colour.z),
                        -1.0f, look.material};
  if (look.texture.index != UINT32_MAX) {
    record.layer = static_cast<float>(look.texture.index);
  }
  return record;
}

}  // namespace

const FrameLayout::Slice* FrameLayout::find(InstanceId id) const {
  if (id.index >= slices.size() || slices[id.index].generation != id.generation ||
      slices[id.index].firstPoint == UINT32_MAX) {
    return nullptr;
  }
  return &slices[id.index];
}

InstanceId InstanceTable::add(ShapeId shape, const InstanceLook& look) {
  std::uint32_t index = static_cast<std::uint32_t>(slots_.size());
  if (free_.empty()) {
    slots_.emplace_back();
  } else {
    index = free_.back();
    free_.pop_back();
  }
  slots_[index].shape = shape.index;
  slots_[index].look = look;
  changed_ = true;
  return {index, slots_[index].generation};
}

void InstanceTable::setLook(InstanceId id, const InstanceLook& look) {
  living(id).look = look;
  changed_ = true;
}

void InstanceTable::remove(InstanceId id) {
  Slot& slot = living(id);
  slot.shape = UINT32_MAX;
  ++slot.generation;
  free_.push_back(id.index);
  changed_ = true;
}

bool InstanceTable::uses(std::uint32_t shape) const {
  return std::any_of(slots_.begin(), slots_.end(), [shape](const Slot& slot) { return slot.shape == shape; });
}

std::uint32_t InstanceTable::shapeOf(InstanceId id) const {
  if (id.index >= slots_.size() || slots_[id.index].generation != id.generation ||
      slots_[id.index].shape == UINT32_MAX) {
    throw std::runtime_error("there is no instance with this id; it was removed or never added");
  }
  return slots_[id.index].shape;
}

InstanceTable::Slot& InstanceTable::living(InstanceId id) {
  shapeOf(id);
  return slots_[id.index];
}

void InstanceTable::layOut(const std::vector<ShapeExtent>& shapes, FrameLayout& layout) {
  layout.groups.clear();
  layout.records.clear();
  layout.slices.assign(slots_.size(), {});
  layout.pointCount = layout.skinnedPointCount = layout.normalCount = 0;
  // There are few shapes, so one pass over the slots for each is cheaper than lists of instances.
  for (std::uint32_t shape = 0; shape < shapes.size(); ++shape) {
    const InstanceGroup group = layOutShape(shape, shapes[shape], layout);
    if (group.instanceCount > 0) {
      layout.groups.push_back(group);
    }
  }
  changed_ = false;
}

InstanceGroup InstanceTable::layOutShape(std::uint32_t shape, const ShapeExtent& extent,
                                         FrameLayout& layout) const {
  InstanceGroup group;
  group.shape = shape;
  group.firstInstance = static_cast<std::uint32_t>(layout.records.size());
  group.firstPoint = static_cast<std::uint32_t>(layout.pointCount);
  group.firstPlace = static_cast<std::uint32_t>(layout.skinnedPointCount);
  group.firstNormal = static_cast<std::uint32_t>(layout.normalCount);
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (slots_[i].shape != shape) {
      continue;
    }
    layout.slices[i] = {slots_[i].generation, static_cast<std::uint32_t>(layout.pointCount),
                        static_cast<std::uint32_t>(layout.skinnedPointCount),
                        static_cast<std::uint32_t>(layout.normalCount)};
    layout.records.push_back(recordOf(slots_[i].look));
    group.textured |= slots_[i].look.texture.index != UINT32_MAX;
    layout.pointCount += extent.pointCount;
    layout.skinnedPointCount += extent.skinned ? extent.skinnedPointCount : 0;
    layout.normalCount += extent.normalCount;
    ++group.instanceCount;
    requireCountable(layout);
  }
  return group;
}

}  // namespace limber::render

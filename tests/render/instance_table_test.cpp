// SPDX-License-Identifier: Zlib
#include "instance_table.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace limber::render {
namespace {

TEST(InstanceTable, InstancesOfAShapeLieTogether) {
  InstanceTable table;
  const InstanceId a = table.add({0}, {});
  const InstanceId b = table.add({1}, {});
  const InstanceId c = table.add({0}, {});
  FrameLayout layout;
  table.layOut({{8, 8, false, 0}, {5, 5, false, 7}, {100, 100, false, 100}}, layout);
  ASSERT_EQ(layout.groups.size(), 2u) << "shapes without instances are left out";
  EXPECT_EQ(layout.groups[0].instanceCount, 2u);
  EXPECT_EQ(layout.find(a)->firstPoint, 0u);
  EXPECT_EQ(layout.find(c)->firstPoint, 8u);
  EXPECT_EQ(layout.find(b)->firstPoint, 16u);
  EXPECT_EQ(layout.pointCount, 21u);
  EXPECT_EQ(layout.normalCount, 7u);
  EXPECT_FALSE(table.changed());
}

TEST(InstanceTable, ASkinsPlacesAndNormalsAreCountedApartFromItsPoints) {
  InstanceTable table;
  table.add({0}, {});
  const InstanceId b = table.add({0}, {});
  const InstanceId c = table.add({1}, {});
  FrameLayout layout;
  table.layOut({{4, 1000, true, 1000}, {7, 7, false, 7}}, layout);
  EXPECT_EQ(layout.pointCount, 2u * 4u + 7u);
  EXPECT_EQ(layout.skinnedPointCount, 2000u);
  EXPECT_EQ(layout.normalCount, 2007u);
  EXPECT_EQ(layout.find(b)->firstPlace, 1000u);
  EXPECT_EQ(layout.find(c)->firstNormal, 2000u);
}

TEST(InstanceTable, RemovedIdsStayInvalidWhenTheirSlotIsReused) {
  InstanceTable table;
  const InstanceId old = table.add({0}, {});
  table.remove(old);
  const InstanceId fresh = table.add({0}, {});
  EXPECT_EQ(fresh.index, old.index);
  EXPECT_THROW(table.remove(old), std::runtime_error);
  EXPECT_THROW(table.setLook(old, {}), std::runtime_error);
  FrameLayout layout;
  table.layOut({{8, 8, false, 0}}, layout);
  EXPECT_EQ(layout.find(old), nullptr);
  EXPECT_NE(layout.find(fresh), nullptr);
  EXPECT_EQ(table.size(), 1u);
}

TEST(InstanceTable, TooManyPointsAreRefused) {
  InstanceTable table;
  table.add({0}, {});
  table.add({0}, {});
  FrameLayout layout;
  EXPECT_THROW(table.layOut({{UINT32_MAX / 4, UINT32_MAX / 4, false, 0}}, layout), std::runtime_error);
  EXPECT_TRUE(table.changed());
}

}  // namespace
}  // namespace limber::render

// SPDX-License-Identifier: Zlib
#include <gtest/gtest.h>

#include <cmath>

#include "limber/render/scenery.h"
#include "limber/render/shape_desc.h"

namespace limber::render {
namespace {

ShapeDesc box() { return makeBox({}, {1.0f, 1.0f, 1.0f}).shape; }

TEST(ShapeCheck, SceneryIsValid) {
  EXPECT_EQ(validate(box()), "");
  EXPECT_EQ(validate(makeUvSphere({}, 1.0f).shape), "");
  EXPECT_EQ(validate(makeUvSphere({}, 1.0f, 2, 3).shape), "");
  EXPECT_EQ(validate(makeFloor({}, 1.0f).shape), "");
}

TEST(ShapeCheck, IndicesOutOfRangeAreNamed) {
  ShapeDesc desc = box();
  desc.vertexToPoint[5] = 8;
  EXPECT_EQ(validate(desc), "vertexToPoint[5] is 8, but there are only 8 points");
  desc = box();
  desc.lines = {0, 1, 2, 9};
  EXPECT_EQ(validate(desc), "lines[3] is 9, but there are only 8 points");
}

TEST(ShapeCheck, LengthsThatDoNotFitAreNamed) {
  ShapeDesc desc = box();
  desc.uvs.pop_back();
  EXPECT_EQ(validate(desc), "uvs has 47 floats for 24 vertices");
  desc = box();
  desc.triangles.pop_back();
  EXPECT_EQ(validate(desc), "triangles has 35 indices, which is no multiple of 3");
  desc = box();
  desc.lines = {0, 1};
  desc.lineRestLengths = {1.0f, 2.0f};
  EXPECT_EQ(validate(desc), "lineRestLengths has 2 entries for 1 lines");
  desc.lineRestLengths = {0.0f};
  EXPECT_EQ(validate(desc), "lineRestLengths[0] is not a positive length");
}

TEST(ShapeCheck, SkinsThatDoNotFitAreNamed) {
  ShapeDesc good = box();
  good.pointCount = 2;
  good.skin.first = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  good.skin.points = {0, 1, 0, 1, 0, 1, 0, 1};
  good.skin.weights.assign(8, 1.0f);
  EXPECT_EQ(validate(good), "");
  ShapeDesc desc = good;
  desc.skin.points[3] = 2;
  EXPECT_EQ(validate(desc), "skin.points[3] is 2, but there are only 2 points");
  desc = good;
  desc.skin.weights[5] = NAN;
  EXPECT_EQ(validate(desc), "skin.weights[5] is not finite");
  desc = good;
  desc.skin.weights.pop_back();
  EXPECT_EQ(validate(desc), "skin.points has 8 entries for 7 weights");
  desc = good;
  desc.skin = {{0}, {}, {}};
  EXPECT_EQ(validate(desc), "skin.first has one entry, but a skin with places has one more than places");
  desc = good;
  desc.skin.first.back() = 7;
  EXPECT_EQ(validate(desc), "skin.first goes from 0 to 7, but must go from 0 to the 8 weights");
  desc = good;
  desc.skin.first[4] = 6;
  EXPECT_EQ(validate(desc), "skin.first[5] is below the entry before it");
  desc = good;
  desc.skin.first.clear();
  EXPECT_EQ(validate(desc), "skin.first is empty, but there are weights");
  desc = good;
  desc.vertexToPoint[5] = 8;
  EXPECT_EQ(validate(desc), "vertexToPoint[5] is 8, but there are only 8 places of the skin");
}

TEST(ShapeCheck, EmptyAndContradictoryShapesAreRefused) {
  EXPECT_EQ(validate({}), "pointCount is 0");
  ShapeDesc desc;
  desc.pointCount = 3;
  EXPECT_NE(validate(desc).find("nothing to draw"), std::string::npos);
  desc = box();
  desc.tubeRadius = 0.1f;
  EXPECT_NE(validate(desc).find("makes its own vertices"), std::string::npos);
  desc = {};
  desc.pointCount = 1;
  desc.tubeRadius = 0.1f;
  EXPECT_NE(validate(desc).find("at least 2 points"), std::string::npos);
  desc = box();
  desc.pattern = Pattern::Grid;
  EXPECT_NE(validate(desc).find("patternRadius"), std::string::npos);
}

}  // namespace
}  // namespace limber::render

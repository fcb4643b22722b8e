// SPDX-License-Identifier: Zlib
#include "limber/render/renderer.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "baseline_picture.h"
#include "pictures.h"

namespace limber::render::test {
namespace {

TEST(Renderer, ZeroInstancesGiveTheBackground) {
  Stage stage(Backend::Auto, smallDesc(ComputeOn::Gpu));
  const Image image = stage.picture();
  EXPECT_EQ(image.width, kWidth);
  EXPECT_EQ(image.height, kHeight);
  EXPECT_EQ(stage.renderer().lastFrame().shapeDrawCalls, 0u);
  EXPECT_EQ(stage.renderer().lastFrame().bytesStreamed, 0u);
  EXPECT_EQ(image.pixel(3, 3)[3], 255);
  EXPECT_EQ(pictureAs(*bench::makeNaivePoints(stage.renderer()), stage).rgba, image.rgba);
  DrawOptions wire;
  wire.mode = DrawMode::Wireframe;
  stage.draw(wire);
}

TEST(Renderer, OneDrawCallPerShapeAndPass) {
  Stage stage(Backend::Auto, smallDesc(ComputeOn::Gpu));
  populate(stage);
  stage.light.shadows = false;
  stage.draw();
  EXPECT_EQ(stage.renderer().lastFrame().shapeDrawCalls, 7u);
  EXPECT_EQ(stage.renderer().lastFrame().dispatches, 7u)
      << "normals of four shapes and one of tubes, places of two";
  stage.light.shadows = true;
  stage.draw();
  EXPECT_EQ(stage.renderer().lastFrame().shapeDrawCalls, 13u) << "the floor casts no shadow";
  EXPECT_EQ(stage.renderer().lastFrame().drawCalls, 14u);
}

TEST(Renderer, StreamsTwelveBytesPerPoint) {
  Stage stage;
  const Scenery box = makeBox({}, {0.3f, 0.3f, 0.3f});
  const ShapeId shape = stage.renderer().addShape(box.shape);
  for (int i = 0; i < 10; ++i) {
    stage.add(shape, box.points);
  }
  stage.draw();
  EXPECT_EQ(stage.renderer().lastFrame().bytesStreamed, 10u * 8u * 12u);
}

TEST(Renderer, ResizeDrawsTheNewSize) {
  Stage stage;
  populate(stage);
  const Image before = stage.picture();
  stage.renderer().resize(97, 31);
  const Image small = stage.picture();
  EXPECT_EQ(small.width, 97);
  EXPECT_EQ(small.height, 31);
  EXPECT_EQ(small.rgba.size(), 4u * 97u * 31u);
  stage.renderer().resize(kWidth, kHeight);
  EXPECT_EQ(stage.picture().rgba, before.rgba);
  EXPECT_NE(errorOf([&] { stage.renderer().resize(0, 5); }).find("0 x 5"), std::string::npos);
  EXPECT_EQ(stage.picture().rgba, before.rgba) << "a refused resize must change nothing";
}

TEST(Renderer, InstancesComeAndGoWhileFramesAreInFlight) {
  Stage changing;
  Stage steady;
  const Scenery box = makeBox({}, {0.4f, 0.4f, 0.4f});
  const Scenery ball = makeUvSphere({0.0f, 0.9f, 0.0f}, 0.4f, 8, 12);
  const ShapeId boxShape = changing.renderer().addShape(box.shape);
  const ShapeId ballShape = changing.renderer().addShape(ball.shape);
  steady.add(box);
  steady.add(ball);
  const Image expected = steady.picture();
  changing.add(boxShape, box.points);
  for (int i = 0; i < 12; ++i) {
    const InstanceId briefId = changing.add(boxShape, moved(box.points, 1.0f, 0.0f, 0.0f));
    const InstanceId ballId = changing.add(ballShape, ball.points);
    changing.draw();
    changing.remove(briefId);
    changing.draw();
    if (i < 11) {
      changing.remove(ballId);
    }
  }
  EXPECT_EQ(changing.picture().rgba, expected.rgba);
}

TEST(Renderer, GrowsWithManyInstancesAndKeepsThePicture) {
  RendererDesc desc = smallDesc();
  desc.initialPoints = 8;
  Stage stage(Backend::Auto, desc);
  Stage roomy;
  populate(roomy);
  const Scenery box = makeBox({}, {0.3f, 0.3f, 0.3f});
  stage.add(box);
  stage.draw();
  EXPECT_EQ(stage.renderer().ringStats().growths, 0u);
  const std::size_t before = stage.renderer().gpuMemory().stream;
  populate(stage);
  roomy.add(box);
  const Image grown = stage.picture();
  EXPECT_EQ(stage.renderer().ringStats().growths, 1u);
  EXPECT_GT(stage.renderer().gpuMemory().stream, before);
  EXPECT_EQ(grown.rgba, roomy.picture().rgba);
}

TEST(Renderer, ChangesDuringAnOpenFrameWaitForTheNext) {
  Stage stage;
  const Scenery box = makeBox({}, {0.4f, 0.4f, 0.4f});
  const ShapeId shape = stage.renderer().addShape(box.shape);
  const InstanceId first = stage.add(shape, box.points);
  FrameWriter frame = stage.renderer().beginFrame();
  const InstanceId lateId = stage.renderer().addInstance(shape);
  stage.renderer().removeInstance(first);
  EXPECT_NO_THROW(std::copy(box.points.begin(), box.points.end(), frame.points(first)));
  EXPECT_NE(errorOf([&] { frame.points(lateId); }).find("added after"), std::string::npos);
  stage.renderer().draw(frame, stage.camera, stage.light);
  FrameWriter next = stage.renderer().beginFrame();
  EXPECT_THROW(next.points(first), std::runtime_error);
  EXPECT_NO_THROW(std::copy(box.points.begin(), box.points.end(), next.points(lateId)));
}

TEST(Renderer, WrongOrdersAreRefused) {
  Stage stage;
  populate(stage);
  {
    const FrameWriter frame = stage.renderer().beginFrame();
    EXPECT_THROW(stage.renderer().beginFrame(), std::logic_error);
    EXPECT_THROW(stage.renderer().resize(10, 10), std::logic_error);
  }
  FrameWriter frame = stage.renderer().beginFrame();
  stage.renderer().draw(frame, stage.camera, stage.light);
  EXPECT_THROW(stage.renderer().draw(frame, stage.camera, stage.light), std::logic_error);
}

TEST(Renderer, BadInputNamesTheProblem) {
  Stage stage;
  Renderer& renderer = stage.renderer();
  ShapeDesc desc = makeBox({}, {1.0f, 1.0f, 1.0f}).shape;
  desc.name = "crate";
  desc.triangles[7] = 24;
  const std::string text = errorOf([&] { renderer.addShape(desc); });
  EXPECT_EQ(text, "shape \"crate\": triangles[7] is 24, but there are only 24 vertices");
  EXPECT_NE(errorOf([&] { renderer.addInstance({5}); }).find("no shape"), std::string::npos);
  EXPECT_NE(errorOf([&] { renderer.removeInstance({5, 0}); }).find("no instance"), std::string::npos);
  EXPECT_NE(errorOf([&] { renderer.addTexture(0, 4, nullptr); }).find("0 x 4"), std::string::npos);
  const ShapeId shape = renderer.addShape(makeBox({}, {1.0f, 1.0f, 1.0f}).shape);
  EXPECT_NE(errorOf([&] {
              renderer.addInstance(shape, {{}, TextureId{0}});
            }).find("no texture"),
            std::string::npos);
}

TEST(Renderer, RemovedShapesAreFreedAndTheirIdsRefused) {
  Stage stage;
  Renderer& renderer = stage.renderer();
  const Scenery ball = makeUvSphere({}, 0.5f);
  const std::size_t before = renderer.gpuMemory().shapes;
  const ShapeId shape = renderer.addShape(ball.shape);
  const InstanceId id = stage.add(shape, ball.points);
  const Image picture = stage.picture();
  EXPECT_THROW(renderer.removeShape(shape), std::runtime_error) << "it has an instance";
  stage.remove(id);
  renderer.removeShape(shape);
  EXPECT_EQ(renderer.gpuMemory().shapes, before);
  EXPECT_THROW(renderer.removeShape(shape), std::runtime_error);
  EXPECT_THROW(renderer.addInstance(shape), std::runtime_error);
  const ShapeId newShape = renderer.addShape(ball.shape);
  EXPECT_EQ(newShape.index, shape.index);
  EXPECT_THROW(renderer.addInstance(shape), std::runtime_error) << "the slot has another shape now";
  const InstanceId newId = stage.add(newShape, ball.points);
  EXPECT_EQ(stage.picture().rgba, picture.rgba);
  FrameWriter frame = renderer.beginFrame();
  stage.write(frame);
  stage.remove(newId);
  renderer.removeShape(newShape);
  EXPECT_THROW(renderer.addInstance(newShape), std::runtime_error) << "at once";
  renderer.draw(frame, stage.camera, stage.light);
  EXPECT_EQ(renderer.readPixels().rgba, picture.rgba) << "an open frame is drawn with it";
  EXPECT_EQ(renderer.gpuMemory().shapes, before);
}

TEST(Renderer, BadInputOfAFrameIsNamedAndLeavesItOpen) {
  Stage stage;
  populate(stage);
  const Image expected = stage.picture();
  Renderer& renderer = stage.renderer();
  FrameWriter frame = renderer.beginFrame();
  stage.write(frame);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto errorWith = [&](auto change) {
    Camera camera = stage.camera;
    Light light = stage.light;
    DrawOptions options;
    change(camera, light, options);
    return errorOf([&] { renderer.draw(frame, camera, light, options); });
  };
  EXPECT_EQ(errorWith([&](Camera& c, Light&, DrawOptions&) { c.eye.y = nan; }), "camera.eye is not finite");
  EXPECT_EQ(errorWith([&](Camera& c, Light&, DrawOptions&) { c.target = c.eye; }),
            "camera.target is camera.eye");
  EXPECT_EQ(errorWith([&](Camera& c, Light&, DrawOptions&) { c.nearPlane = c.farPlane; }),
            "camera.nearPlane must be above 0 and below farPlane");
  EXPECT_EQ(errorWith([&](Camera&, Light& l, DrawOptions&) { l.shadowRadius = nan; }),
            "light.shadowRadius is not finite");
  EXPECT_EQ(errorWith([&](Camera&, Light&, DrawOptions& o) { o.strainRange = 0.0f; }),
            "options.strainRange must be above 0");
  renderer.draw(frame, stage.camera, stage.light);
  EXPECT_EQ(renderer.readPixels().rgba, expected.rgba);
  FrameWriter next = renderer.beginFrame();
  const FrameWriter moved = std::move(next);
  EXPECT_THROW(next.points({}), std::logic_error) << "moved";
}

TEST(Renderer, MemoryReportCoversWhatWasAdded) {
  Stage stage;
  const GpuMemory before = stage.renderer().gpuMemory();
  const Scenery ball = makeUvSphere({}, 0.4f, 8, 12);
  stage.add(ball);
  stage.draw();
  const GpuMemory after = stage.renderer().gpuMemory();
  EXPECT_GE(after.shapes - before.shapes, 4 * ball.shape.triangles.size());
  EXPECT_GT(after.scratch, before.scratch);
  EXPECT_GE(after.targets - before.targets, 512u * 512u * 2u) << "the shadow map";
  EXPECT_EQ(after.total(), after.buffers() + after.textures + after.targets);
  EXPECT_EQ(stage.renderer().gpuBufferBytes(), after.buffers());
}

}  // namespace
}  // namespace limber::render::test

// SPDX-License-Identifier: Zlib
#include "scene_shapes.h"

#include "scenes/shape_error.h"

#include <algorithm>

namespace limber::demo {
namespace {

const render::Vec3 kFloorColour{0.78f, 0.79f, 0.82f};

void addSurface(render::ShapeDesc& shape, const SpringNetwork& network) {
  const Skin& skin = network.render.skin;
  shape.skin = {skin.firstWeight, skin.points, skin.weights};
  shape.vertexToPoint = network.render.vertexToPoint;
  for (const Eigen::Vector2f& uv : network.render.uvs) shape.uvs.insert(shape.uvs.end(), {uv.x(), uv.y()});
  for (const Triangle& t : network.render.triangles) {
    shape.triangles.insert(shape.triangles.end(), t.begin(), t.end());
  }
  // a vertex no triangle uses rides on no point; the renderer wants one all the same
  for (std::uint32_t& point : shape.vertexToPoint) {
    if (point == kNoPoint) point = 0;
  }
}

render::Frame frameOf(const btTransform& place) {
  const btMatrix3x3& turn = place.getBasis();
  return {toVec3(place.getOrigin()), toVec3(turn.getColumn(0)), toVec3(turn.getColumn(1)),
          toVec3(turn.getColumn(2))};
}

/// Bending springs lie over the grid's own and would only hide them.
void addSprings(render::ShapeDesc& shape, const SoftBody& body) {
  const std::vector<Eigen::Vector3d> rest = scenes::restShape(body);
  for (const NetworkSpring& spring : body.network().springs) {
    if (spring.kind == SpringKind::Bending) continue;
    shape.lines.insert(shape.lines.end(), {spring.a, spring.b});
    shape.lineRestLengths.push_back(static_cast<float>((rest[spring.b] - rest[spring.a]).norm()));
  }
}

}  // namespace

render::ShapeDesc shapeOf(const SoftBody& body, const scenes::BodyLook& look) {
  const SpringNetwork& network = body.network();
  render::ShapeDesc shape;
  shape.name = "body";
  shape.pointCount = body.pointCount();
  shape.shading = look.smooth ? render::Shading::Smooth : render::Shading::Flat;
  // an open surface shows its other side, and so does one that has been turned inside out
  shape.twoSided = true;
  if (network.kind == NetworkKind::Rope)
    shape.tubeRadius = static_cast<float>(pointRadius(network, body.settings()));
  else
    addSurface(shape, network);
  addSprings(shape, body);
  return shape;
}

void writePoints(const SoftBody& body, float* xyz) { body.writePositions(xyz); }

std::vector<Prop> propsOf(const scenes::Scene& scene) {
  std::vector<Prop> props;
  const scenes::FloorProp& floor = scene.floor;
  const render::Vec3 middle{0.0f, static_cast<float>(floor.height), 0.0f};
  props.push_back({render::makeRigid(render::makeFloor(middle, static_cast<float>(floor.halfSize))),
                   kFloorColour, nullptr});
  for (const scenes::BoxProp& box : scene.boxes) {
    props.push_back({render::makeRigid(render::makeBox(toVec3(box.centre), toVec3(box.halfExtents))),
                     toVec3(box.colour), box.body});
  }
  for (const scenes::SphereProp& ball : scene.spheres) {
    const float radius = static_cast<float>(ball.radius);
    props.push_back({render::makeRigid(render::makeUvSphere(toVec3(ball.centre), radius)),
                     toVec3(ball.colour), ball.body});
  }
  return props;
}

void writePoints(const Prop& prop, float* xyz) {
  const render::Frame frame = prop.body ? frameOf(prop.body->getWorldTransform()) : render::Frame{};
  render::writeFrame(prop.surface.reach, frame, xyz);
}

render::Image checkerTexture() {
  constexpr int kSquares = 8, kSquarePixels = 32;
  constexpr std::uint8_t kLight = 255, kDark = 168;
  render::Image image;
  image.resize(kSquares * kSquarePixels, kSquares * kSquarePixels);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const bool light = (x / kSquarePixels + y / kSquarePixels) % 2 == 0;
      std::uint8_t* pixel = image.pixel(x, y);
      pixel[0] = pixel[1] = pixel[2] = light ? kLight : kDark;
      pixel[3] = 255;
    }
  }
  return image;
}

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#include "scene_shapes.h"

#include "scenes/shape_error.h"

#include <algorithm>

namespace limber::demo {
namespace {

const render::Vec3 kFloorColour{0.78f, 0.79f, 0.82f};

void addSurface(render::ShapeDesc& shape, const SpringNetwork& network) {
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

bool hasSkin(const SoftBody& body) { return body.network().render.skin.size() > 0; }

/// Bending springs lie over the grid's own and would only hide them.
void addSprings(render::ShapeDesc& shape, const SoftBody& body) {
  const std::vector<Eigen::Vector3d> rest = scenes::restShape(body);
  const std::uint32_t first = hasSkin(body) ? body.placeCount() : 0;
  for (const NetworkSpring& spring : body.network().springs) {
    if (spring.kind == SpringKind::Bending) continue;
    shape.lines.insert(shape.lines.end(), {first + spring.a, first + spring.b});
    shape.lineRestLengths.push_back(static_cast<float>((rest[spring.b] - rest[spring.a]).norm()));
  }
}

}  // namespace

render::ShapeDesc shapeOf(const SoftBody& body, const scenes::BodyLook& look) {
  const SpringNetwork& network = body.network();
  render::ShapeDesc shape;
  shape.name = "body";
  shape.pointCount = body.placeCount() + (hasSkin(body) ? body.pointCount() : 0);
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

void writePoints(const SoftBody& body, float* xyz) {
  body.writePlaces(xyz);
  if (hasSkin(body)) body.writePositions(xyz + std::size_t{3} * body.placeCount());
}

std::vector<Prop> propsOf(const scenes::Scene& scene) {
  std::vector<Prop> props;
  const scenes::FloorProp& floor = scene.floor;
  const render::Vec3 middle{0.0f, static_cast<float>(floor.height), 0.0f};
  props.push_back({render::makeFloor(middle, static_cast<float>(floor.halfSize)), kFloorColour, nullptr});
  for (const scenes::BoxProp& box : scene.boxes) {
    props.push_back(
        {render::makeBox(toVec3(box.centre), toVec3(box.halfExtents)), toVec3(box.colour), box.body});
  }
  for (const scenes::SphereProp& ball : scene.spheres) {
    const float radius = static_cast<float>(ball.radius);
    props.push_back({render::makeUvSphere(toVec3(ball.centre), radius), toVec3(ball.colour), ball.body});
  }
  return props;
}

void writePoints(const Prop& prop, float* xyz) {
  const std::vector<float>& points = prop.scenery.points;
  if (!prop.body) {
    std::copy(points.begin(), points.end(), xyz);
    return;
  }
  const btTransform& place = prop.body->getWorldTransform();
  for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
    const btVector3 p =
        place * btVector3(btScalar(points[i]), btScalar(points[i + 1]), btScalar(points[i + 2]));
    for (int k = 0; k < 3; ++k) xyz[i + static_cast<std::size_t>(k)] = static_cast<float>(p[k]);
  }
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

// SPDX-License-Identifier: Zlib
#include "limber/view/soft_surface.h"

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

void addSurface(render::ShapeDesc& shape, const RenderSurface& surface) {
  shape.skin = {surface.skin.firstWeight, surface.skin.points, surface.skin.weights};
  shape.vertexToPoint = surface.vertexToPoint;
  // a vertex no triangle uses rides on no point; the renderer wants one all the same
  for (std::uint32_t& point : shape.vertexToPoint) {
    if (point == kNoPoint) point = 0;
  }
  for (const Eigen::Vector2f& uv : surface.uvs) shape.uvs.insert(shape.uvs.end(), {uv.x(), uv.y()});
  for (const Triangle& t : surface.triangles) {
    shape.triangles.insert(shape.triangles.end(), t.begin(), t.end());
  }
}

/// Bending springs lie over the others and would only hide them.
void addSprings(render::ShapeDesc& shape, const SoftBody& body) {
  const SpringNetwork& network = body.network();
  const Eigen::Vector3d& scale = body.settings().scale;
  for (const NetworkSpring& spring : network.springs) {
    if (spring.kind == SpringKind::Bending) continue;
    const Eigen::Vector3d way = network.restPoints[spring.b] - network.restPoints[spring.a];
    shape.lines.insert(shape.lines.end(), {spring.a, spring.b});
    shape.lineRestLengths.push_back(static_cast<float>(way.cwiseProduct(scale).norm()));
  }
}

}  // namespace

render::ShapeDesc shapeOf(const SoftBody& body, render::Shading shading) {
  const SpringNetwork& network = body.network();
  render::ShapeDesc shape;
  shape.name = "soft body";
  shape.pointCount = body.pointCount();
  shape.shading = shading;
  shape.twoSided = true;
  if (network.kind == NetworkKind::Rope)
    shape.tubeRadius = static_cast<float>(pointRadius(network, body.settings()));
  else
    addSurface(shape, network.render);
  addSprings(shape, body);
  return shape;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view

// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/camera.h>
#include <limber/render/light.h>
#include <limber/render/scenery.h>

#include <Eigen/Geometry>

#include <string>

namespace limber::bench {

/// Bodies of one shape over a floor that deform without being simulated.
struct FrameScene {
  std::string name;
  render::ShapeDesc shape;
  Eigen::Matrix3Xf rest;     ///< m, points of a body around its middle
  Eigen::Matrix3Xf centres;  ///< m, of the bodies
  render::Scenery floor;

  std::size_t bodies() const { return static_cast<std::size_t>(centres.cols()); }
  std::size_t points() const;     ///< that are written each frame: of all bodies and the floor
  std::size_t triangles() const;  ///< likewise
  render::Camera camera(float aspect) const;
  render::Light light(bool shadows) const;

 private:
  Eigen::AlignedBox3f box() const;
};

/// A square of cubes of 8 points and 12 triangles with flat sides.
FrameScene makeCubeScene(std::size_t count);
/// One smooth closed body of 50 002 points and 100 000 triangles, or of a tenth as many.
FrameScene makeBallScene(bool tenth);

/// The points of all bodies, one body after the other, in frame number `frame`.
void pose(const FrameScene& scene, int frame, Eigen::Matrix3Xf& points);

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#pragma once

#include "window/command.h"

#include <limber/render/camera.h>

#include <Eigen/Core>

#include <optional>

namespace limber::demo {

/// A picture's size and the position in it, pixels from the top left.
struct Pixel {
  double x = 0.0, y = 0.0;
};
struct WindowSize {
  int width = 1280, height = 720;
  double aspect() const { return static_cast<double>(width) / static_cast<double>(height); }
};

/// A camera that moves around a target.
struct OrbitCamera {
  double yaw = 0.0;       ///< rad about the vertical; 0: the eye is in the direction +z of the target
  double pitch = 0.4;     ///< rad of the eye above the target, less than a right angle
  double distance = 5.0;  ///< m from the eye to the target
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< m

  Eigen::Vector3d eye() const;
  /// Unit vectors in the picture: to the right, up, and towards the eye.
  Eigen::Vector3d right() const;
  Eigen::Vector3d up() const;
  Eigen::Vector3d back() const;
  /// Returns it for the renderer. The near plane is a small share of the distance.
  render::Camera camera() const;

  /// Returns the ray through a pixel.
  Ray ray(Pixel pixel, const WindowSize& size) const;
  /// Returns the pixel of a place in front of the camera.
  std::optional<Pixel> pixelOf(const Eigen::Vector3d& place, const WindowSize& size) const;
};

/// Returns the orbit with this eye and target.
OrbitCamera orbitOf(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

/// These return the camera after a movement of the mouse by so many pixels, or of its wheel by so many steps.
OrbitCamera orbited(OrbitCamera camera, Pixel movement, const WindowSize& size);
OrbitCamera panned(OrbitCamera camera, Pixel movement, const WindowSize& size);
OrbitCamera zoomed(OrbitCamera camera, double steps);

Command cameraCommand(const OrbitCamera& camera);
OrbitCamera cameraOf(const Command& command);

}  // namespace limber::demo

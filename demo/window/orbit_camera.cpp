// SPDX-License-Identifier: Zlib
#include "window/orbit_camera.h"

#include "scene_renderer.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace limber::demo {
namespace {

constexpr double kHalfTurn = 3.141592653589793;
// the view from above has no "up"; a user does not mean to look from below the floor
constexpr double kMinPitch = 0.02, kMaxPitch = 0.49 * kHalfTurn;
constexpr double kMinDistance = 0.01, kMaxDistance = 1000.0;  // m
constexpr double kZoomStep = 0.88;                            // times the distance, a step of the wheel
constexpr double kNearShare = 0.02, kFarShare = 40.0;         // of the distance

double fieldOfView() { return static_cast<double>(render::Camera().verticalFieldOfView); }

/// m of the plane through the target that one pixel shows.
double metresPerPixel(const OrbitCamera& camera, const WindowSize& size) {
  return 2.0 * std::tan(0.5 * fieldOfView()) * camera.distance / size.height;
}

}  // namespace

Eigen::Vector3d OrbitCamera::back() const {
  return {std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch)};
}

Eigen::Vector3d OrbitCamera::right() const { return {std::cos(yaw), 0.0, -std::sin(yaw)}; }

Eigen::Vector3d OrbitCamera::up() const { return back().cross(right()); }

Eigen::Vector3d OrbitCamera::eye() const { return target + distance * back(); }

render::Camera OrbitCamera::camera() const {
  render::Camera camera;
  camera.eye = toVec3(eye());
  camera.target = toVec3(target);
  camera.nearPlane = static_cast<float>(kNearShare * distance);
  camera.farPlane = static_cast<float>(kFarShare * distance);
  return camera;
}

Ray OrbitCamera::ray(Pixel pixel, const WindowSize& size) const {
  const double half = std::tan(0.5 * fieldOfView());
  const double x = (2.0 * pixel.x / size.width - 1.0) * half * size.aspect();
  const double y = (1.0 - 2.0 * pixel.y / size.height) * half;
  return {eye(), (x * right() + y * up() - back()).normalized()};
}

std::optional<Pixel> OrbitCamera::pixelOf(const Eigen::Vector3d& place, const WindowSize& size) const {
  const Eigen::Vector3d away = place - eye();
  const double depth = -away.dot(back());
  if (depth <= 0.0) return std::nullopt;
  const double half = std::tan(0.5 * fieldOfView()) * depth;
  return Pixel{0.5 * size.width * (1.0 + away.dot(right()) / (half * size.aspect())),
               0.5 * size.height * (1.0 - away.dot(up()) / half)};
}

OrbitCamera orbitOf(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  OrbitCamera camera;
  const Eigen::Vector3d away = eye - target;
  camera.target = target;
  camera.distance = std::clamp(away.norm(), kMinDistance, kMaxDistance);
  camera.yaw = std::atan2(away.x(), away.z());
  camera.pitch = std::clamp(std::atan2(away.y(), std::hypot(away.x(), away.z())), -kMaxPitch, kMaxPitch);
  return camera;
}

OrbitCamera orbited(OrbitCamera camera, Pixel movement, const WindowSize& size) {
  const double angle = kHalfTurn / size.height;  // half a turn for the height of the window
  camera.yaw = std::remainder(camera.yaw - angle * movement.x, 2.0 * kHalfTurn);
  const double lowest = std::min(camera.pitch, kMinPitch);
  camera.pitch = std::clamp(camera.pitch + angle * movement.y, lowest, kMaxPitch);
  return camera;
}

OrbitCamera panned(OrbitCamera camera, Pixel movement, const WindowSize& size) {
  camera.target += metresPerPixel(camera, size) * (movement.y * camera.up() - movement.x * camera.right());
  return camera;
}

OrbitCamera zoomed(OrbitCamera camera, double steps) {
  camera.distance = std::clamp(camera.distance * std::pow(kZoomStep, steps), kMinDistance, kMaxDistance);
  return camera;
}

Command cameraCommand(const OrbitCamera& camera) {
  const Eigen::Vector3d& t = camera.target;
  return {Action::Camera, {camera.yaw, camera.pitch, camera.distance, t.x(), t.y(), t.z()}, {}};
}

OrbitCamera cameraOf(const Command& command) {
  const std::vector<double>& n = command.numbers;
  OrbitCamera camera;
  camera.yaw = n[0];
  camera.pitch = std::clamp(n[1], -kMaxPitch, kMaxPitch);
  camera.distance = std::clamp(n[2], kMinDistance, kMaxDistance);
  camera.target = {n[3], n[4], n[5]};
  return camera;
}

}  // namespace limber::demo

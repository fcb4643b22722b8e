// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "limber/render/vec3.h"

namespace limber::render {

constexpr float kPi = 3.14159265f;

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(float s, Vec3 v) { return {s * v.x, s * v.y, s * v.z}; }
inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(Vec3 v) { return std::sqrt(dot(v, v)); }

/// Returns the unit vector along `v`, or `fallback` (a unit vector) if `v` has no direction.
inline Vec3 unitOr(Vec3 v, Vec3 fallback) {
  const float size = length(v);
  return size > 1e-12f && std::isfinite(size) ? (1.0f / size) * v : fallback;
}

/// 4 x 4, column by column, as OpenGL requires.
struct Mat4 {
  std::array<float, 16> m{};

  float& at(std::size_t row, std::size_t column) { return m[4 * column + row]; }
  float at(std::size_t row, std::size_t column) const { return m[4 * column + row]; }
};

inline Mat4 operator*(const Mat4& a, const Mat4& b) {
  Mat4 product;
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 0; column < 4; ++column) {
      for (std::size_t k = 0; k < 4; ++k) {
        product.at(row, column) += a.at(row, k) * b.at(k, column);
      }
    }
  }
  return product;
}

/// Returns world to view: the eye is at the origin and looks along -z, x is right and y is up.
inline Mat4 lookAlong(Vec3 eye, Vec3 forward, Vec3 up) {
  // Any side vector is allowed if `up` is parallel to `forward`.
  const Vec3 fallback = unitOr(cross(forward, {0.3f, 0.5f, 0.8f}), {1.0f, 0.0f, 0.0f});
  const Vec3 right = unitOr(cross(forward, up), fallback);
  const std::array<Vec3, 3> axes{right, cross(right, forward), -1.0f * forward};
  Mat4 view;
  for (std::size_t row = 0; row < 3; ++row) {
    view.at(row, 0) = axes[row].x;
    view.at(row, 1) = axes[row].y;
    view.at(row, 2) = axes[row].z;
    view.at(row, 3) = -dot(axes[row], eye);
  }
  view.at(3, 3) = 1.0f;
  return view;
}

/// Returns view to clip space with depth from 0 (near) to 1 (far).
inline Mat4 perspective(float verticalFieldOfView, float aspect, float zNear, float zFar) {
  const float scale = 1.0f / std::tan(0.5f * verticalFieldOfView);
  Mat4 clip;
  clip.at(0, 0) = scale / aspect;
  clip.at(1, 1) = scale;
  clip.at(2, 2) = zFar / (zNear - zFar);
  clip.at(2, 3) = zNear * zFar / (zNear - zFar);
  clip.at(3, 2) = -1.0f;
  return clip;
}

}  // namespace limber::render

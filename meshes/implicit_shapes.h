// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace shapes {

/// About the distance to a surface, metres: below 0 inside the body, above 0 outside.
using Field = std::function<double(const Eigen::Vector3d&)>;

/// A point of a line and the radius of a tube around it, metres.
struct Joint {
  Eigen::Vector3d centre;
  double radius;
};

/// A ball drawn along a line; its radius changes evenly between the joints.
Field limb(const std::vector<Joint>& joints);

/// `tilt` rotates the ellipsoid about its own x, then y, then z axis, degrees. The distance is a bound, exact
/// near the surface (I. Quilez).
Field ellipsoid(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii,
                const Eigen::Vector3d& tilt = Eigen::Vector3d::Zero());

/// What lies behind the plane through `point`; `normal` is a unit vector.
Field halfSpace(const Eigen::Vector3d& point, const Eigen::Vector3d& normal);

/// The bodies together. They melt into each other over `blend`, metres.
Field unite(const std::vector<Field>& bodies, double blend);

/// What lies in both, with an edge rounded over `blend`, metres.
Field intersect(const Field& a, const Field& b, double blend);

/// What does not lie in the body.
Field outside(const Field& body);

/// The half with x >= 0, and its mirror image.
Field mirrorX(const Field& half);

/// By central differences.
Eigen::Vector3d gradient(const Field& field, const Eigen::Vector3d& p);

/// One step of Newton's method along the gradient, towards the surface.
Eigen::Vector3d towardsSurface(const Field& field, const Eigen::Vector3d& p);

}  // namespace shapes

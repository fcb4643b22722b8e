// SPDX-License-Identifier: Zlib
#include "scenes/end_checks.h"

#include "scenes/shape_error.h"
#include "scenes/timeline.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace limber::scenes {
namespace {

std::string text(const char* format, double value, double limit) {
  char line[160];
  std::snprintf(line, sizeof line, format, value, limit);
  return line;
}

std::string pointName(std::size_t body, std::uint32_t point) {
  return "point " + std::to_string(point) + " of body " + std::to_string(body);
}

std::string bodyName(std::size_t body) { return "body " + std::to_string(body); }

/// The first reason that `reason(body, point)` gives, with the point's name before it.
template <class Reason>
std::string anyPoint(const Scene& scene, Reason reason) {
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    const SoftBody& body = *scene.soft->body(b);
    for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
      const std::string why = reason(body, i);
      if (!why.empty()) return pointName(b, i) + why;
    }
  }
  return {};
}

/// The first reason that `reason(b, body)` gives, with the body's name before it.
template <class Reason>
std::string anyBody(const Scene& scene, Reason reason) {
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    const std::string why = reason(b, *scene.soft->body(b));
    if (!why.empty()) return bodyName(b) + why;
  }
  return {};
}

std::string whyNotCalm(double motion, double metres) {
  if (motion <= metres) return {};
  if (std::isinf(motion)) return " is not calm: it has not been watched for long enough, or is not finite";
  return text(" is not calm: a point moved %.4g m of late, allowed is %.4g m", motion, metres);
}

/// s, that RestWatch looks back at least.
constexpr double kWatched = double(RestWatch::kWindowTicks) / double(kTicksPerSecond);

/// m/s, root mean square: what is left of the points' velocities once the rigid motion is taken off that has
/// the body's momentum and angular momentum.
double deformationSpeed(const SoftBody& body) {
  const Eigen::Vector3d center = body.centerOfMass(), momentum = body.linearMomentum();
  const double mass = body.totalMass();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
    const Eigen::Vector3d r = body.position(i) - center;
    inertia += mass * body.network().massFractions[i] *
               (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Eigen::Vector3d spin = body.angularMomentum() - center.cross(momentum);
  const double rigid = 0.5 * momentum.squaredNorm() / mass +
                       0.5 * spin.dot(inertia.completeOrthogonalDecomposition().solve(spin));
  return std::sqrt(2.0 * std::max(0.0, body.kineticEnergy() - rigid) / mass);
}

double largestStretch(const SoftBody& body) {
  const std::vector<Eigen::Vector3d> rest = restShape(body);
  double largest = 0.0;
  for (const NetworkSpring& spring : body.network().springs) {
    if (spring.kind != SpringKind::Structural) continue;
    const double restLength = (rest[spring.b] - rest[spring.a]).norm();
    const double length = (body.position(spring.b) - body.position(spring.a)).norm();
    largest = std::max(largest, length / restLength - 1.0);
  }
  return largest;
}

}  // namespace

std::string checkFinite(const Scene& scene) {
  return anyPoint(scene, [](const SoftBody& body, std::uint32_t i) {
    return body.position(i).allFinite() ? std::string()
                                        : std::string(" is nowhere: its position is not finite");
  });
}

std::string checkAboveFloor(const Scene& scene) {
  return anyPoint(scene, [](const SoftBody& body, std::uint32_t i) {
    const double radius = pointRadius(body.network(), body.settings());
    const double y = body.position(i).y();
    return y >= -radius ? std::string() : text(" is %.4g m below the floor, allowed is %.4g m", -y, radius);
  });
}

Check checkCalm(double metres) {
  return [metres](const Scene& scene) {
    return anyBody(scene, [&](std::size_t b, const SoftBody&) {
      return whyNotCalm(scene.watch.largestMotion(b), metres);
    });
  };
}

Check checkCalmOrRolling(double metres) {
  return [metres](const Scene& scene) {
    return anyBody(scene, [&](std::size_t b, const SoftBody& body) {
      const double motion = scene.watch.largestMotion(b);
      const double falling = std::abs(body.linearMomentum().y()) / body.totalMass();
      const bool rolls = std::isfinite(motion) && (deformationSpeed(body) + falling) * kWatched <= metres;
      return rolls ? std::string() : whyNotCalm(motion, metres);
    });
  };
}

std::string checkAsleep(const Scene& scene) {
  return anyBody(scene, [](std::size_t, const SoftBody& body) {
    return body.sleeping() ? std::string() : std::string(" is still awake");
  });
}

Check checkShapes(double relative) {
  return [relative](const Scene& scene) {
    return anyBody(scene, [relative](std::size_t, const SoftBody& body) {
      const ShapeError error = shapeError(body);
      if (error.mirrored) return std::string(" is inside out");
      return error.relativeRms <= relative
                 ? std::string()
                 : text(" has lost its shape: off by %.3g %% of its size, allowed is %.3g %%",
                        100.0 * error.relativeRms, 100.0 * relative);
    });
  };
}

Check checkStretch(double relative) {
  return [relative](const Scene& scene) {
    return anyBody(scene, [relative](std::size_t, const SoftBody& body) {
      const double stretch = largestStretch(body);
      return stretch <= relative
                 ? std::string()
                 : text(" is stretched by %.3g %%, allowed is %.3g %%", 100.0 * stretch, 100.0 * relative);
    });
  };
}

Check checkOutsideBall(const Eigen::Vector3d& centre, double radius, double metres) {
  return [=](const Scene& scene) {
    return anyPoint(scene, [&](const SoftBody& body, std::uint32_t i) {
      const double depth = radius - (body.position(i) - centre).norm();
      return depth <= metres ? std::string()
                             : text(" is %.4g m inside the sphere, allowed is %.4g m", depth, metres);
    });
  };
}

}  // namespace limber::scenes

// SPDX-License-Identifier: Zlib
#include "scenes/end_checks.h"

#include "scenes/shape_error.h"

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
      const double motion = scene.watch.largestMotion(b);
      return motion <= metres
                 ? std::string()
                 : text(" is not calm: a point moved %.4g m of late, allowed is %.4g m", motion, metres);
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

// SPDX-License-Identifier: Zlib
#include "scenes/end_checks.h"

#include "scenes/overlap.h"
#include "scenes/scene.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace limber::scenes {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Eigen::Vector3d meanOf(const Points& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

Eigen::Matrix3d correlation(const Points& rest, const Points& now) {
  const Eigen::Vector3d restMean = meanOf(rest);
  const Eigen::Vector3d nowMean = meanOf(now);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < rest.size(); ++i) sum += (now[i] - nowMean) * (rest[i] - restMean).transpose();
  return sum;
}

double rmsAfter(const Eigen::Matrix3d& rotation, const Points& rest, const Points& now) {
  const Eigen::Vector3d restMean = meanOf(rest);
  const Eigen::Vector3d nowMean = meanOf(now);
  double sum = 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    sum += (now[i] - nowMean - rotation * (rest[i] - restMean)).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(rest.size()));
}

}  // namespace

double sizeOf(const Points& points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  return box.sizes().maxCoeff();
}

ShapeError shapeError(const Points& rest, const Points& now) {
  const Eigen::Matrix3d c = correlation(rest, now);
  if (!c.allFinite()) return {std::numeric_limits<double>::infinity(), false};
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(c, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // R = U diag(1, 1, d) V^T with d = det(U V^T) maximises trace(R^T C) over rotations
  const double handedness = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d signs(1.0, 1.0, handedness);
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return {rmsAfter(rotation, rest, now) / sizeOf(rest), handedness < 0.0};
}

Points restShape(const SoftBody& body) {
  Points rest = body.network().restPoints;
  for (Eigen::Vector3d& p : rest) p = p.cwiseProduct(body.settings().scale);
  return rest;
}

ShapeError shapeError(const SoftBody& body) {
  Points now;
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) now.push_back(body.position(i));
  return shapeError(restShape(body), now);
}

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

/// Returns the first non-empty result of `reason(body, point)`, after the name of the point.
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

/// Returns the first non-empty result of `reason(b, body)`, after the name of the body.
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
  if (std::isinf(motion))
    return " is not calm: the run was too short to tell (half a second at least), or it is not finite";
  return text(" is not calm: a point moved %.4g m of late, allowed is %.4g m", motion, metres);
}

/// Shortest time that RestWatch covers, s.
constexpr double kWatched = double(RestWatch::kWindowTicks) / double(kTicksPerSecond);

/// Returns the root mean square of the points' velocities, m/s, without the rigid motion that has the body's
/// momentum and angular momentum.
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

Check checkShapes(double relative, const std::string& remedy) {
  return [=](const Scene& scene) {
    return anyBody(scene, [&](std::size_t, const SoftBody& body) {
      if (body.network().kind != NetworkKind::Solid) return std::string();
      const ShapeError error = shapeError(body);
      if (error.mirrored) return std::string(" is inside out");
      return error.relativeRms <= relative
                 ? std::string()
                 : text(" has lost its shape: off by %.3g %% of its size, allowed is %.3g %%",
                        100.0 * error.relativeRms, 100.0 * relative) +
                       remedy;
    });
  };
}

Check checkWithin(double metres) {
  return [metres](const Scene& scene) {
    return anyPoint(scene, [metres](const SoftBody& body, std::uint32_t i) {
      const double distance = body.position(i).norm();
      return distance <= metres
                 ? std::string()
                 : text(" has flown away: it is %.3g m off, allowed is %.3g m", distance, metres);
    });
  };
}

namespace {

/// Drawn edges shorter than this fraction of the body are too short for the rounding of floats.
constexpr float kShortestEdge = 1e-4f;

/// Returns the largest length of a drawn edge over its length at rest.
double largestDrawnStretch(const SoftBody& body) {
  const RenderSurface& surface = body.network().render;
  if (surface.triangles.empty()) return 1.0;
  const Points restPoints = restShape(body);
  std::vector<Eigen::Vector3f> rest, now(body.skinnedPointCount());
  for (const Eigen::Vector3d& p : restPoints) rest.push_back(p.cast<float>());
  if (surface.skin.size() > 0) {
    std::vector<Eigen::Vector3f> skinned(surface.skin.size());
    applySkin(surface.skin, rest.front().data(), skinned.front().data());
    rest = std::move(skinned);
  }
  body.writeSkinnedPositions(now.front().data());
  const float shortest = kShortestEdge * static_cast<float>(sizeOf(restPoints));
  double largest = 1.0;
  for (const Triangle& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = surface.vertexToPoint[t[i]], b = surface.vertexToPoint[t[(i + 1) % 3]];
      const float restLength = (rest[a] - rest[b]).norm();
      if (restLength > shortest) largest = std::max(largest, double((now[a] - now[b]).norm() / restLength));
    }
  }
  return largest;
}

}  // namespace

Check checkSpikes(double factor) {
  return [factor](const Scene& scene) {
    return anyBody(scene, [factor](std::size_t, const SoftBody& body) {
      const double stretch = largestDrawnStretch(body);
      return stretch <= factor
                 ? std::string()
                 : text(" has spikes: a drawn edge is %.3g times as long as at rest, allowed is %.3g",
                        stretch, factor);
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

namespace {

std::vector<PosedSurface> surfacesOf(const Scene& scene, bool openOnes) {
  std::vector<PosedSurface> surfaces;
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    PosedSurface surface = posed(*scene.soft->body(b));
    if (surface.encloses || openOnes) surfaces.push_back(std::move(surface));
  }
  return surfaces;
}

std::string tooDeep(const RigidOverlap& overlap, const char* what, std::int64_t tick, double metres) {
  char text[160];
  std::snprintf(text, sizeof text,
                "body %zu and %s body %zu are %.3g m in one another at tick %lld, "
                "allowed is %.3g m",
                overlap.soft, what, overlap.rigid, overlap.depth, static_cast<long long>(tick), metres);
  return text;
}

/// The largest excess over the allowed depth so far.
struct Excess {
  RigidOverlap overlap;
  double allowed = 0.0;  // m
  std::int64_t tick = 0;
};

/// Returns the allowed depth. It is smaller for a small ball: that could pass through a sheet between two
/// ticks without a large depth.
double allowedFor(const btRigidBody& rigid, double metres) {
  constexpr double kShare = 0.3;  // of a ball's radius
  const btCollisionShape& shape = *rigid.getCollisionShape();
  if (shape.getShapeType() != SPHERE_SHAPE_PROXYTYPE) return metres;
  return std::min(metres, kShare * double(static_cast<const btSphereShape&>(shape).getRadius()));
}

}  // namespace

Check checkSoftApart(double metres) {
  return [metres](const Scene& scene) {
    const Overlap overlap = deepestOverlap(surfacesOf(scene, false));
    if (overlap.depth <= metres) return std::string();
    char text[160];
    std::snprintf(text, sizeof text, "body %zu is %.3g m deep in body %zu, allowed is %.3g m", overlap.inner,
                  overlap.depth, overlap.outer, metres);
    return std::string(text);
  };
}

Check checkRigidApart(double metres) {
  return [metres](const Scene& scene) {
    const std::vector<PosedSurface> softs = surfacesOf(scene, true);
    const RigidOverlap still = deepestOverlap(softs, scene.world->statics),
                       moving = deepestOverlap(softs, scene.world->movables);
    if (still.depth > metres) return tooDeep(still, "static", scene.ticks, metres);
    return moving.depth > metres ? tooDeep(moving, "moving", scene.ticks, metres) : std::string();
  };
}

void watchMovablesApart(Scene& scene, double metres) {
  const auto worst = std::make_shared<Excess>();
  scene.afterTick = [worst, metres](Scene& now) {
    const std::vector<PosedSurface> softs = surfacesOf(now, true);
    for (std::size_t r = 0; r < now.world->movables.size(); ++r) {
      RigidOverlap overlap = deepestOverlap(softs, *now.world->movables[r]);
      overlap.rigid = r;
      const double allowed = allowedFor(*now.world->movables[r], metres);
      if (overlap.depth - allowed > worst->overlap.depth - worst->allowed)
        *worst = {overlap, allowed, now.ticks};
    }
  };
  scene.endChecks.push_back([worst](const Scene&) {
    return worst->overlap.depth > worst->allowed
               ? tooDeep(worst->overlap, "moving", worst->tick, worst->allowed)
               : std::string();
  });
}

Check checkMovablesCalm(double speed) {
  return [speed](const Scene& scene) {
    for (std::size_t i = 0; i < scene.world->movables.size(); ++i) {
      const btRigidBody& body = *scene.world->movables[i];
      const double now = double(body.getLinearVelocity().length());
      if (body.isKinematicObject() || now <= speed) continue;
      char text[120];
      std::snprintf(text, sizeof text, "moving body %zu is not calm: %.3g m/s, allowed is %.3g m/s", i, now,
                    speed);
      return std::string(text);
    }
    return std::string();
  };
}

Eigen::Vector3d middleOf(const SoftBody& body) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) sum += body.position(i);
  return sum / double(body.pointCount());
}

}  // namespace limber::scenes

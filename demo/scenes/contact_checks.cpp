// SPDX-License-Identifier: Zlib
#include "scenes/contact_checks.h"

#include "scenes/rigid_overlap.h"

#include <algorithm>
#include <cstdio>

namespace limber::scenes {
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

/// What was too deep by the most so far.
struct Excess {
  RigidOverlap overlap;
  double allowed = 0.0;  // m
  std::int64_t tick = 0;
};

/// A small ball could go through a sheet between two ticks without ever being deep in it.
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

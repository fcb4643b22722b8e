// SPDX-License-Identifier: Zlib
#include "scenes/contact_checks.h"

#include "scenes/rigid_overlap.h"

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
  struct Deepest {
    RigidOverlap overlap;
    std::int64_t tick = 0;
  };
  const auto deepest = std::make_shared<Deepest>();
  scene.afterTick = [deepest](Scene& now) {
    const RigidOverlap overlap = deepestOverlap(surfacesOf(now, true), now.world->movables);
    if (overlap.depth > deepest->overlap.depth) *deepest = {overlap, now.ticks};
  };
  scene.endChecks.push_back([deepest, metres](const Scene&) {
    return deepest->overlap.depth > metres ? tooDeep(deepest->overlap, "moving", deepest->tick, metres)
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

// SPDX-License-Identifier: Zlib

// This file joins soft bodies to each other and to the bones of characters.

#include "bullet/bullet_objects.h"
#include "bullet/soft_body_data.h"
#include "bullet/system_impl.h"

#include <limber/skeleton.h>
#include <limber/soft_body_system.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- welds -------------------------------------------------------------------------------------------------

namespace {

/// Two points to be joined.
struct WeldPair {
  std::uint32_t a, b;
};

/// Returns the pairs of each point of `a` and its nearest one of `b` within the distance.
std::vector<WeldPair> nearestPairs(const SoftBody& a, const SoftBody& b, double distance) {
  std::vector<WeldPair> pairs;
  for (std::uint32_t i = 0; i < a.pointCount(); ++i) {
    const Eigen::Vector3d from = a.position(i);
    WeldPair nearest{i, b.pointCount()};
    double least = distance;
    for (std::uint32_t j = 0; j < b.pointCount(); ++j)
      if (const double apart = (b.position(j) - from).norm(); apart <= least) {
        least = apart;
        nearest.b = j;
      }
    if (nearest.b < b.pointCount()) pairs.push_back(nearest);
  }
  return pairs;
}

}  // namespace

Result<std::vector<SpringConstraint*>> SoftBodySystem::weld(SoftBody* a, SoftBody* b, double distance,
                                                            const SpringSettings& settings) {
  if (!impl_->owns(a) || !impl_->owns(b))
    return Error{"a soft body is not, or no longer, one of this system"};
  if (a == b) return Error{"a soft body cannot be welded to itself"};
  if (!(distance > 0.0)) return Error{"the distance of a weld must be above 0"};
  const std::vector<WeldPair> pairs = nearestPairs(*a, *b, distance);
  if (pairs.empty()) return Error{"no points of the two bodies are within the distance"};
  std::vector<SpringConstraint*> springs;
  for (const WeldPair& pair : pairs) {
    const Result<SpringConstraint*> spring = addSpring({a->point(pair.a)}, {b->point(pair.b)}, settings);
    if (spring) {
      springs.push_back(*spring);
      continue;
    }
    for (SpringConstraint* added : springs) static_cast<void>(removeSpring(added));
    return Error{spring.error()};
  }
  return springs;
}

// --- skeletons ---------------------------------------------------------------------------------------------

namespace {

std::string checkBound(const SoftBody& body, const BoundPoint& bound, std::size_t bones) {
  if (bound.point >= body.pointCount()) return "there is no point " + std::to_string(bound.point);
  double sum = 0.0;
  for (const auto& [bone, weight] : bound.weights) {
    if (bone >= bones) return "there is no bone " + std::to_string(bone);
    if (!(weight >= 0.0)) return "a weight is not 0 or more";
    sum += weight;
  }
  return std::abs(sum - 1.0) < 1e-6 ? std::string() : "the weights do not sum to 1";
}

}  // namespace

Result<Skeleton> Skeleton::bind(SoftBody& body, const std::vector<BoundPoint>& points,
                                const std::vector<btTransform>& bones) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (const std::string reason = checkBound(body, points[i], bones.size()); !reason.empty())
      return Error{"bound point " + std::to_string(i) + ": " + reason};
  Skeleton skeleton;
  skeleton.body_ = body.handle();
  skeleton.bones_ = bones.size();
  for (const BoundPoint& bound : points) {
    if (Result<void> pinned = body.pin(bound.point); !pinned) return Error{pinned.error()};
    const btVector3 place = toBullet(body.position(bound.point));
    Follower follower{bound.point, {}};
    for (const auto& [bone, weight] : bound.weights)
      follower.parts.push_back({bone, static_cast<btScalar>(weight), bones[bone].inverse() * place});
    skeleton.followers_.push_back(std::move(follower));
  }
  return skeleton;
}

btVector3 Skeleton::placeOf(const Follower& follower, const std::vector<btTransform>& bones) {
  btVector3 place(0, 0, 0);
  for (const Part& part : follower.parts) place += part.weight * (bones[part.bone] * part.local);
  return place;
}

Result<void> Skeleton::moveTo(const std::vector<btTransform>& bones, bool teleport) {
  SoftBody* body = body_.get();
  if (!body) return Error{"the soft body of the skeleton has been destroyed"};
  if (bones.size() != bones_)
    return Error{std::to_string(bones.size()) + " bones, bound were " + std::to_string(bones_)};
  for (const Follower& follower : followers_) {
    const btVector3 place = placeOf(follower, bones);
    const Result<void> moved =
        teleport ? body->teleportPin(follower.point, place) : body->movePin(follower.point, place);
    if (!moved) return moved;
  }
  return {};
}

void Skeleton::release() {
  if (SoftBody* body = body_.get())
    for (const Follower& follower : followers_) static_cast<void>(body->unpin(follower.point));
  followers_.clear();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

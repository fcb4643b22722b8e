// SPDX-License-Identifier: Zlib

// This file joins soft bodies to rigid bodies, to each other and to the bones of characters.

#include "bullet/body_in_world.h"
#include "bullet/system_impl.h"

#include <limber/skeleton.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- attachments -------------------------------------------------------------------------------------------

namespace {

Error foreignBody() { return {"the soft body is not, or no longer, in this world"}; }

/// Returns whether a place is inside a convex shape, or one of a compound, by more than `depth` (m).
bool isInside(const btCollisionShape& shape, const btTransform& pose, const Eigen::Vector3d& place,
              double depth) {
  if (shape.isCompound()) {
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i)
      if (isInside(*compound.getChildShape(i), pose * compound.getChildTransform(i), place, depth))
        return true;
    return false;
  }
  if (!shape.isConvex()) return false;
  if (const std::optional<HeldPiece> solid = solidOf(shape, pose))
    return nearestOn(&*solid, &*solid + 1, place).height < -depth;
  HeldPoint nearest;
  return !findNearestOutside(static_cast<const btConvexShape&>(shape), pose, place, nearest);
}

/// Returns the points, sorted, that springs inside the body join to those of `points` that are inside, too: a
/// rope that is attached to the middle of a ball begins there.
std::shared_ptr<const std::vector<std::uint32_t>> pointsInside(const SoftBody& softBody,
                                                               const std::vector<std::uint32_t>& points,
                                                               const btRigidBody& body, double depth) {
  const auto isIn = [&](std::uint32_t point) {
    return body.getCollisionShape() &&
           isInside(*body.getCollisionShape(), body.getWorldTransform(), softBody.position(point), depth);
  };
  std::vector<std::uint32_t> inside;
  std::vector<bool> isFound(softBody.pointCount(), false);
  const auto take = [&](std::uint32_t point) {
    isFound[point] = isIn(point);
    if (isFound[point]) inside.push_back(point);
    return isFound[point];
  };
  bool grows = false;
  for (const std::uint32_t point : points) grows = take(point) || grows;
  while (grows) {
    grows = false;
    for (const NetworkSpring& spring : softBody.network().springs)
      if (isFound[spring.a] != isFound[spring.b])
        grows = take(isFound[spring.a] ? spring.b : spring.a) || grows;
  }
  std::sort(inside.begin(), inside.end());
  return std::make_shared<const std::vector<std::uint32_t>>(std::move(inside));
}

}  // namespace

Result<void> SoftBodySystem::Impl::checkAttachment(const SoftBody* softBody, const Anchor& anchor) const {
  if (!step->owns(softBody)) return foreignBody();
  SoftBodyData& data = *softBody->data_;
  if (!isAlive(data)) return notAlive();
  const std::uint32_t i = anchor.point;
  const btRigidBody& body = *anchor.body;
  const bool deleted = i < data.masses.bodies.size() && !data.masses.bodies[i];
  if (i >= softBody->pointCount() || deleted) return Error{"there is no point " + std::to_string(i)};
  if (isAttached(data, i)) return Error{"point " + std::to_string(i) + " is already attached"};
  if (softBody->pinned(i)) return Error{"point " + std::to_string(i) + " is pinned"};
  if (PointMass::from(&body) || SurfaceObject::from(&body))
    return Error{
        "a point can be attached to a rigid body only, not to a soft one: join two points by a spring"};
  if (isElsewhere(body, *world)) return Error{"the rigid body is in another world"};
  if (!isValidPivot(anchor.pivot)) return Error{"the pivot is not finite, or farther than 1e6"};
  if (!(anchor.breakForce >= 0.0 && anchor.breakForce <= 1e18))
    return Error{"breakForce must be from 0 to 1e18"};
  return {};
}

Result<void> SoftBodySystem::Impl::attach(SoftBody* softBody, std::vector<Anchor> anchors) {
  std::vector<std::uint32_t> points;
  for (const Anchor& anchor : anchors) {
    if (Result<void> valid = checkAttachment(softBody, anchor); !valid) return valid;
    if (std::find(points.begin(), points.end(), anchor.point) != points.end())
      return Error{"point " + std::to_string(anchor.point) + " is listed twice"};
    points.push_back(anchor.point);
  }
  if (anchors.empty()) return {};
  SoftBodyData& data = *softBody->data_;
  const auto inside = pointsInside(*softBody, points, *anchors.front().body, radiusOf(data));
  for (Anchor& anchor : anchors) {
    anchor.inside = inside;
    data.anchors.push_back(std::move(anchor));
  }
  softBody->wake();
  step->groupsStale = true;
  return {};
}

Result<void> SoftBodySystem::attach(SoftBody* softBody, std::uint32_t i, btRigidBody& body,
                                    const btVector3& pivot, double breakForce) {
  return impl_->attach(softBody, {Anchor{i, &body, pivot, breakForce}});
}

Result<void> SoftBodySystem::attach(SoftBody* softBody, std::uint32_t i, btRigidBody& body,
                                    double breakForce) {
  return attach(softBody, std::vector<std::uint32_t>{i}, body, breakForce);
}

Result<void> SoftBodySystem::attach(SoftBody* softBody, const std::vector<std::uint32_t>& points,
                                    btRigidBody& body, double breakForce) {
  if (!impl_->step->owns(softBody)) return foreignBody();
  std::vector<Anchor> anchors;
  for (const std::uint32_t i : points) {
    if (i >= softBody->pointCount()) return Error{"there is no point " + std::to_string(i)};
    // where the point is now
    const btVector3 pivot = body.getWorldTransform().inverse() * toBullet(softBody->position(i));
    anchors.push_back({i, &body, pivot, breakForce});
  }
  return impl_->attach(softBody, std::move(anchors));
}

Result<void> SoftBodySystem::detach(SoftBody* softBody, std::uint32_t i) {
  if (!impl_->step->owns(softBody)) return foreignBody();
  if (!impl_->detach(softBody, i)) return Error{"point " + std::to_string(i) + " is not attached"};
  return {};
}

bool SoftBodySystem::Impl::detach(SoftBody* softBody, std::uint32_t i) {
  std::vector<Anchor>& anchors = softBody->data_->anchors;
  const auto it = findAnchor(*softBody->data_, i);
  if (it == anchors.end()) return false;
  wakeAnchored(*softBody->data_, false);
  anchors.erase(it);
  softBody->data_->surface.freed = true;
  softBody->wake();
  step->forgetGroups();
  return true;
}

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
  if (!a->alive() || !b->alive()) return notAlive();
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

/// Radius of a back stop's sphere, times the maximum distance.
constexpr btScalar kStopRadius = 10;

std::string checkWeights(const BoundPoint& bound, std::size_t bones) {
  double sum = 0.0;
  for (const auto& [bone, weight] : bound.weights) {
    if (bone >= bones) return "there is no bone " + std::to_string(bone);
    if (!(weight >= 0.0)) return "a weight is not 0 or more";
    sum += weight;
  }
  return std::abs(sum - 1.0) < 1e-6 ? std::string() : "the weights do not sum to 1";
}

std::string checkBound(const SoftBody& body, const BoundPoint& bound, std::size_t bones) {
  if (!body.point(bound.point)) return "there is no point " + std::to_string(bound.point);
  if (!(bound.maxDistance >= 0.0 && bound.maxDistance <= 1e6)) return "maxDistance must be from 0 to 1e6";
  if (!(bound.backStop <= 1e6)) return "backStop must be at most 1e6";
  if (bound.backStop >= 0.0 && bound.maxDistance == 0.0) return "a back stop needs a maxDistance above 0";
  if (bound.backStop >= 0.0 && body.network().surface.empty()) return "a back stop needs a surface";
  return checkWeights(bound, bones);
}

/// Returns why the points cannot be bound; empty if they can.
std::string checkBound(const SoftBody& body, const std::vector<BoundPoint>& points, std::size_t bones) {
  std::vector<unsigned char> isBound(body.pointCount(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::string reason = checkBound(body, points[i], bones);
    if (reason.empty() && std::exchange(isBound[points[i].point], 1)) reason = "the point is bound twice";
    if (!reason.empty()) return "bound point " + std::to_string(i) + ": " + reason;
  }
  return {};
}

std::string checkBones(const std::vector<btTransform>& bones) {
  for (std::size_t b = 0; b < bones.size(); ++b)
    if (!(toEigen(bones[b].getOrigin()).norm() <= 1e6) || !toEigen(bones[b].getBasis()).allFinite())
      return "bone " + std::to_string(b) + " is not finite, or farther than 1e6 m";
  return {};
}

/// A bone that points are bound to must have an inverse.
std::string checkBoundBones(const std::vector<btTransform>& bones) {
  if (std::string reason = checkBones(bones); !reason.empty()) return reason;
  for (std::size_t b = 0; b < bones.size(); ++b)
    if (!(std::abs(double(bones[b].getBasis().determinant())) > 1e-9))
      return "bone " + std::to_string(b) + " has a basis without volume";
  return {};
}

/// Returns the normals (#points) of the present surface; 0 for points that are not on it.
std::vector<btVector3> pointNormals(const SoftBody& body) {
  std::vector<btVector3> normals(body.pointCount(), btVector3(0, 0, 0));
  const double outward = body.settings().scale.prod() < 0.0 ? -1.0 : 1.0;
  for (const Triangle& t : body.network().surface) {
    const Eigen::Vector3d a = body.position(t[0]);
    const btVector3 normal = toBullet(outward * (body.position(t[1]) - a).cross(body.position(t[2]) - a));
    for (const std::uint32_t point : t) normals[point] += normal;
  }
  for (btVector3& normal : normals)
    if (normal.length2() > btScalar(0)) normal.normalize();
  return normals;
}

/// Returns the spring that acts at and beyond a distance; critically damped with the point alone.
SpringSettings limitSettings(const SoftBody& body, std::uint32_t point, double distance) {
  SpringSettings settings;
  settings.stiffness = body.settings().extensionStiffness;
  settings.damping = 2.0 * std::sqrt(settings.stiffness * double(body.point(point)->getMass()));
  settings.restLength = distance;
  return settings;
}

}  // namespace

Skeleton::Follower Skeleton::follow(const SoftBody& body, const BoundPoint& bound, const btVector3& normal,
                                    const std::vector<btTransform>& bones) {
  const btVector3 place = toBullet(body.position(bound.point));
  Follower follower{bound.point, {}, btScalar(bound.maxDistance), btScalar(bound.backStop), place, {}, {}};
  for (const auto& [bone, weight] : bound.weights)
    follower.parts.push_back(
        {bone, static_cast<btScalar>(weight), bones[bone].invXform(place), normal * bones[bone].getBasis()});
  return follower;
}

/// Pins the point, or adds the springs that limit it.
Result<void> Skeleton::hold(Follower& follower, const std::vector<btTransform>& bones) {
  if (follower.maxDistance == btScalar(0)) return body_->pin(follower.point);
  const auto add = [&](Handle<SpringConstraint>& spring, const btVector3& end, btScalar distance,
                       SpringAction action) -> Result<void> {
    SpringSettings settings = limitSettings(*body_, follower.point, double(distance));
    settings.action = action;
    const auto added = system_->addSpring({body_->point(follower.point)}, {nullptr, end}, settings);
    if (!added) return Error{added.error()};
    spring = (*added)->handle();
    return {};
  };
  Result<void> limited =
      add(follower.limit, follower.place, follower.maxDistance, SpringAction::ExtensionOnly);
  if (!limited || follower.backStop < btScalar(0)) return limited;
  return add(follower.stop, stopOf(follower, bones), kStopRadius * follower.maxDistance,
             SpringAction::CompressionOnly);
}

Result<Skeleton> Skeleton::bind(SoftBodySystem& system, SoftBody& body, const std::vector<BoundPoint>& points,
                                const std::vector<btTransform>& bones) {
  if (std::string reason = checkBoundBones(bones); !reason.empty()) return Error{std::move(reason)};
  if (std::string reason = checkBound(body, points, bones.size()); !reason.empty())
    return Error{std::move(reason)};
  Skeleton skeleton;
  skeleton.system_ = &system;
  skeleton.body_ = body.handle();
  skeleton.bones_ = bones.size();
  const std::vector<btVector3> normals = pointNormals(body);
  for (const BoundPoint& bound : points) {
    skeleton.followers_.push_back(follow(body, bound, normals[bound.point], bones));
    if (Result<void> held = skeleton.hold(skeleton.followers_.back(), bones); !held) {
      skeleton.release();
      return Error{held.error()};
    }
  }
  return skeleton;
}

Skeleton& Skeleton::operator=(Skeleton&& other) noexcept {
  if (this == &other) return *this;
  removeSprings();
  system_ = other.system_;
  body_ = std::move(other.body_);
  bones_ = other.bones_;
  followers_ = std::move(other.followers_);
  return *this;
}

Skeleton::~Skeleton() { removeSprings(); }

/// Returns the centre of the sphere of the back stop.
btVector3 Skeleton::stopOf(const Follower& follower, const std::vector<btTransform>& bones) {
  btVector3 normal(0, 0, 0);
  for (const Part& part : follower.parts) normal += part.weight * (bones[part.bone].getBasis() * part.normal);
  const btScalar length = normal.length();
  const btScalar depth = kStopRadius * follower.maxDistance + follower.backStop;
  return follower.place - (length > btScalar(0) ? depth / length : btScalar(0)) * normal;
}

/// Moves the body by the rigid motion nearest to that of the places.
Result<void> Skeleton::teleportBody(const std::vector<btVector3>& to) {
  Eigen::Matrix3Xd before(3, to.size()), after(3, to.size());
  for (std::size_t i = 0; i < to.size(); ++i) {
    before.col(static_cast<Eigen::Index>(i)) = toEigen(followers_[i].place);
    after.col(static_cast<Eigen::Index>(i)) = toEigen(to[i]);
  }
  const Eigen::Isometry3d motion = rigidMotionBetween(before, after);
  const Eigen::Quaterniond turn(motion.rotation());
  return body_->setTransform(btTransform(toBullet(turn), toBullet(motion.translation())) *
                             body_->transform());
}

Result<void> Skeleton::moveTo(const std::vector<btTransform>& bones, bool teleport) {
  if (!body_) return Error{"the soft body of the skeleton has been destroyed"};
  if (bones.size() != bones_)
    return Error{std::to_string(bones.size()) + " bones, bound were " + std::to_string(bones_)};
  if (std::string reason = checkBones(bones); !reason.empty()) return Error{std::move(reason)};
  std::vector<btVector3> places;
  for (const Follower& follower : followers_) {
    btVector3& place = places.emplace_back(0, 0, 0);
    for (const Part& part : follower.parts) place += part.weight * (bones[part.bone] * part.place);
  }
  if (teleport && !followers_.empty())
    if (Result<void> moved = teleportBody(places); !moved) return moved;
  for (std::size_t i = 0; i < places.size(); ++i) followers_[i].place = places[i];
  body_->wake();
  for (const Follower& follower : followers_)
    if (Result<void> moved = carry(follower, bones, teleport); !moved) return moved;
  return {};
}

/// movePin() would wake the body with all its points for each pin; moveTo() does so once.
Result<void> Skeleton::carryPin(const Follower& follower, bool teleport) {
  if (teleport) return body_->teleportPin(follower.point, follower.place);
  if (!body_->alive() || !body_->pinned(follower.point))
    return body_->movePin(follower.point, follower.place);
  body_->point(follower.point)->getWorldTransform().setOrigin(follower.place);
  return {};
}

/// Moves the pin, or the springs' ends, to the place.
Result<void> Skeleton::carry(const Follower& follower, const std::vector<btTransform>& bones, bool teleport) {
  if (follower.maxDistance == btScalar(0)) return carryPin(follower, teleport);
  const auto move = [&](const Handle<SpringConstraint>& spring, const btVector3& end) -> Result<void> {
    if (!spring) return {};
    if (teleport) return system_->moveSpring(spring.get(), end);
    spring->target_ = end;
    return {};
  };
  Result<void> moved = move(follower.limit, follower.place);
  return moved ? move(follower.stop, stopOf(follower, bones)) : moved;
}

void Skeleton::removeSprings() {
  for (Follower& follower : followers_)
    for (const Handle<SpringConstraint>* spring : {&follower.limit, &follower.stop})
      if (*spring) static_cast<void>(system_->removeSpring(spring->get()));
}

void Skeleton::release() {
  removeSprings();
  for (const Follower& follower : followers_)
    if (body_ && body_->pinned(follower.point)) static_cast<void>(body_->unpin(follower.point));
  followers_.clear();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

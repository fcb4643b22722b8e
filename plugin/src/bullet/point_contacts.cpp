// SPDX-License-Identifier: Zlib

// This file finds the contacts of points with static and kinematic objects in a tick: first the objects near
// a body, then contacts for each point, and within the tick contacts for points that leave their search
// region. It gets bodies out of solids into which they have been placed.

#include "bullet/point_contacts.h"
#include "bullet/contact_report.h"
#include "bullet/kinematic_motion.h"
#include "bullet/tick_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

void forgetPartners(SoftBodyData& body) {
  body.heldPartners.clear();
  body.freePartners.clear();
  body.softPartners.clear();
}

/// Returns whether part of the box is below a plane's surface or within its margin. A plane's own box is
/// infinite.
bool reachesPlane(const Eigen::AlignedBox3d& box, const btCollisionObject& object) {
  const auto& plane = static_cast<const btStaticPlaneShape&>(*object.getCollisionShape());
  const btTransform& pose = object.getWorldTransform();
  const Eigen::Vector3d normal = toEigen(pose.getBasis() * plane.getPlaneNormal());
  const double offset = double(plane.getPlaneConstant()) + normal.dot(toEigen(pose.getOrigin()));
  const double lowest = normal.dot(box.center()) - 0.5 * normal.cwiseAbs().dot(box.sizes());
  return lowest <= offset + double(plane.getMargin());
}

/// Returns whether the shape of a partner at rest overlaps the box (m). The broadphase boxes are not used:
/// their margins do not scale with the scene, and must not affect how a body is stepped.
bool isIn(const Eigen::AlignedBox3d& box, const btCollisionObject& partner) {
  return isPlane(partner) ? reachesPlane(box, partner) : box.intersects(boxOf(partner));
}

/// Returns whether a held object may enter the box (m) in the tick.
bool mayEnter(const Eigen::AlignedBox3d& box, const btCollisionObject& held) {
  return isMoved(held) || isIn(box, held);
}

/// Returns whether an object may enter the box (m) in the tick.
bool hasPartnersIn(const Eigen::AlignedBox3d& box, const SoftBodyData& body) {
  const auto held = [&](const HeldPartner& p) { return mayEnter(box, p.object()); };
  const auto soft = [&](const SoftBodyData* other) { return box.intersects(presentBoundsOf(*other)); };
  return !body.freePartners.empty() ||
         std::any_of(body.softPartners.begin(), body.softPartners.end(), soft) ||
         std::any_of(body.heldPartners.begin(), body.heldPartners.end(), held);
}

template <class T>
void addOnce(std::vector<T>& list, T entry) {
  if (std::find(list.begin(), list.end(), entry) == list.end()) list.push_back(entry);
}

/// Adds a static or kinematic object, which describePartner() completes.
void addHeld(SoftBodyData& body, const btCollisionObject& object) {
  const auto isThis = [&](const HeldPartner& held) { return held.handle.object == &object; };
  if (std::none_of(body.heldPartners.begin(), body.heldPartners.end(), isThis))
    body.heldPartners.emplace_back().handle = handleOf(object);
}

/// Adds the object to the list of its kind. Contacts between point masses of different bodies are in
/// world_points.cpp. Rigid bodies that are too far away are left out, as the broadphase finds some of them
/// and others not: which ones depends on earlier ticks.
void addPartner(SoftBodyData& body, btCollisionObject& object, double tick) {
  if (PointMass::from(&object)) return;
  if (SurfaceObject* surface = SurfaceObject::from(&object)) {
    SoftBodyData* owner = surface->owner();
    if (isSurfaceBody(body) && owner && owner->alive) addOnce(body.softPartners, owner);
  } else if (isStaticOrKinematic(object)) {
    addHeld(body, object);
  } else if (const btMultiBodyLinkCollider* link = btMultiBodyLinkCollider::upcast(&object)) {
    if (isHeldLink(*link))
      addHeld(body, object);
    else
      addOnce<btRigidBody*>(body.freePartners, &body.links->bodyOf(*link));
  } else if (btRigidBody* rigid = btRigidBody::upcast(&object)) {
    if (!isSurfaceBody(body) || body.surface.presentBounds.box.intersects(boundsOf(*rigid, tick)))
      addOnce(body.freePartners, rigid);
  }
}

ContactSpeeds contactSpeeds(const SoftBodyData& body, double tick) {
  const double gravity = toEigen(body.world->getGravity()).norm();
  // a speed that gravity gives in a tenth of a tick is no bounce
  return {recoverySpeed(radiusOf(body), gravity, tick), 0.1 * gravity * tick};
}

/// Returns the box around the search regions of all points, and stores their search distances.
Eigen::AlignedBox3d searchBox(SoftBodyData& body, double tick) {
  Eigen::AlignedBox3d box;
  body.searchDistance.resize(pointCount(body));
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i) {
    const SearchRegion searchRegion = searchRegionOf(body, i, tick);
    body.searchDistance[static_cast<std::size_t>(i)] = searchRegion.distance;
    box.extend(searchRegion.box);
  }
  return box;
}

/// Moves the objects that Bullet's broadphase found around a surface body, and those that approach any body,
/// to the lists of partners.
void takePartners(SoftBodyData& body, double tick) {
  const SurfaceObject* own = body.surface.object;
  body.sensors.clear();
  for (btCollisionObject* partner : body.surface.partners)
    if (!addSensor(body, *partner) && partner->hasContactResponse() && (!own || own->mayTouch(*partner)))
      addPartner(body, *partner, tick);
  body.surface.partners.clear();
}

/// Returns whether no object can enter the swept bounds of a body in this tick. Then its points move freely.
bool nothingIsNear(SoftBodyData& body, double tick) {
  const SweptBounds& bounds = body.surface.presentBounds;
  const bool wasPredicted = !body.masses.exposed && body.surface.sweptBounds.tick == tick;
  if (hasPartnersIn(bounds.box, body) || (!wasPredicted && !partnersCover(body, bounds.box))) return false;
  forgetPartners(body);
  body.searchDistance.assign(pointCount(body), bounds.maxDisplacement);
  return true;
}

void sortHeld(SoftBodyData& body, std::size_t first = 0) {
  std::sort(body.heldPartners.begin() + static_cast<std::ptrdiff_t>(first), body.heldPartners.end(),
            [](const HeldPartner& a, const HeldPartner& b) { return a.handle.id < b.handle.id; });
}

void queryPartners(SoftBodyData& body, const Eigen::AlignedBox3d& box, double tick) {
  forEachObjectIn(*body.world, box, [&](btCollisionObject& object) {
    if (canHit(body, object)) addPartner(body, object, tick);
  });
  sortHeld(body);
  std::sort(body.freePartners.begin(), body.freePartners.end(),
            [](const btRigidBody* a, const btRigidBody* b) {
              return hasSmallerId(&objectInWorld(*a), &objectInWorld(*b));
            });
}

void describePartner(SoftBodyData& body, HeldPartner& held) {
  held.box = boxOf(held.object());
  held.came =
      std::none_of(body.lastHeldPartners.begin(), body.lastHeldPartners.end(), [&](const HeldPartner& last) {
        return last.handle.object == held.handle.object && last.handle.id == held.handle.id &&
               last.box.min() == held.box.min() && last.box.max() == held.box.max();
      });
  if (isMoved(held.object())) {
    held.stamp = stampOf(held.object());
  } else if (const std::optional<HeldPiece> solid = solidOf(held.object())) {
    held.solid = body.held.pieces.size();
    body.held.pieces.push_back(*solid);
  }
}

/// Returns whether a body has static or kinematic partners in a box, and adds the new ones.
bool addStaticPartners(SoftBodyData& body, const Eigen::AlignedBox3d& box) {
  const std::size_t known = body.heldPartners.size();
  bool any = false;
  forEachObjectIn(*body.world, box, [&](const btCollisionObject& object) {
    if (isSoft(&object) || !isStaticOrKinematic(object) || !canHit(body, object)) return;
    any = true;
    addHeld(body, object);
  });
  sortHeld(body, known);
  for (std::size_t p = known; p < body.heldPartners.size(); ++p) describePartner(body, body.heldPartners[p]);
  return any;
}

/// Finds contacts of points that are about to leave their search region, from their present positions. These
/// contacts are separate from the body's until the tick ends, because contacts between bodies point to those.
class Watch final : public SearchWatch {
 public:
  explicit Watch(SoftBodyData& body) : body_(&body) {}

  void start(btScalar tick) override {
    tick_ = tick;
    on = false;
    hasRegions_ = false;
    rows.clear();
  }

  Regions regions() const override {
    if (hasRegions_) return {&centers_, &distances_};
    return {&body_->masses.startPosition, &body_->searchDistance};
  }

  void setRegion(std::uint32_t i, const Eigen::Vector3d& center, double distance) override {
    if (!hasRegions_) centers_ = body_->masses.startPosition, distances_ = body_->searchDistance;
    hasRegions_ = true;
    centers_.col(i) = center;
    distances_[i] = distance;
  }

  bool anyLeaves(const PointView& points, double dt, std::uint32_t begin, std::uint32_t end) const override {
    for (std::uint32_t i = begin; i < end; ++i)
      if (leaves(points, dt, i)) return true;
    return false;
  }

  void look(const PointView& points, double time, double dt) override {
    bool found = false;
    for (std::uint32_t i = 0; i < pointCount(*body_); ++i) {
      if (!leaves(points, dt, i)) continue;
      search(i, points.positionOf(i), points.velocityOf(i), time, dt);
      found = true;
    }
    if (found) prepareContacts(rows, points);
  }

  void merge() override {
    std::vector<PlaneContact>& own = body_->contacts;
    for (const PlaneContact& row : rows)
      own.insert(std::upper_bound(own.begin(), own.end(), row.point, isBefore), row);
    rows.clear();
  }

 private:
  bool leaves(const PointView& points, double dt, std::uint32_t i) const {
    const Eigen::Vector3d next = points.positionOf(i) + dt * points.velocityOf(i);
    const auto& [centers, distances] = regions();
    const double distance = (*distances)[i];
    return (next - centers->col(i)).squaredNorm() > distance * distance && !body_->masses.held[i];
  }

  static bool isBefore(std::uint32_t point, const PlaneContact& row) { return point < row.point; }

  /// Searches from x, for the rest of the tick.
  void search(std::uint32_t i, const Eigen::Vector3d& x, const Eigen::Vector3d& v, double time, double dt) {
    const double remaining = double(tick_) - time;
    body_->state.position.col(i) = x;
    const PieceRange left = leavePieces(i);
    const SearchRegion searchRegion = searchRegionFrom(*body_, i, v, remaining);
    addStaticPartners(*body_, searchRegion.box);
    found_.clear();
    // the gather functions add to the body's contacts
    std::swap(body_->contacts, found_);
    // those that an implicit step has found are merged with the body's
    setRegion(i, x, addStaticRows(*body_, i, {v, remaining, dt, !body_->prefersImplicit}, tick_));
    reuse(left);
    for (std::uint32_t p = 0; p < body_->heldPartners.size(); ++p) {
      // kinematic objects are at their pose of the start of the tick: shift the point to the same position
      // relative to them
      const btCollisionObject& partner = body_->heldPartners[p].object();
      body_->state.position.col(i) = x - time / double(tick_) * kinematicDisplacement(partner, x);
      addRows(*body_, i, p, v, remaining, tick_);
    }
    std::swap(body_->contacts, found_);
    body_->state.position.col(i) = x;
    if (isFiltered(*body_)) filterPlanes(*body_, found_, nullptr);
    replaceRows(i);
    const double covered = (x - body_->masses.startPosition.col(i)).norm() + searchRegion.distance;
    body_->searchDistance[i] = std::max(body_->searchDistance[i], covered);
  }

  using PieceRange = std::pair<std::size_t, std::size_t>;  // begin and end in SoftBodyData::held

  /// Where there are many pieces, ends contacts of the point's earlier searches that follow them: the next
  /// search finds those nearby. Returns the most pieces that such a contact followed.
  PieceRange leavePieces(std::uint32_t i) {
    PieceRange left;
    if (body_->held.maxSearchDistance == HUGE_VAL) return left;
    for (std::vector<PlaneContact>* contacts : {&body_->contacts, &rows}) {
      const ContactRange old = contactsOfPoint(*contacts, i);
      for (std::size_t r = old.begin; r < old.end; ++r) {
        HeldNeighbourhood* around = (*contacts)[r].around;
        if (!around || around->end - around->begin < 2) continue;  // all points share a single solid
        if (around->end - around->begin > left.second - left.first) left = {around->begin, around->end};
        around->end = around->begin;
      }
    }
    return left;
  }

  /// Moves the pieces that a search has added to the place of those that the point has left.
  void reuse(const PieceRange& left) {
    std::vector<HeldPiece>& pieces = body_->held.pieces;
    HeldNeighbourhood* around = body_->contacts.empty() ? nullptr : body_->contacts.back().around;
    if (!around || around->end != pieces.size() || around->end - around->begin > left.second - left.first)
      return;
    const auto first = pieces.begin() + static_cast<std::ptrdiff_t>(around->begin);
    std::copy(first, pieces.end(), pieces.begin() + static_cast<std::ptrdiff_t>(left.first));
    pieces.erase(first, pieces.end());
    around->end = left.first + (around->end - around->begin);
    around->begin = left.first;
  }

  /// Adds the impulse of an earlier contact to that of a new one, or keeps it for the report.
  void keepImpulse(const PlaneContact& old) {
    const auto isSame = [&](const PlaneContact& row) { return row.partner == old.partner; };
    const auto row = std::find_if(found_.begin(), found_.end(), isSame);
    if (row != found_.end()) {
      row->impulse += old.impulse;
    } else if (!old.impulse.sum.isZero(0.0)) {
      found_.push_back(old);
      found_.back().around = nullptr;
      found_.back().away = true;
    }
  }

  /// Replaces the point's earlier contacts by the new ones, which get their impulses.
  void replaceRows(std::uint32_t i) {
    const ContactRange old = contactsOfPoint(rows, i);
    for (std::size_t r = old.begin; r < old.end; ++r) keepImpulse(rows[r]);
    const auto first = rows.begin() + static_cast<std::ptrdiff_t>(old.begin);
    const auto next = rows.erase(first, first + static_cast<std::ptrdiff_t>(old.end - old.begin));
    rows.insert(next, found_.begin(), found_.end());
  }

  SoftBodyData* body_;
  btScalar tick_ = 0;
  bool hasRegions_ = false;          // of this tick
  Points centers_;                   // 3 x #points, m
  std::vector<double> distances_;    // #points, m
  std::vector<PlaneContact> found_;  // scratch
};

bool turns(const btCollisionObject& object) {
  return isMoved(object) &&
         !(object.getWorldTransform().getBasis() == object.getInterpolationWorldTransform().getBasis());
}

/// Sets the spins of a body: of each point the rigid rotation w that fits the velocities of its neighbours
/// along springs best. With their offsets d and relative velocities v,  sum |v - w x d|^2  is least for
///     (sum |d|^2 - d d^T) w = sum d x v.
/// About the direction of a rope it is not determined, and 0.
void findLocalSpins(SoftBodyData& body) {
  constexpr double kUndetermined = 1e-9;
  LocalSpins& local = body.localSpins;
  local.spins.setZero(3, body.state.position.cols());
  local.inertias.assign(pointCount(body), Eigen::Matrix3d::Zero());
  for (const NetworkSpring& s : body.model->network->springs) {
    const Eigen::Vector3d d = body.state.position.col(s.b) - body.state.position.col(s.a);
    const Eigen::Vector3d moment = d.cross(body.state.velocity.col(s.b) - body.state.velocity.col(s.a));
    const Eigen::Matrix3d inertia = d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose();
    for (const std::uint32_t i : {s.a, s.b}) local.spins.col(i) += moment, local.inertias[i] += inertia;
  }
  for (std::uint32_t i = 0; i < pointCount(body); ++i) {
    Eigen::Matrix3d& inertia = local.inertias[i];
    const double size = inertia.trace();
    if (!(size > 0.0)) continue;
    inertia.diagonal().array() += kUndetermined * size;
    local.spins.col(i) = inertia.inverse() * local.spins.col(i);
  }
}

}  // namespace

double turningShare(const Eigen::Vector3d& own, const Eigen::Vector3d& spin, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d across = spin - normal.dot(spin) * normal;
  const double squared = across.squaredNorm();
  return squared > 0.0 ? std::clamp(own.dot(across) / squared, -1.0, 1.0) : 0.0;
}

Eigen::AlignedBox3d boundsOf(const btRigidBody& rigid, double tick) {
  Eigen::AlignedBox3d box = boxOf(rigid);
  const Eigen::Vector3d motion =
      kSearchPerMotion * (tick * toEigen(rigid.getLinearVelocity()) + fallOf(rigid, tick));
  const double rotation = kSearchPerMotion * tick * double(rotationSpeed(rigid));
  box.extend(box.min() + motion.cwiseMin(0.0)).extend(box.max() + motion.cwiseMax(0.0));
  return {box.min().array() - rotation, box.max().array() + rotation};
}

// --- bodies that have been placed into solids --------------------------------------------------------------

// A body gets out of a solid at rest by moving all points along one direction, since the nearest faces would
// push different points to different sides. Points on the far side of a thin solid pass through it on their
// way.

namespace {

HeldPoint nearestOnSolid(const SoftBodyData& body, const HeldPartner& held, std::uint32_t i) {
  const HeldPiece* piece = body.held.pieces.data() + held.solid;
  return nearestOn(piece, piece + 1, body.state.position.col(i));
}

/// Returns the place between two at which the height over a solid, a convex function, is least.
Eigen::Vector3d deepestBetween(const HeldPiece& solid, Eigen::Vector3d from, Eigen::Vector3d to) {
  constexpr int kSteps = 24;  // to 6e-5 of the distance
  const auto heightAt = [&](const Eigen::Vector3d& x) { return nearestOn(&solid, &solid + 1, x).height; };
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Vector3d third = (to - from) / 3.0;
    if (heightAt(from + third) < heightAt(to - third))
      to -= third;
    else
      from += third;
  }
  return 0.5 * (from + to);
}

/// Whether the place is in the body. Its boxes are fitted.
bool isInBody(const SoftBodyData& body, const Eigen::Vector3d& place, double depth) {
  const NearestOnSurface nearest = nearestOnSurface(body.surface.moving, place, HUGE_VAL);
  return nearest.behind && nearest.distance > depth;
}

/// Whether an edge of the body's surface passes from one side of a solid to the other, somewhere deeper in it
/// than `deepest` (m, below 0). One that lies on a round solid is between ends on the same side.
bool passesThrough(const SoftBodyData& body, const HeldPartner& held, const Edge& edge, double deepest) {
  const auto [a, b] = edge;
  const Eigen::Vector3d from = body.state.position.col(a), to = body.state.position.col(b);
  const HeldPoint atA = nearestOnSolid(body, held, a), atB = nearestOnSolid(body, held, b);
  // no height changes by more than the distance
  if (!(0.5 * (atA.height + atB.height - (to - from).norm()) < deepest) ||
      !(atA.normal.dot(atB.normal) < 0.0))
    return false;
  const HeldPiece& solid = body.held.pieces[held.solid];
  return nearestOn(&solid, &solid + 1, deepestBetween(solid, from, to)).height < deepest;
}

/// Whether a point of the body is deep in a solid, or the middle of the solid deep in the body, or an edge
/// passes through the solid, which may be thin.
bool overlaps(const SoftBodyData& body, const HeldPartner& held, const Eigen::Vector3d& middle) {
  const double deepest = -2.0 * radiusOf(body);
  for (std::uint32_t i = 0; i < pointCount(body); ++i)
    if (nearestOnSolid(body, held, i).height < deepest) return true;
  const std::vector<Edge>& edges = body.model->topology.edges;
  return std::any_of(edges.begin(), edges.end(),
                     [&](const Edge& edge) { return passesThrough(body, held, edge, 0.25 * deepest); }) ||
         isInBody(body, middle, -deepest);
}

/// Fits the boxes of the body's surface as it is now. Contacts, which are found later, change its motion.
void fitPresentSurface(SoftBodyData& body) {
  SurfaceData& s = body.surface;
  s.motion.setZero(3, body.state.position.cols());
  s.moving = {&body.model->topology, &body.state.position, &s.motion, radiusOf(body), &s.boxes};
  fitBoxes(s.moving, s.boxes);
  s.motionValid = s.boxesValid = false;
}

/// Makes `held.out` the direction in which the body gets out of a solid by the shortest way: away from its
/// centre, along one of its axes, or along the normal of a face that is the nearest one of a point inside.
void chooseWayOut(const SoftBodyData& body, const btConvexShape& shape, const btTransform& pose,
                  HeldPartner& held) {
  double shortest = HUGE_VAL;
  const auto consider = [&](const Eigen::Vector3d& direction) {
    if (!(direction.norm() > 0.0)) return;
    const Eigen::Vector3d unit = direction.normalized();
    const btVector3 farthest = pose * shape.localGetSupportingVertex(toBullet(unit) * pose.getBasis());
    const double end = unit.dot(toEigen(farthest));
    const double way = end - (unit.transpose() * body.state.position).minCoeff();
    if (way < shortest) shortest = way, held.out = unit, held.end = end;
  };
  consider(body.state.position.rowwise().mean() - toEigen(pose.getOrigin()));
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d axis = toEigen(pose.getBasis().getColumn(k));
    consider(axis);
    consider(-axis);
  }
  for (std::uint32_t i = 0; i < pointCount(body); ++i)
    if (const HeldPoint nearest = nearestOnSolid(body, held, i); nearest.height < 0.0)
      consider(nearest.normal);
}

}  // namespace

bool isPushedOut(const SoftBodyData& body, const HeldPartner& held, std::uint32_t i) {
  if (held.out.isZero(0.0)) return false;
  if (nearestOnSolid(body, held, i).height < 0.0) return true;
  const Eigen::Vector3d x = body.state.position.col(i);
  const double ahead = held.end - held.out.dot(x);
  if (!(ahead > 0.0)) return false;
  const HeldPiece& solid = body.held.pieces[held.solid];
  const Eigen::Vector3d place = deepestBetween(solid, x, x + ahead * held.out);
  if (!(nearestOn(&solid, &solid + 1, place).height < 0.0)) return false;
  const SurfaceTopology& t = body.model->topology;
  return isInBody(body, place, 0.0) ||
         std::any_of(t.edgesAround.begin(i), t.edgesAround.end(i),
                     [&](std::uint32_t edge) { return passesThrough(body, held, t.edges[edge], 0.0); });
}

void findWaysOut(SoftBodyData& body) {
  if (!isSurfaceBody(body) || !isSolid(body.model->topology)) return;
  const bool wasOverlapping = body.surface.overlapTicks > 0;
  bool fitted = false;
  for (HeldPartner& held : body.heldPartners) {
    const btCollisionShape& shape = *held.object().getCollisionShape();
    if (!(wasOverlapping || held.came) || held.solid == HeldPartner::kNoSolid || !shape.isConvex() ||
        isAttached(body, held.object()))
      continue;
    const btTransform& pose = held.object().getWorldTransform();
    if (!fitted) fitPresentSurface(body);
    fitted = true;
    if (!overlaps(body, held, toEigen(pose.getOrigin()))) continue;
    chooseWayOut(body, static_cast<const btConvexShape&>(shape), pose, held);
    body.surface.overlapTicks = SurfaceData::kOverlapTicks;
  }
}

// --- the contacts of a tick --------------------------------------------------------------------------------

void gatherContacts(SoftBodyData& body, btScalar tick) {
  body.contacts.clear();
  body.held.pieces.clear();
  body.held.maxSearchDistance = HUGE_VAL;
  body.neighbourhoodCount = 0;
  body.localSpins.areKnown = false;
  std::swap(body.heldPartners, body.lastHeldPartners);
  body.speeds = contactSpeeds(body, double(tick));
  body.watch->start(tick);
  forgetPartners(body);
  const bool surface = isSurfaceBody(body);
  takePartners(body, double(tick));
  if (surface && nothingIsNear(body, double(tick))) return;
  const Eigen::AlignedBox3d box = searchBox(body, double(tick));
  if (!surface || !partnersCover(body, box)) queryPartners(body, box, double(tick));
  // excludes contacts of the points from Bullet's solver in this tick, including those not found yet, see
  // disableBulletResponse(); points in the world get their threshold back when the tick ends
  for (std::size_t i = 0; !surface && i < body.masses.bodies.size(); ++i)
    body.masses.bodies[i]->setContactProcessingThreshold(kIgnoredByBullet);
  if (surface && body.heldPartners.empty()) return;
  for (HeldPartner& partner : body.heldPartners) describePartner(body, partner);
  findWaysOut(body);
  const auto anyPartner = [&](auto test) {
    return std::any_of(body.heldPartners.begin(), body.heldPartners.end(),
                       [&](const HeldPartner& partner) { return test(partner.object()); });
  };
  body.watch->on = body.settings.continuousCollision &&
                   anyPartner([&](const btCollisionObject& partner) { return mayEnter(box, partner); });
  const bool anyMoves = anyPartner(isMoved);
  body.localSpins.areKnown = anyMoves && anyPartner(turns);
  if (body.localSpins.areKnown) findLocalSpins(body);
  // Bullet may free a manifold at any time after this function
  const auto forgetManifold = [&](std::uint32_t i) {
    if (!surface) body.masses.bodies[i]->cachedContact = nullptr;
  };
  for (std::uint32_t i = 0; i < pointCount(body); forgetManifold(i++)) {
    if (body.masses.held[i]) continue;
    const Eigen::Vector3d velocity = body.state.velocity.col(i);
    const double wanted = body.searchDistance[i],
                 known = addStaticRows(body, i, {velocity, double(tick), 0.0, false}, tick);
    for (std::uint32_t p = 0; anyMoves && p < body.heldPartners.size(); ++p)
      addRows(body, i, p, velocity, double(tick), tick);
    const bool isWhole = known >= wanted;
    body.watch->setRegion(i, body.state.position.col(i), isWhole ? body.searchDistance[i] : known);
  }
}

bool mayHaveMissedContacts(SoftBodyData& body) {
  if (body.watch->on || !body.settings.continuousCollision) return false;
  const double farthest = std::sqrt(sumsOf(body).farthest);
  const auto covers = [&](double distance) { return farthest <= distance; };
  if (std::all_of(body.searchDistance.begin(), body.searchDistance.end(), covers)) return false;
  Eigen::AlignedBox3d box;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i) {
    const Eigen::Vector3d start = body.masses.startPosition.col(i), end = body.state.position.col(i);
    if ((end - start).norm() > body.searchDistance[static_cast<std::size_t>(i)])
      box.extend(start).extend(end);
  }
  if (box.isEmpty()) return false;
  const double margin = radiusOf(body);
  body.watch->on = addStaticPartners(body, {box.min().array() - margin, box.max().array() + margin});
  return body.watch->on;
}

void addContactWatch(SoftBodyData& body) { body.watch = std::make_unique<Watch>(body); }

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "bullet/contact_gather.h"

#include "bullet/bullet_objects.h"
#include "bullet/contact_cache.h"
#include "bullet/contact_filter.h"
#include "bullet/contact_reach.h"
#include "bullet/kinematic_motion.h"
#include "bullet/multibody_links.h"
#include "bullet/point_masses.h"
#include "bullet/point_rows.h"
#include "bullet/rigid_shapes.h"
#include "bullet/surface_body.h"
#include "bullet/surface_partners.h"
#include "core/body_measures.h"
#include "core/closest_points.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Of the radius: a point that reaches no farther, the third of it that is always looked at included, is
/// slow.
constexpr double kSlowReach = 0.6;

/// Of the radius: a point that is no farther from a triangle's plane may be on its wrong side. What touches is pressed
/// in by far less.
constexpr double kDeepest = 0.5;

/// Of a spring's length: what is no farther beside a triangle is on it.
constexpr double kOnIt = 1e-9;

void forgetPartners(SoftBodyData& body) {
  body.partners.clear();
  body.freePartners.clear();
  body.softPartners.clear();
}

Eigen::AlignedBox3d boxOf(const btCollisionObject& object) {
  btVector3 low, high;
  object.getCollisionShape()->getAabb(object.getWorldTransform(), low, high);
  return {toEigen(low), toEigen(high)};
}

/// Whether something may get into the box (m). Boxes in Bullet's broadphase are larger than what is in them, by
/// lengths that are the same however large the scene is, and longer after motion: what is near to it only by these
/// must not decide how the body is stepped.
bool hasPartnersIn(const Eigen::AlignedBox3d& box, const SoftBodyData& body) {
  const auto isIn = [&](const btCollisionObject* p) { return isMoved(*p) || box.intersects(boxOf(*p)); };
  return !body.freePartners.empty() || !body.softPartners.empty() ||
         std::any_of(body.partners.begin(), body.partners.end(), isIn);
}

template <class T>
void addOnce(std::vector<T>& list, T entry) {
  if (std::find(list.begin(), list.end(), entry) == list.end()) list.push_back(entry);
}

/// Sorts them by what they are. Point masses that meet those of other bodies are in pair_gather.h.
void addPartner(SoftBodyData& body, btCollisionObject& object) {
  if (PointMass::from(&object)) return;
  if (SurfaceObject* surface = SurfaceObject::from(&object)) {
    if (isSurfaceBody(body) && surface->owner()) addOnce(body.softPartners, surface->owner());
  } else if (isStaticOrKinematic(object)) {
    addOnce<const btCollisionObject*>(body.partners, &object);
  } else if (const btMultiBodyLinkCollider* link = btMultiBodyLinkCollider::upcast(&object)) {
    if (isHeldLink(*link))
      addOnce<const btCollisionObject*>(body.partners, &object);
    else
      addOnce<btRigidBody*>(body.freePartners, &body.links->bodyOf(*link));
  } else if (btRigidBody* rigid = btRigidBody::upcast(&object)) {
    addOnce(body.freePartners, rigid);
  }
}

/// Collects the partners of a body in a tick.
struct PartnersInBox final : btBroadphaseAabbCallback {
  explicit PartnersInBox(SoftBodyData& b) : body(&b) {}
  SoftBodyData* body;

  bool process(const btBroadphaseProxy* proxy) override {
    if (canHit(*body, *proxy)) addPartner(*body, *static_cast<btCollisionObject*>(proxy->m_clientObject));
    return true;
  }
};

void addPlaneRow(RowsOfPair& rows, const SoftBodyData& body, std::uint32_t i,
                 const btCollisionObject& partner, double reach) {
  const auto& plane = *static_cast<const btStaticPlaneShape*>(partner.getCollisionShape());
  const btTransform& pose = partner.getWorldTransform();
  const Eigen::Vector3d normal = toEigen(pose.getBasis() * plane.getPlaneNormal());
  const btVector3 onPlane = pose * (plane.getPlaneNormal() * plane.getPlaneConstant());
  const Eigen::Vector3d x = body.state.position.col(i);
  const double height = normal.dot(x - toEigen(onPlane));
  if (height - double(body.masses.shape->getRadius()) > reach) return;
  rows.add(normal, toBullet(Eigen::Vector3d(x - height * normal)));
}

/// Uses the contact that Bullet found a tick ago. On a flat face it is as good as new; a slow point has not
/// left that face. False if there is none or the point is too fast for it.
bool addCachedRow(RowsOfPair& rows, const SoftBodyData& body, std::uint32_t i,
                  const btCollisionObject& partner, double reach) {
  const PointMass& point = *body.masses.bodies[i];
  const btPersistentManifold* manifold = point.cachedContact;
  const double radius = double(body.masses.shape->getRadius());
  if (!manifold || reach > kSlowReach * radius) return false;
  const bool pointIsFirst = manifold->getBody0() == &point;
  if ((pointIsFirst ? manifold->getBody1() : manifold->getBody0()) != &partner) return false;
  const btManifoldPoint& contact = manifold->getContactPoint(0);
  const btVector3 normal = pointIsFirst ? contact.m_normalWorldOnB : -contact.m_normalWorldOnB;
  rows.add(toEigen(normal),
           partner.getWorldTransform() * (pointIsFirst ? contact.m_localPointB : contact.m_localPointA));
  return true;
}

/// The same for a point outside the world, for which Bullet keeps none.
bool addKeptRow(RowsOfPair& rows, const SoftBodyData& body, std::uint32_t i, const btCollisionObject& partner,
                std::uint64_t stamp, double reach) {
  const CachedContact& cached = body.surface.contacts[i];
  const double radius = double(body.masses.shape->getRadius());
  const btVector3 place = toBullet(Eigen::Vector3d(body.state.position.col(i)));
  if (reach > kSlowReach * radius || !isKept(cached, stamp, partner, place, body.masses.shape->getRadius()))
    return false;
  const btTransform& pose = partner.getWorldTransform();
  rows.add(toEigen(pose.getBasis() * cached.normal), pose * cached.surface);
  return true;
}

/// Asks Bullet's narrowphase.
void addFoundRows(RowsOfPair& rows, SoftBodyData& body, std::uint32_t i, const btCollisionObject& partner,
                  std::uint64_t stamp) {
  if (!body.masses.shared) writePoint(body, i);
  body.world->contactPairTest(body.masses.bodies[i], const_cast<btCollisionObject*>(&partner), rows);
  if (isSurfaceBody(body)) rows.keepContact(body.surface.contacts[i], stamp);
}

/// Nobody can have excluded a pair with a point that nobody outside knows.
bool mayBeExcluded(const SoftBodyData& body) { return body.masses.shared || !body.anchors.empty(); }

double heightAbove(const HeldPiece& sheet, const Eigen::Vector3d& x) {
  return sheet.center.dot(x - sheet.axes.col(0));
}

/// m
double distanceTo(const HeldPiece& sheet, const Eigen::Vector3d& x) {
  const Eigen::Vector3d weights = nearestBarycentric({sheet.axes.col(0), sheet.axes.col(1), sheet.axes.col(2)}, x);
  return (sheet.axes * weights - x).norm();
}

/// Whether the straight line from x to y goes through a triangle.
bool goesThrough(const HeldPiece& sheet, const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
  const double from = heightAbove(sheet, x), to = heightAbove(sheet, y);
  if (from == to || (from > 0.0) == (to > 0.0)) return false;
  return distanceTo(sheet, x + from / (from - to) * (y - x)) <= kOnIt * (y - x).norm();
}

/// Whether a spring of point i goes through a triangle.
bool isHungThrough(const SoftBodyData& body, std::uint32_t i, const HeldPiece& sheet) {
  const auto& x = body.state.position;
  const auto goes = [&](const NetworkSpring& s) {
    return (s.a == i && goesThrough(sheet, x.col(i), x.col(s.b))) ||
           (s.b == i && goesThrough(sheet, x.col(i), x.col(s.a)));
  };
  return std::any_of(body.network->springs.begin(), body.network->springs.end(), goes);
}

/// What is put on terrain to within round-off, or a little too deep, has points that lie in its triangles: what touches
/// is a radius away. These belong where their body is, if springs of theirs go through.
void chooseSides(const SoftBodyData& body, std::uint32_t i, HeldPiece* begin, HeldPiece* end) {
  const double radius = double(body.masses.shape->getRadius());
  const Eigen::Vector3d x = body.state.position.col(i);
  for (HeldPiece* piece = begin; piece != end; ++piece) {
    if (piece->kind != HeldPiece::Kind::Sheet) continue;
    if (!(std::abs(heightAbove(*piece, x)) < piece->margin + kDeepest * radius)) continue;
    // most planes that pass by are those of triangles farther away; to look at all springs costs more
    if (distanceTo(*piece, x) > piece->margin + radius) continue;
    if (!isHungThrough(body, i, *piece)) continue;
    piece->metAbove = true;
    piece->side = heightAbove(*piece, centerOfMass(body.state)) < 0.0 ? -1 : 1;
  }
}

/// On a plane, of a sheet on all of it; `next` becomes the piece after these.
HeldPlace nearestOnFlat(const HeldPiece* first, const HeldPiece* end, const Eigen::Vector3d& x,
                        const HeldPiece*& next) {
  next = endOfSolid(first, end);
  if (first->kind != HeldPiece::Kind::Sheet) return nearestOn(first, next, x);
  const HeldPiece* below = first;
  for (; next != end && next->owner == first->owner; ++next)
    if (next->metAbove) below = next;
  const double height = heightAbove(*below, x), side = below->metAbove ? below->side : height < 0.0 ? -1.0 : 1.0;
  return {side * below->center, side * height - below->margin, true};
}

/// Rows that need not follow anything: all that is near is flat.
void addFlatRows(SoftBodyData& body, std::uint32_t i, const Reach& reach, btScalar tick) {
  const HeldSurroundings& all = body.held;
  const Eigen::Vector3d x = body.state.position.col(i);
  const HeldPiece* end = all.pieces.data() + all.pieces.size();
  const HeldPiece* first = all.pieces.data() + body.staticPieces;
  for (const auto& [partner, endOfOwners] : body.staticPartners) {
    RowsOfPair rows(body, i, *partner, reach.distance, tick);
    for (const HeldPiece* next = first; first != end && first->owner < endOfOwners; first = next) {
      const HeldPlace place = nearestOnFlat(first, end, x, next);
      if (place.height - double(body.masses.shape->getRadius()) <= reach.distance)
        rows.add(place.normal, toBullet(Eigen::Vector3d(x - place.height * place.normal)));
    }
  }
}

/// Rows that follow what is near: for each owner as many as there are directions in which it is.
void addFollowingRows(SoftBodyData& body, std::uint32_t i, const Reach& reach, btScalar tick) {
  if (body.neighbourhoodCount == body.neighbourhoods.size()) body.neighbourhoods.emplace_back();
  HeldNeighbourhood& around = body.neighbourhoods[body.neighbourhoodCount++];
  around = {&body.held, body.staticPieces, body.held.pieces.size(),
            double(body.masses.shape->getRadius())};
  findContacts(around, body.state.position.col(i), Eigen::Vector3d::Zero(), reach.distance);
  std::uint32_t owner = 0;
  for (const auto& [partner, endOfOwners] : body.staticPartners) {
    RowsOfPair rows(body, i, *partner, reach.distance, tick);
    for (; owner < endOfOwners; ++owner) {
      bool any = false;
      for (const HeldContact& c : body.held.contacts) {
        if (c.owner != owner) continue;
        rows.addFollowing(around, owner, &c);
        any = true;
      }
      if (!any) rows.addFollowing(around, owner, nullptr);
    }
  }
}

/// On what does not move.
void addStaticRows(SoftBodyData& body, std::uint32_t i, const Reach& reach, btScalar tick) {
  body.staticPartners.clear();
  body.staticPieces = body.held.pieces.size();
  std::uint32_t owners = 0;
  const Eigen::AlignedBox3d box(reach.low, reach.high);
  for (std::size_t p = 0; p < body.partners.size(); ++p) {
    const btCollisionObject* partner = body.partners[p];
    if (isMoved(*partner) || !box.intersects(body.partnerBoxes[p])) continue;
    if (mayBeExcluded(body) && !canHit(body, *body.masses.bodies[i], *partner)) continue;
    owners = addPieces(*partner, box, *body.shapes, owners, body.held.pieces);
    body.staticPartners.emplace_back(partner, owners);
  }
  const HeldPiece *begin = body.held.pieces.data() + body.staticPieces,
                  *end = body.held.pieces.data() + body.held.pieces.size();
  if (begin == end) return;
  chooseSides(body, i, body.held.pieces.data() + body.staticPieces, body.held.pieces.data() + body.held.pieces.size());
  if (!areFlatAround(begin, end, body.state.position.col(i), double(body.masses.shape->getRadius()),
                     reach.distance))
    return addFollowingRows(body, i, reach, tick);
  addFlatRows(body, i, reach, tick);
  body.held.pieces.resize(body.staticPieces);
}

/// On what moves as told; of a point that starts with a velocity and moves for `time` s of the tick.
void addRows(SoftBodyData& body, std::uint32_t i, const btCollisionObject& partner, std::uint64_t stamp,
             const Eigen::Vector3d& velocity, double time, btScalar tick) {
  if (!isMoved(partner)) return;
  const double travel = kinematicWay(partner, body.state.position.col(i)).norm();
  const Reach reach = reachFrom(body, i, velocity, time, kReachPerMotion * travel);
  if (!overlaps(reach, partner)) return;
  if (mayBeExcluded(body) && !canHit(body, *body.masses.bodies[i], partner)) return;
  const double distance = reach.distance;
  // it may be carried along, and need not be searched for there
  body.reach[i] = std::max(body.reach[i], distance);
  RowsOfPair rows(body, i, partner, distance, tick);
  const int shape = partner.getCollisionShape()->getShapeType();
  if (shape == STATIC_PLANE_PROXYTYPE)
    addPlaneRow(rows, body, i, partner, distance);
  else if (shape == BOX_SHAPE_PROXYTYPE && isSurfaceBody(body))
    rows.addOnBox(*static_cast<const btBoxShape*>(partner.getCollisionShape()), partner.getWorldTransform());
  else if (!(isSurfaceBody(body) ? addKeptRow(rows, body, i, partner, stamp, distance)
                                 : addCachedRow(rows, body, i, partner, distance)))
    addFoundRows(rows, body, i, partner, stamp);
}

/// The box around all reaches; keeps how far contacts are looked for.
Eigen::AlignedBox3d reachBox(SoftBodyData& body, double tick) {
  Eigen::AlignedBox3d box;
  body.reach.resize(body.masses.bodies.size());
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i) {
    const Reach reach = reachOf(body, i, tick);
    body.reach[static_cast<std::size_t>(i)] = reach.distance;
    box.extend(reach.low).extend(reach.high);
  }
  return box;
}

/// Takes over what Bullet's broadphase has found around a surface body, and what moves towards any body.
void takePartners(SoftBodyData& body) {
  const SurfaceObject* own = body.surface.object;
  for (btCollisionObject* partner : body.surface.partners)
    if ((!own || own->hasContactResponse()) && partner->hasContactResponse() &&
        (!own || SurfaceObject::from(partner) || own->mayTouch(*partner)))
      addPartner(body, *partner);
  body.surface.partners.clear();
}

/// Whether Bullet's broadphase knows that nothing is in the way of a body that flies as was foreseen: then
/// nothing pushes its points aside either.
bool fliesFreely(SoftBodyData& body, double tick) {
  const bool foreseen = !body.masses.shared && body.surface.flight.tick == tick;
  const Flight flight = foreseen ? body.surface.flight : flightOf(body, tick);
  if (hasPartnersIn(flight.box, body) || (!foreseen && !partnersCover(body, flight.box))) return false;
  forgetPartners(body);
  body.reach.assign(body.masses.bodies.size(), flight.reach);
  return true;
}

void askForPartners(SoftBodyData& body, const Eigen::AlignedBox3d& box) {
  PartnersInBox partners(body);
  body.world->getBroadphase()->aabbTest(toBullet(Eigen::Vector3d(box.min())),
                                        toBullet(Eigen::Vector3d(box.max())), partners);
}

/// For the present tick Bullet's solver leaves alone what the points touch, what it has not found yet, too;
/// see leaveToRows(). Points in the world have their threshold back when the tick ends.
void leavePointsToRows(SoftBodyData& body) {
  for (PointMass* point : body.masses.bodies) point->setContactProcessingThreshold(-BT_LARGE_FLOAT);
}

void notePartner(SoftBodyData& body, const btCollisionObject& partner) {
  body.partnerMarks.push_back(markOf(partner));
  body.partnerStamps.push_back(stampOf(partner));
  body.partnerBoxes.push_back(boxOf(partner));
}

/// Adds static and kinematic partners of a body in a box.
struct HeldInBox final : btBroadphaseAabbCallback {
  explicit HeldInBox(SoftBodyData& b) : body(&b) {}
  SoftBodyData* body;
  bool any = false;

  bool process(const btBroadphaseProxy* proxy) override {
    const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
    if (isSoft(object) || !isStaticOrKinematic(*object) || !canHit(*body, *proxy)) return true;
    any = true;
    if (std::find(body->partners.begin(), body->partners.end(), object) != body->partners.end()) return true;
    body->partners.push_back(object);
    notePartner(*body, *object);
    return true;
  }
};

/// Looks for contacts of points that are about to leave their reach, from where they are. The rows are apart
/// from the body's until the tick ends: contacts between bodies point to those.
class Watch final : public ReachWatch {
 public:
  explicit Watch(SoftBodyData& body) : body_(&body) {}

  void start(btScalar tick) override {
    tick_ = tick;
    on = false;
    rows.clear();
    partners_.clear();
  }

  void look(const PointView& points, double time, double dt) override {
    bool found = false;
    for (std::uint32_t i = 0; i < body_->masses.bodies.size(); ++i) {
      const Eigen::Vector3d x = points.positionOf(i), v = points.velocityOf(i);
      const double reach = body_->reach[i];
      const bool leaves = (x + dt * v - body_->masses.startPosition.col(i)).squaredNorm() > reach * reach;
      if (!leaves || body_->masses.held[i]) continue;
      search(i, x, v, time);
      found = true;
    }
    if (found) prepareContacts(rows, points);
  }

  void merge() override {
    auto& own = body_->contacts;
    auto& ownPartners = body_->contactPartners;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const auto place = std::upper_bound(own.begin(), own.end(), rows[r].point, isBefore) - own.begin();
      own.insert(own.begin() + place, rows[r]);
      ownPartners.insert(ownPartners.begin() + place, partners_[r]);
    }
    rows.clear();
    partners_.clear();
  }

 private:
  static bool isBefore(std::uint32_t point, const ContactRow& row) { return point < row.point; }

  /// From x, for the rest of the tick.
  void search(std::uint32_t i, const Eigen::Vector3d& x, const Eigen::Vector3d& v, double time) {
    btVector3& origin = body_->masses.bodies[i]->getWorldTransform().getOrigin();
    const btVector3 left = origin;
    const double rest = double(tick_) - time;
    body_->state.position.col(i) = x;
    const Reach reach = reachFrom(*body_, i, v, rest);
    HeldInBox held(*body_);
    body_->world->getBroadphase()->aabbTest(toBullet(reach.low), toBullet(reach.high), held);
    found_.clear();
    foundPartners_.clear();
    swapRows(found_, foundPartners_);
    addStaticRows(*body_, i, reach, tick_);
    for (std::size_t p = 0; p < body_->partners.size(); ++p) {
      // what moves is where it starts in the tick: the point beside it there as it is now
      const btCollisionObject& partner = *body_->partners[p];
      const Eigen::Vector3d beside = x - time / double(tick_) * kinematicWay(partner, x);
      body_->state.position.col(i) = beside;
      origin = toBullet(beside);
      addRows(*body_, i, partner, body_->partnerStamps[p], v, rest, tick_);
    }
    swapRows(found_, foundPartners_);
    body_->state.position.col(i) = x;
    origin = left;
    take(i);
    const double reached = (x - body_->masses.startPosition.col(i)).norm() + reach.distance;
    body_->reach[i] = std::max(body_->reach[i], reached);
  }

  /// What is gathered goes to the body's rows.
  void swapRows(std::vector<ContactRow>& r, std::vector<const btCollisionObject*>& p) {
    std::swap(body_->contacts, r);
    std::swap(body_->contactPartners, p);
  }

  /// In place of what was found of the point before, whose impulses what is found now has.
  void take(std::uint32_t i) {
    const RowRange old = rowsOfPoint(rows, i);
    for (std::size_t r = old.begin; r < old.end; ++r)
      for (std::size_t n = 0; n < found_.size(); ++n)
        if (foundPartners_[n] == partners_[r]) {
          found_[n].impulse += rows[r].impulse;
          break;
        }
    const auto at = [](std::size_t n) { return static_cast<std::ptrdiff_t>(n); };
    rows.erase(rows.begin() + at(old.begin), rows.begin() + at(old.end));
    partners_.erase(partners_.begin() + at(old.begin), partners_.begin() + at(old.end));
    rows.insert(rows.begin() + at(old.begin), found_.begin(), found_.end());
    partners_.insert(partners_.begin() + at(old.begin), foundPartners_.begin(), foundPartners_.end());
  }

  SoftBodyData* body_;
  btScalar tick_ = 0;
  std::vector<const btCollisionObject*> partners_;  // #rows
  std::vector<ContactRow> found_;                   // scratch
  std::vector<const btCollisionObject*> foundPartners_;
};

}  // namespace

void gatherContacts(SoftBodyData& body, btScalar tick) {
  body.contacts.clear();
  body.contactPartners.clear();
  body.held.pieces.clear();
  body.neighbourhoodCount = 0;
  body.partnerMarks.clear();
  body.partnerStamps.clear();
  body.partnerBoxes.clear();
  body.speeds = contactSpeeds(body, double(tick));
  body.watch->start(tick);
  forgetPartners(body);
  const bool surface = isSurfaceBody(body);
  takePartners(body);
  if (surface && fliesFreely(body, double(tick))) return;
  const Eigen::AlignedBox3d box = reachBox(body, double(tick));
  if (!surface || !partnersCover(body, box)) askForPartners(body, box);
  if (!surface) leavePointsToRows(body);
  if (surface && body.partners.empty()) return;
  for (const btCollisionObject* partner : body.partners) notePartner(body, *partner);
  body.watch->on = body.settings.continuousCollision && !body.partners.empty();
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    if (body.masses.held[i]) continue;
    addStaticRows(body, i, reachOf(body, i, double(tick)), tick);
    for (std::size_t p = 0; p < body.partners.size(); ++p)
      addRows(body, i, *body.partners[p], body.partnerStamps[p], body.state.velocity.col(i), double(tick), tick);
    // Bullet may free a manifold at any time after this
    if (!surface) body.masses.bodies[i]->cachedContact = nullptr;
  }
}

bool mayHaveMissedContacts(SoftBodyData& body) {
  if (body.watch->on || !body.settings.continuousCollision) return false;
  Eigen::AlignedBox3d box;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i) {
    const Eigen::Vector3d start = body.masses.startPosition.col(i), end = body.state.position.col(i);
    if ((end - start).norm() > body.reach[static_cast<std::size_t>(i)]) box.extend(start).extend(end);
  }
  if (box.isEmpty()) return false;
  const double margin = double(body.masses.shape->getRadius());
  HeldInBox held(body);
  body.world->getBroadphase()->aabbTest(toBullet(Eigen::Vector3d(box.min().array() - margin)),
                                        toBullet(Eigen::Vector3d(box.max().array() + margin)), held);
  body.watch->on = held.any;
  return held.any;
}

void addContactWatch(SoftBodyData& body) { body.watch = std::make_unique<Watch>(body); }

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This file finds contacts of rigid bodies that do not touch yet and will within the tick. Bullet finds them
// one tick later. Until then a stiff spring may have thrown a board against the box above it, deep into it.
// A touch with the side of a tile that is level with those below the body is none: the body slides on.

#include "bullet/kinematic_motion.h"
#include "bullet/rigid_shapes.h"
#include "bullet/soft_body_data.h"
#include "bullet/tick_contacts.h"

#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>

#include <array>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// m. Bullet pushes bodies out of smaller overlaps without harm.
constexpr double kShortWay = 0.01;

/// Most parts of a compound that are cast.
constexpr int kMaxParts = 64;

/// m, and as a share of the smaller body's radius: the largest distance of the bodies where their contacts
/// are sought.
constexpr btScalar kApart = btScalar(0.001), kApartShare = btScalar(0.003);

/// Contacts are nearer to each other than this share of the body's radius only if they are one.
constexpr btScalar kSamePlace = btScalar(0.05);

/// Returns the displacement (m) of an object in the tick if nothing else acts on it.
btVector3 wayOf(const btCollisionObject& object, double tick) {
  if (isKinematic(object))
    return toBullet(kinematicDisplacement(object, toEigen(object.getWorldTransform().getOrigin())));
  const btRigidBody* body = btRigidBody::upcast(&object);
  if (!body || !isFree(*body)) return btVector3(0, 0, 0);
  return btScalar(tick) * body->getLinearVelocity() + toBullet(fallOf(*body, tick));
}

/// The same without what gravity and forces add in the tick: what falls with a body supports it like a floor.
btVector3 ownWayOf(const btCollisionObject& object, double tick) {
  const btRigidBody* body = btRigidBody::upcast(&object);
  return body && isFree(*body) ? btScalar(tick) * body->getLinearVelocity() : wayOf(object, tick);
}

btTransform displaced(btTransform pose, const btVector3& way) {
  pose.setOrigin(pose.getOrigin() + way);
  return pose;
}

// --- what a body stands on or slides along -----------------------------------------------------------------

/// A contact that holds a body from one side.
struct Support {
  btVector3 normal;                  ///< unit, from the partner to the body
  btScalar gap;                      ///< m, at the start of the tick
  const btCollisionObject* partner;  ///< only compared, and asked for its motion
};

/// The contacts of a body: Bullet's, then those that it gets in the tick.
struct Supports {
  std::array<Support, 32> list;  // more add nothing
  std::size_t count = 0;

  void add(const Support& support) {
    constexpr btScalar kSame = btScalar(0.9999);
    for (std::size_t i = 0; i < count; ++i)
      if (list[i].partner == support.partner && list[i].normal.dot(support.normal) > kSame) {
        list[i].gap = btMin(list[i].gap, support.gap);
        return;
      }
    if (count < list.size()) list[count++] = support;
  }
};

Supports presentSupports(const RigidManifolds& index, const btCollisionObject& object) {
  Supports supports;
  if (LinkBody::from(&object)) return supports;  // it has no contacts in the index
  const auto i = static_cast<std::size_t>(object.getWorldArrayIndex());
  for (int m = index.begin[i]; m < index.begin[i + 1]; ++m) {
    btPersistentManifold& manifold = *index.manifolds[static_cast<std::size_t>(m)];
    const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
    for (int p = 0; p < manifold.getNumContacts(); ++p) {
      const btManifoldPoint& point = manifold.getContactPoint(p);
      const btVector3& normal = point.m_normalWorldOnB;
      const btVector3 offset =
          a.getWorldTransform() * point.m_localPointA - b.getWorldTransform() * point.m_localPointB;
      supports.add(
          {&a == &object ? normal : btVector3(-normal), offset.dot(normal), &a == &object ? &b : &a});
    }
  }
  return supports;
}

/// The displacement of an object in the tick while its supports hold it.
struct HeldWay {
  btVector3 way{0, 0, 0};   ///< m
  btVector3 away{0, 0, 0};  ///< the sum of the normals of the supports that stop it
  btScalar depth = 0;       ///< m, its largest overlap with them
};

/// `other`: the object that it may touch, which is no support. It may sink into supports by `apart` (m).
HeldWay heldWayOf(const btCollisionObject& object, const Supports& supports, const btCollisionObject& other,
                  btScalar apart, double tick) {
  HeldWay held;
  held.way = wayOf(object, tick);
  constexpr int kPasses = 2;  // for supports that meet at an angle
  for (int pass = 0; pass < kPasses; ++pass)
    for (std::size_t i = 0; i < supports.count; ++i) {
      const Support& support = supports.list[i];
      if (support.partner == &other) continue;
      const btScalar into =
          (ownWayOf(*support.partner, tick) - held.way).dot(support.normal) - btMax(support.gap, btScalar(0));
      if (!(into > 0)) continue;
      held.way += btMax(into - apart, btScalar(0)) * support.normal;
      held.away += support.normal;
      held.depth = btMax(held.depth, -support.gap);
    }
  return held;
}

// --- where two bodies first touch --------------------------------------------------------------------------

/// A convex part of an object.
struct Part {
  const btConvexShape* shape = nullptr;
  btTransform pose = btTransform::getIdentity();
};

/// Returns the place of the part, in the world, that is farthest along a direction.
btVector3 supportOf(const Part& part, const btVector3& direction) {
  return part.pose * part.shape->localGetSupportingVertex(direction * part.pose.getBasis());
}

/// Calls visit(part) for the convex parts of a shape.
template <class Visit>
void forEachPart(const btCollisionShape& shape, const btTransform& pose, Visit visit) {
  if (shape.isConvex()) return visit(Part{static_cast<const btConvexShape*>(&shape), pose});
  if (!shape.isCompound()) return;
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  if (compound.getNumChildShapes() > kMaxParts) return;
  for (int i = 0; i < compound.getNumChildShapes(); ++i)
    forEachPart(*compound.getChildShape(i), pose * compound.getChildTransform(i), visit);
}

/// What is below a static plane, in the world.
struct HalfSpace {
  btVector3 normal, on;  ///< unit; m, a point of the plane

  explicit HalfSpace(const btCollisionObject& object) {
    const auto& plane = static_cast<const btStaticPlaneShape&>(*object.getCollisionShape());
    const btTransform& pose = object.getWorldTransform();
    normal = pose.getBasis() * plane.getPlaneNormal();
    on = pose * (plane.getPlaneConstant() * plane.getPlaneNormal());
  }
  btScalar heightOf(const btVector3& point) const { return normal.dot(point - on); }
};

/// m, largest distance at which the object counts as touching.
btScalar resolutionOf(const btCollisionObject& object) {
  return std::min(kApart, kApartShare * btScalar(boundingRadiusOf(object)));
}

/// The nearest places of two parts that are apart.
struct Nearest {
  bool found = false;
  btVector3 normal{0, 0, 0};  ///< unit, from b to a
  btVector3 onB{0, 0, 0};
  btScalar distance = 0;  ///< m

  Nearest() = default;
  Nearest(const Part& a, const Part& b) {
    btVoronoiSimplexSolver simplex;
    btGjkPairDetector detector(a.shape, b.shape, &simplex, nullptr);
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA = a.pose;
    input.m_transformB = b.pose;
    btPointCollector nearest;
    detector.getClosestPoints(input, nearest, nullptr);
    found = nearest.m_hasResult;
    if (found)
      normal = nearest.m_normalOnBInWorld, onB = nearest.m_pointInWorld, distance = nearest.m_distance;
  }
};

struct Touch {
  Part a, b;  ///< the parts that touch, b where it is at the start of the tick, a where it touches
  btScalar fraction = 1;      ///< of the way
  btVector3 normal{0, 0, 0};  ///< from b to a; 0: they do not touch
  Nearest nearest;            ///< where it touches, or will soon; none for a plane
  btScalar apart = 0;         ///< m, distance of a from b there
};

/// Moves a part along a way (m) towards one that does not move. Returns the touch, `first` if that comes
/// sooner. The distance of two convex parts is a convex function of a displacement, its slope that along the
/// normal: Newton's method comes to the touch from before it, or finds that the way leads past. `apart`: m,
/// its resolution.
Touch sooner(const Touch& first, const Part& a, const Part& b, const btVector3& way, btScalar apart) {
  constexpr int kMaxSteps = 16;
  btScalar fraction = 0;
  for (int i = 0; i < kMaxSteps; ++i) {
    const Nearest nearest({a.shape, displaced(a.pose, fraction * way)}, b);
    const btScalar approach = -way.dot(nearest.normal);
    if (!nearest.found || !(approach > 0)) return first;
    if (nearest.distance <= apart) {
      Touch touch;
      touch.a = a, touch.b = b;
      touch.fraction = fraction;
      touch.normal = nearest.normal;
      return touch;
    }
    fraction += nearest.distance / approach;
    if (!(fraction < first.fraction)) return first;
  }
  return first;
}

/// The same for a static plane as b.
Touch sooner(const Touch& first, const Part& a, const HalfSpace& b, const btVector3& way) {
  const btScalar gap = b.heightOf(supportOf(a, -b.normal)), approach = -b.normal.dot(way);
  const btScalar fraction = gap > 0 && approach > 0 ? gap / approach : btScalar(gap > 0 ? 1 : 0);
  if (!(fraction < first.fraction)) return first;
  Touch touch;
  touch.a = a;
  touch.fraction = fraction;
  touch.normal = b.normal;
  return touch;
}

/// Moves the parts of a, displaced by `offset` (m), along a way (m) relative to b.
Touch firstTouch(const btCollisionObject& a, const btCollisionObject& b, const btVector3& way,
                 const btVector3& offset = btVector3(0, 0, 0)) {
  Touch first;
  const btScalar apart = resolutionOf(a);
  const btTransform poseA = displaced(a.getWorldTransform(), offset);
  forEachPart(*a.getCollisionShape(), poseA, [&](const Part& partA) {
    if (isPlane(b)) first = sooner(first, partA, HalfSpace(b), way);
    forEachPart(*b.getCollisionShape(), b.getWorldTransform(),
                [&](const Part& partB) { first = sooner(first, partA, partB, way, apart); });
  });
  if (first.normal.isZero()) return first;
  first.apart = apart;
  first.a.pose = displaced(first.a.pose, first.fraction * way + first.apart * first.normal);
  if (isPlane(b)) return first;
  first.nearest = Nearest(first.a, first.b);
  if (first.nearest.found) first.normal = first.nearest.normal;
  return first;
}

// --- the contacts there ------------------------------------------------------------------------------------

/// Places (m, on a and on b, in their own coordinates) where the two will touch.
struct ContactPlaces {
  struct Place {
    btVector3 onA, onB;
  };
  std::array<Place, 8> places;
  std::size_t count = 0;
  btScalar apart;  ///< m, least distance of two places

  void add(const btVector3& onA, const btVector3& onB) {
    for (std::size_t i = 0; i < count; ++i)
      if (places[i].onA.distance2(onA) < apart * apart) return;
    if (count < places.size()) places[count++] = {onA, onB};
  }
};

/// Calls visit(corner) for the corners of the part, in the world, that are farthest along a unit direction or
/// nearly so: of a face all, of a round shape one.
template <class Visit>
void forEachCorner(const Part& part, const btVector3& direction, Visit visit) {
  constexpr btScalar kTilt = btScalar(0.02);
  constexpr int kTilts = 8;
  btVector3 tangents[2];
  btPlaneSpace1(direction, tangents[0], tangents[1]);
  for (int i = 0; i < kTilts; ++i) {
    // not along the edges of boxes that lie in the axes
    const btScalar angle = (btScalar(i) + btScalar(0.4)) * SIMD_2_PI / btScalar(kTilts);
    const btVector3 tilted = direction + kTilt * (btCos(angle) * tangents[0] + btSin(angle) * tangents[1]);
    visit(supportOf(part, tilted));
  }
}

/// Finds the place of a part that faces a point along the touch's normal, which leads from the place to the
/// point or back. Returns false if the nearest place is beside it.
bool findFacing(const btVector3& point, const Part& part, const Touch& touch, btVector3& place) {
  HeldPoint nearest;
  if (!findNearestOutside(*part.shape, part.pose, toEigen(point), nearest)) return false;
  place = point - toBullet(nearest.height * nearest.normal);
  const btVector3 offset = point - place;
  return (offset - offset.dot(touch.normal) * touch.normal).length() < 2 * touch.apart;
}

void findPlaces(const btCollisionObject& a, const btCollisionObject& b, const btVector3& way,
                const Touch& touch, ContactPlaces& found) {
  const btTransform there =
      displaced(a.getWorldTransform(), touch.fraction * way + touch.apart * touch.normal);
  const auto add = [&](const btVector3& onA, const btVector3& onB) {
    found.add(there.invXform(onA), b.getWorldTransform().invXform(onB));
  };
  const Nearest& nearest = touch.nearest;
  if (nearest.found) add(nearest.onB + nearest.distance * touch.normal, nearest.onB);
  if (isPlane(b)) {
    const HalfSpace plane(b);
    const auto addAbove = [&](const btVector3& corner) {
      add(corner, corner - plane.heightOf(corner) * touch.normal);
    };
    addAbove(supportOf(touch.a, -touch.normal));
    return forEachCorner(touch.a, -touch.normal, addAbove);
  }
  btVector3 facing;
  forEachCorner(touch.a, -touch.normal, [&](const btVector3& corner) {
    if (findFacing(corner, touch.b, touch, facing)) add(corner, facing);
  });
  forEachCorner(touch.b, touch.normal, [&](const btVector3& corner) {
    if (findFacing(corner, touch.a, touch, facing)) add(facing, corner);
  });
}

btManifoldPoint pointAt(const btCollisionObject& a, const btCollisionObject& b,
                        const ContactPlaces::Place& place, const btVector3& normal) {
  btManifoldPoint point(place.onA, place.onB, normal, btScalar(0));
  point.m_combinedFriction = gCalculateCombinedFrictionCallback(&a, &b);
  point.m_combinedRestitution = gCalculateCombinedRestitutionCallback(&a, &b);
  point.m_combinedRollingFriction = gCalculateCombinedRollingFrictionCallback(&a, &b);
  point.m_combinedSpinningFriction = gCalculateCombinedSpinningFrictionCallback(&a, &b);
  return point;
}

// --- pairs -------------------------------------------------------------------------------------------------

/// Whether an object may touch another one at several places.
bool hasFaces(const btCollisionObject& object) {
  const btCollisionShape& shape = *object.getCollisionShape();
  return shape.isPolyhedral() || shape.isCompound();
}

/// Adds the places of Bullet's present contacts of the pair. Returns whether others may come: not between
/// faces that touch at three places or more, nor of round bodies that touch, nor while the two overlap.
bool addPresent(btDiscreteDynamicsWorld& world, btCollisionObject& a, btCollisionObject& b,
                btManifoldArray& manifolds, ContactPlaces& places) {
  constexpr btScalar kOverlap = btScalar(0.002);  // m
  btBroadphasePair* pair = world.getPairCache()->findPair(a.getBroadphaseHandle(), b.getBroadphaseHandle());
  if (!pair) return true;
  // the user's near callback leaves it out
  if (!pair->m_algorithm) return false;
  manifolds.resizeNoInitialize(0);
  pair->m_algorithm->getAllContactManifolds(manifolds);
  for (int m = 0; m < manifolds.size(); ++m)
    for (int i = 0; i < manifolds[m]->getNumContacts(); ++i) {
      const btManifoldPoint& point = manifolds[m]->getContactPoint(i);
      if (point.getDistance() < -kOverlap) return false;
      const bool inOrder = manifolds[m]->getBody0() == &a;
      places.add(inOrder ? point.m_localPointA : point.m_localPointB,
                 inOrder ? point.m_localPointB : point.m_localPointA);
    }
  return places.count == 0 || (places.count < 3 && hasFaces(a) && hasFaces(b));
}

/// A touch and the way on which it comes.
struct ComingTouch {
  btVector3 way{0, 0, 0};
  Touch touch;
  bool comes() const { return !touch.normal.isZero(); }
};

/// Two bodies that may touch in the tick.
struct Approach {
  const btCollisionObject &a, &b;
  HeldWay ofA, ofB;
  btScalar apart;  ///< m, resolution of touches

  /// Returns the unit direction in which a leaves its supports, and b its own the other way, or 0.
  btVector3 up() const {
    const btVector3 sum = ofA.away - ofB.away;
    return sum.fuzzyZero() ? btVector3(0, 0, 0) : sum.normalized();
  }

  /// A seam of the ground, as between tiles, is no obstacle: bodies that leave their supports by a little
  /// pass it. Other parts of the ground hold them like their supports.
  bool isSeam(const Touch& touch, const btVector3& way) const {
    constexpr btScalar kSameNormal = btScalar(0.9998);
    const btVector3 direction = up();
    if (direction.isZero() || touch.normal.dot(direction) > kSameNormal) return false;
    const btScalar height = ofA.depth + ofB.depth + 3 * apart;
    return firstTouch(a, b, way, height * direction).normal.isZero();
  }

  ComingTouch touchOn(const btVector3& way) const {
    ComingTouch coming;
    coming.way = way;
    if (double(way.length()) >= kShortWay) coming.touch = firstTouch(a, b, way);
    if (coming.comes() && isSeam(coming.touch, way)) coming.touch = Touch();
    return coming;
  }
};

/// Returns the touch of a with b in the tick: by their own motions, or where something stops one of the two.
ComingTouch comingTouch(const Approach& approach) {
  const btVector3 &ofA = approach.ofA.way, &ofB = approach.ofB.way;
  const ComingTouch own = approach.touchOn(ofA - ofB);
  if (own.comes()) return own;
  const ComingTouch whenStopped[] = {approach.touchOn(-ofB), approach.touchOn(ofA)};
  const ComingTouch& sooner = whenStopped[whenStopped[1].touch.fraction < whenStopped[0].touch.fraction];
  // not if their own motions lead past each other
  const btVector3& normal = sooner.touch.normal;
  const btScalar gap = -sooner.touch.fraction * sooner.way.dot(normal) + sooner.touch.apart;
  const bool passes = double(own.way.length()) >= kShortWay && -own.way.dot(normal) > gap;
  return passes ? ComingTouch() : sooner;
}

// --- pairs of spheres --------------------------------------------------------------------------------------

// Bullet has a contact of two spheres only while they overlap. Its solver would push them apart, and into
// what holds them, every other tick. Both the touch and the least distance on a straight way have closed
// forms.

/// Two spheres, b at rest.
struct SpherePair {
  btVector3 offset;   ///< m, of the centre of a from that of b
  btScalar distance;  ///< m, of the centres when they touch

  /// Returns the fraction of the way (m) after which a touches b, or a number above 1.
  btScalar touchOn(const btVector3& way) const {
    const btScalar squared = way.length2(), approach = -offset.dot(way);
    const btScalar root = approach * approach - squared * (offset.length2() - distance * distance);
    return approach > 0 && root >= 0 ? (approach - btSqrt(root)) / squared : btScalar(2);
  }
  btVector3 nearestOn(const btVector3& way) const {
    const btScalar squared = way.length2();
    return squared > 0 ? offset + btClamped(-offset.dot(way) / squared, btScalar(0), btScalar(1)) * way
                       : offset;
  }
};

/// m, 0 of what nothing moves.
double fallIn(double tick, const btCollisionObject& object) {
  const btRigidBody* body = btRigidBody::upcast(&object);
  return body && isFree(*body) ? fallOf(*body, tick).norm() : 0.0;
}

/// Returns the offset of a where the two touch in the tick, or where they are nearest if forces may close the
/// rest: those that hold them on a surface are about their weights. 0: they stay apart.
btVector3 offsetAtTouch(const SpherePair& pair, const btCollisionObject& a, const btCollisionObject& b,
                        double tick) {
  if (pair.offset.length2() <= pair.distance * pair.distance) return pair.offset;
  const btVector3 ofA = wayOf(a, tick), ofB = wayOf(b, tick), own = ofA - ofB;
  if (const btScalar t = pair.touchOn(own); t <= 1) return pair.offset + t * own;
  constexpr btScalar kRounding = btScalar(0.999);
  for (const btVector3& way : {btVector3(-ofB), ofA}) {
    const btScalar t = pair.touchOn(way);
    const btVector3 touch = pair.offset + t * way;
    // not if their own motions lead past each other
    if (t <= 1 && touch.dot(pair.offset + own) > kRounding * pair.distance * pair.distance) return touch;
  }
  const btVector3 nearest = pair.nearestOn(own);
  const double fall = std::max(fallIn(tick, a), fallIn(tick, b));
  return double(nearest.length() - pair.distance) < fall ? nearest : btVector3(0, 0, 0);
}

void addSpheres(const btCollisionObject& a, const btCollisionObject& b, const ContactSpeeds& speeds,
                TickContacts& found) {
  const auto radiusOf = [](const btCollisionObject& sphere) {
    return static_cast<const btSphereShape*>(sphere.getCollisionShape())->getRadius();
  };
  const btTransform &poseA = a.getWorldTransform(), &poseB = b.getWorldTransform();
  const SpherePair pair = {poseA.getOrigin() - poseB.getOrigin(), radiusOf(a) + radiusOf(b)};
  const btVector3 offset = offsetAtTouch(pair, a, b, found.tick);
  if (offset.fuzzyZero()) return;
  const btVector3 normal = offset.normalized();
  const ContactPlaces::Place place = {poseA.invXform(poseA.getOrigin() - radiusOf(a) * normal),
                                      poseB.invXform(poseB.getOrigin() + radiusOf(b) * normal)};
  addRigidContact(found, a, b, pointAt(a, b, place, normal), speeds);
}

// --- any pairs ---------------------------------------------------------------------------------------------

/// Looks for the contacts that a body gets in the tick.
struct ComingSearch {
  btDiscreteDynamicsWorld& world;
  const RigidManifolds& index;
  const ContactSpeeds& speeds;
  TickContacts& found;
  btCollisionObject& body;
  Supports supports;  ///< of the body

  Approach approach(const btCollisionObject& a, const btCollisionObject& b) const {
    const btScalar apart = resolutionOf(a);
    const auto heldWay = [&](const btCollisionObject& object, const btCollisionObject& other) {
      if (&object == &body) return heldWayOf(object, supports, other, apart, found.tick);
      const bool moves = isFree(static_cast<const btRigidBody&>(object));
      return heldWayOf(object, moves ? presentSupports(index, object) : Supports(), other, apart, found.tick);
    };
    return {a, b, heldWay(a, b), heldWay(b, a), apart};
  }

  /// Visits a pair with the places where it touches now, if others may come. The order of its objects is the
  /// same for both.
  template <class Visit>
  void withPair(btCollisionObject& other, Visit visit) const {
    const bool swap = !isPlane(other) && (isPlane(body) || boundingRadiusOf(other) < boundingRadiusOf(body));
    btCollisionObject &a = swap ? other : body, &b = swap ? body : other;
    ContactPlaces places;
    places.apart = kSamePlace * btScalar(boundingRadiusOf(a));
    if (addPresent(world, a, b, found.manifolds, places)) visit(a, b, places);
  }

  /// Returns the touch of the body with another one. Adds the contacts of spheres, which have no other.
  ComingTouch touchOf(btCollisionObject& other) const {
    ComingTouch coming;
    withPair(other, [&](btCollisionObject& a, btCollisionObject& b, ContactPlaces&) {
      if (isSphere(a) && isSphere(b))
        addSpheres(a, b, speeds, found);
      else
        coming = comingTouch(approach(a, b));
    });
    return coming;
  }

  /// Adds the contacts at a touch with another body. Gaps are those of the present poses. They become
  /// supports.
  void add(btCollisionObject& other, const ComingTouch& coming) {
    if (!coming.comes()) return;
    withPair(other, [&](btCollisionObject& a, btCollisionObject& b, ContactPlaces& places) {
      const Touch& touch = coming.touch;
      std::size_t next = places.count;
      findPlaces(a, b, coming.way, touch, places);
      for (; next < places.count; ++next)
        addRigidContact(found, a, b, pointAt(a, b, places.places[next], touch.normal), speeds);
      supports.add({&a == &body ? touch.normal : btVector3(-touch.normal),
                    touch.apart - touch.fraction * coming.way.dot(touch.normal), &other});
    });
  }
};

/// Finds the rigid bodies within a distance (m) of the body's box, sorted by id: the order of the broadphase
/// depends on earlier ticks.
void findNear(const btDiscreteDynamicsWorld& world, const btRigidBody& body, double distance,
              std::vector<btCollisionObject*>& near) {
  near.clear();
  btVector3 low, high;
  body.getAabb(low, high);
  const btScalar more = btScalar(distance);
  const btVector3 margin(more, more, more);
  forEachObjectIn(world, low - margin, high + margin, [&](btCollisionObject& other) {
    if (&other != &body && btRigidBody::upcast(&other) && !isSoft(&other)) near.push_back(&other);
  });
  std::sort(near.begin(), near.end(), hasSmallerId);
}

}  // namespace

double longestWay(const MovingObjects& objects, double tick) {
  btScalar longest = 0;
  for (const btRigidBody* body : objects.dynamic) longest = btMax(longest, wayOf(*body, tick).length());
  for (const btCollisionObject* object : objects.kinematic)
    longest = btMax(longest, wayOf(*object, tick).length());
  return double(longest);
}

void addComingContacts(btDiscreteDynamicsWorld& world, std::uint32_t number, double reach,
                       const ContactSpeeds& speeds, const RigidManifolds& index, TickContacts& found) {
  btRigidBody& body = *found.rigids[number].body;
  const double way = double(wayOf(body, found.tick).length());
  if (!isFree(body) || (std::max(way, reach) < kShortWay && !isSphere(body))) return;
  findNear(world, body, way + reach, found.near);
  ComingSearch search = {world, index, speeds, found, body, presentSupports(index, body)};
  // what it touches first holds it from then on
  ComingTouch earliest;
  std::size_t count = 0, first = 0;
  for (btCollisionObject* other : found.near) {
    const auto* rigid = static_cast<const btRigidBody*>(other);
    const std::uint32_t theirs = isFree(*rigid) ? found.find(*rigid) : TickContacts::kNone;
    if (theirs != TickContacts::kNone && theirs <= number) continue;
    if (!arePaired(world, body, *other) || !body.checkCollideWith(other) || !other->checkCollideWith(&body))
      continue;
    const ComingTouch coming = search.touchOf(*other);
    if (!coming.comes()) continue;
    if (!earliest.comes() || coming.touch.fraction < earliest.touch.fraction)
      earliest = coming, first = count;
    found.near[count++] = other;
  }
  if (count == 0) return;
  search.add(*found.near[first], earliest);
  for (std::size_t i = 0; i < count; ++i)
    if (i != first) search.add(*found.near[i], search.touchOf(*found.near[i]));
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

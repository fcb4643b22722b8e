// SPDX-License-Identifier: Zlib

// This file fills the contact reports of bodies after a tick from the plane contacts of points, the contacts
// between bodies, Bullet's manifolds and sensors. It finds the triangles of the contacts when a report is
// read, and reads contacts from manifolds for users.

#include "bullet/contact_report.h"

#include "bullet/body_in_world.h"
#include "bullet/point_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Multiple of the radius. Surfaces nearer than this are reported as contacts even without an impulse.
constexpr double kMaxReportedDistance = 0.05;

bool isReported(const SoftBodyData& body, const SoftContact& c) {
  return c.distance < kMaxReportedDistance * radiusOf(body) || !c.impulse.isZero();
}

/// Returns a contact of a body whose points on the side are at x (m).
SoftContact contactAt(const SoftBodyData& body, const ContactSide& side, const Vector3d& x,
                      const Vector3d& normal, double distance, const TickImpulse& impulse,
                      const btCollisionObject* other) {
  SoftContact c;
  c.body = body.handle;
  c.other = other;
  c.side = side;
  c.position = toBullet(x - radiusOf(body) * normal);
  c.normal = toBullet(normal);
  c.distance = distance;
  // the corrections of a contact that ends can sum up to slightly less than 0
  c.normalImpulse = std::max(impulse.along, 0.0);
  c.impulse = toBullet(impulse.sum);
  c.frictionImpulse = toBullet(impulse.sum - impulse.pressing);
  return c;
}

void add(SoftBodyData& body, const SoftContact& contact, const ObjectHandle& partner) {
  body.report.contacts.push_back(contact);
  body.report.partners.push_back(partner);
}

// --- on static and kinematic objects -----------------------------------------------------------------------

void addRows(SoftBodyData& body, const btCollisionWorld& world, double tick) {
  for (const PlaneContact& row : body.contacts) {
    const ObjectHandle& handle = partnerOf(body, row).handle;
    if (!isValid(world, handle)) continue;
    // its plane is that of the last contact, if there was any
    if (row.away && row.impulse.sum.isZero(0.0)) continue;
    const Vector3d x = body.state.position.col(row.point);
    const double distance = row.normal.dot(x - row.touch - tick * row.surfaceVelocity);
    const SoftContact c =
        contactAt(body, pointSide(row.point), x, row.normal, distance, row.impulse, handle.object);
    if (isReported(body, c)) add(body, c, handle);
  }
}

// --- with other moving bodies ------------------------------------------------------------------------------

/// Returns the contact as seen from the other side, whose partner is `object`.
SoftContact mirrored(const SoftContact& c, const btCollisionObject& object) {
  SoftContact m = c;
  m.body = c.otherBody;
  m.other = &object;
  m.otherBody = c.body;
  std::swap(m.side, m.otherSide);
  m.position = c.position - static_cast<btScalar>(c.distance) * c.normal;
  m.normal = -c.normal;
  m.impulse = -c.impulse;
  m.frictionImpulse = -c.frictionImpulse;
  return m;
}

void addPair(const TickContact& pair) {
  const ContactSource& source = pair.source;
  SoftBodyData &body = *source.body, *other = source.other;
  SoftContact c = contactAt(body, sideOf(pair.a), positionOf(pair.a, body.state.position), pair.normal,
                            pair.gap, pair.impulse, source.partner.object);
  if (!isReported(body, c)) return;
  if (other) {
    c.otherBody = other->handle;
    c.otherSide = sideOf(pair.b);
  }
  if (body.report.fresh) add(body, c, source.partner);
  const bool together = other && other != &body && pair.b.kind == ContactPoint::Kind::Soft;
  if (!together || !other->report.fresh || !anyInWorld(body)) return;
  const btCollisionObject* object = body.surface.object;
  if (!object) object = body.masses.bodies[pair.a.point[0]];
  add(*other, mirrored(c, *object), handleOf(*object));
}

/// Returns the displacement (m) of a contact point in the tick.
Vector3d displacementOf(const ContactPoint& p, const SoftBodyData* body, const TickContacts& pairs) {
  if (p.kind == ContactPoint::Kind::World) return pairs.tick * p.velocity;
  if (p.kind == ContactPoint::Kind::Rigid)
    return pairs.tick * toEigen(pairs.rigids[p.body].body->getVelocityInLocalPoint(toBullet(p.arm)));
  Vector3d displacement = Vector3d::Zero();
  for (std::uint32_t i = 0; i < p.count; ++i)
    displacement +=
        p.weight[i] * (body->state.position.col(p.point[i]) - body->masses.startPosition.col(p.point[i]));
  return displacement;
}

/// Adds a contact that has not acted. Its gap is that of the tick's start.
void addSensed(TickContact c, const TickContacts& pairs) {
  c.gap +=
      c.normal.dot(displacementOf(c.a, c.source.body, pairs) - displacementOf(c.b, c.source.other, pairs));
  addPair(c);
}

// --- contacts of points that Bullet's solver handled -------------------------------------------------------

/// Returns the soft body that has the object as its surface or a point, and sets `side` to the point of a
/// contact on it. `index`: of its triangle, as Bullet reports it.
SoftBody* readSide(const btCollisionObject* object, int index, const btVector3& position, ContactSide& side) {
  if (const PointReference point = findPoint(object); point.body) {
    side = pointSide(point.index);
    return point.body;
  }
  if (const SurfaceHit hit = surfaceHit(object, index, position); hit.body) {
    side.points = hit.points;
    side.weights = hit.weights;
    if (hit.triangle < hit.body->network().surface.size()) side.triangle = hit.triangle;
  }
  const SoftBodyData* owner = ownerOf(*object);
  return owner ? owner->handle : nullptr;
}

/// Returns a contact as seen from the manifold's first object, or from its second.
SoftContact readContact(const btPersistentManifold& manifold, int point, bool fromFirst) {
  const btManifoldPoint& p = manifold.getContactPoint(point);
  SoftContact c;
  c.body = readSide(manifold.getBody0(), p.m_index0, p.m_positionWorldOnA, c.side);
  c.otherBody = readSide(manifold.getBody1(), p.m_index1, p.m_positionWorldOnB, c.otherSide);
  c.other = manifold.getBody1();
  c.position = p.m_positionWorldOnA;
  c.normal = p.m_normalWorldOnB;
  c.distance = double(p.getDistance());
  c.normalImpulse = double(p.m_appliedImpulse);
  c.frictionImpulse = p.m_appliedImpulseLateral1 * p.m_lateralFrictionDir1 +
                      p.m_appliedImpulseLateral2 * p.m_lateralFrictionDir2;
  c.impulse = p.m_appliedImpulse * p.m_normalWorldOnB + c.frictionImpulse;
  if (fromFirst) return c;
  c = mirrored(c, *manifold.getBody0());
  c.position = p.m_positionWorldOnB;
  return c;
}

/// Finds the report's contact of a point with an object that has about this normal. Returns nullptr if there
/// is none.
SoftContact* findContact(ContactReport& report, std::uint32_t point, const btCollisionObject* other,
                         const btVector3& normal) {
  const auto begin = report.contacts.begin(), pairs = begin + static_cast<std::ptrdiff_t>(report.planeCount);
  const auto isThis = [&](const SoftContact& c) {
    return c.side.points[0] == point && c.other == other && c.normal.dot(normal) > btScalar(kSameSurface);
  };
  auto row = std::lower_bound(begin, pairs, point,
                              [](const SoftContact& c, std::uint32_t i) { return c.side.points[0] < i; });
  for (; row != pairs && row->side.points[0] == point; ++row)
    if (isThis(*row)) return &*row;
  const auto end = begin + static_cast<std::ptrdiff_t>(report.ownCount);
  const auto pair = std::find_if(pairs, end, isThis);
  return pair != end ? &*pair : nullptr;
}

/// Adds a contact of Bullet's solver to the report: its impulse to the same contact found by this plugin,
/// which is then returned, or else a new one.
const SoftContact* addBulletContact(SoftBodyData& body, const SoftContact& c) {
  if (SoftContact* same = findContact(body.report, c.side.points[0], c.other, c.normal)) {
    same->normalImpulse += c.normalImpulse;
    same->impulse += c.impulse;
    same->frictionImpulse += c.frictionImpulse;
    return same;
  }
  // Bullet's solver does not act on contacts that the user's filter has removed
  const bool isRemoved = isFiltered(body) && c.other->hasContactResponse();
  if (!isRemoved && isReported(body, c)) add(body, c, handleOf(*c.other));
  return nullptr;
}

/// Adds the impulses of a point's plane contacts to its manifold. Users read contact forces there.
void addPlaneImpulses(const SoftBodyData& body, std::uint32_t point, const btCollisionObject* partner,
                      btPersistentManifold& manifold) {
  const ContactRange rows = contactsOfPoint(body.contacts, point);
  for (std::size_t r = rows.begin; r < rows.end; ++r) {
    const PlaneContact& row = body.contacts[r];
    for (int p = 0; p < manifold.getNumContacts() && partnerOf(body, row).handle.object == partner; ++p) {
      btManifoldPoint& contact = manifold.getContactPoint(p);
      if (!(std::abs(toEigen(contact.m_normalWorldOnB).dot(row.normal)) > kSameSurface)) continue;
      contact.m_appliedImpulse += static_cast<btScalar>(row.impulse.along);
      break;
    }
  }
}

/// Adds a manifold to the reports of the bodies whose points are in it, and the impulses of the contacts that
/// this plugin has solved to the manifold.
void exchangeImpulses(btPersistentManifold& manifold) {
  const SoftContact* pointContact = nullptr;
  for (const bool first : {true, false}) {
    const btCollisionObject* object = first ? manifold.getBody0() : manifold.getBody1();
    const btCollisionObject* other = first ? manifold.getBody1() : manifold.getBody0();
    const PointMass* point = PointMass::from(object);
    SoftBodyData* body = point ? point->owner() : nullptr;
    if (!body || !body->alive || !body->report.fresh) continue;
    for (int p = 0; p < manifold.getNumContacts(); ++p) {
      const SoftContact* same = addBulletContact(*body, readContact(manifold, p, first));
      if (same && PointMass::from(other)) pointContact = same;
    }
    addPlaneImpulses(*body, point->index(), other, manifold);
  }
  // two spheres have one contact
  if (pointContact)
    manifold.getContactPoint(0).m_appliedImpulse = static_cast<btScalar>(pointContact->normalImpulse);
}

// --- contacts with sensors ---------------------------------------------------------------------------------

// They have no part in the step: the positions after the tick are tested against the objects with Bullet's
// narrowphase.

/// Keeps the deepest contact with an object, seen from the other one.
struct DeepestContact final : btCollisionWorld::ContactResultCallback {
  explicit DeepestContact(const btCollisionObject& p) : partner(&p) { m_closestDistanceThreshold = 0; }
  const btCollisionObject* partner;
  bool any = false;
  btScalar distance = 0;
  btVector3 normal, position, partnerPosition;  // m, on the soft body; on the partner
  int triangle = -1, partnerTriangle = -1;      // likewise

  btScalar addSingleResult(btManifoldPoint& p, const btCollisionObjectWrapper* first, int, int index0,
                           const btCollisionObjectWrapper*, int, int index1) override {
    if (p.getDistance() > 0 || (any && p.getDistance() >= distance)) return 0;
    const bool isSecond = first->getCollisionObject() == partner;
    any = true;
    distance = p.getDistance();
    normal = isSecond ? -p.m_normalWorldOnB : p.m_normalWorldOnB;
    position = isSecond ? p.m_positionWorldOnB : p.m_positionWorldOnA;
    partnerPosition = isSecond ? p.m_positionWorldOnA : p.m_positionWorldOnB;
    triangle = isSecond ? index1 : index0;
    partnerTriangle = isSecond ? index0 : index1;
    return 0;
  }
};

SoftContact contactOf(const SoftBodyData& body, const DeepestContact& hit) {
  SoftContact c;
  c.body = body.handle;
  c.other = hit.partner;
  c.otherBody = readSide(hit.partner, hit.partnerTriangle, hit.partnerPosition, c.otherSide);
  c.position = hit.position;
  c.normal = hit.normal;
  c.distance = double(hit.distance);
  return c;
}

DeepestContact deepestOf(SoftBodyData& body, btCollisionObject& own, const btCollisionObject& partner) {
  DeepestContact hit(partner);
  body.world->contactPairTest(&own, const_cast<btCollisionObject*>(&partner), hit);
  return hit;
}

/// Adds a contact to the report, and to that of the other body: two soft bodies have one contact each.
void addOnBothSides(SoftBodyData& body, const SoftContact& c, const ObjectHandle& partner) {
  add(body, c, partner);
  SoftBodyData* other = ownerOf(*partner.object);
  const btCollisionObject& own = *body.surface.object;
  if (other && other->report.fresh) add(*other, mirrored(c, own), handleOf(own));
}

/// Adds the points that touch the partner. Returns whether there are any.
bool addPoints(SoftBodyData& body, const ObjectHandle& partner) {
  const Eigen::AlignedBox3d box = boxOf(*partner.object);
  const Vector3d from = box.min().array() - radiusOf(body), to = box.max().array() + radiusOf(body);
  bool any = false;
  for (std::uint32_t i = 0; i < pointCount(body); ++i) {
    const Vector3d x = body.state.position.col(i);
    if (!(x.array() >= from.array()).all() || !(x.array() <= to.array()).all()) continue;
    const DeepestContact hit = deepestOf(body, probeAt(body, i), *partner.object);
    if (!hit.any) continue;
    SoftContact c = contactOf(body, hit);
    c.side = pointSide(i);
    addOnBothSides(body, c, partner);
    any = true;
  }
  return any;
}

/// The first triangle of a soft body that an edge of another one passes through.
struct PiercedTriangle final : btCollisionWorld::ClosestRayResultCallback {
  PiercedTriangle(const Vector3d& from, const Vector3d& to)
      : ClosestRayResultCallback(toBullet(from), toBullet(to)) {}
  int triangle = -1;

  btScalar addSingleResult(btCollisionWorld::LocalRayResult& hit, bool inWorld) override {
    triangle = hit.m_localShapeInfo ? hit.m_localShapeInfo->m_triangleIndex : -1;
    return ClosestRayResultCallback::addSingleResult(hit, inWorld);
  }
};

/// Adds the edges that pass through triangles of another soft body.
void addEdges(SoftBodyData& body, const ObjectHandle& partner) {
  auto* other = const_cast<btCollisionObject*>(partner.object);
  const btTransform& pose = other->getWorldTransform();
  const Eigen::AlignedBox3d box = boxOf(*other);
  for (const Edge& edge : body.model->topology.edges) {
    const Vector3d from = body.state.position.col(edge[0]), to = body.state.position.col(edge[1]);
    if (!box.intersects(Eigen::AlignedBox3d(from).extend(to))) continue;
    PiercedTriangle hit(from, to);
    btCollisionWorld::rayTestSingle(btTransform(btQuaternion::getIdentity(), hit.m_rayFromWorld),
                                    btTransform(btQuaternion::getIdentity(), hit.m_rayToWorld), other,
                                    other->getCollisionShape(), pose, hit);
    if (!hit.hasHit()) continue;
    SoftContact c;
    c.body = body.handle;
    c.other = other;
    c.otherBody = readSide(other, hit.triangle, hit.m_hitPointWorld, c.otherSide);
    c.position = hit.m_hitPointWorld;
    c.normal = hit.m_hitNormalWorld;
    const double share = double(hit.m_closestHitFraction);
    c.side.points = {edge[0], edge[1], edge[1]};
    c.side.weights = {1.0 - share, share, 0.0};
    addOnBothSides(body, c, partner);
  }
}

/// Bullet has no algorithm for concave objects with each other, nor for planes with triangles.
void addSurfaceOf(SoftBodyData& body, const ObjectHandle& partner) {
  if (isSoft(partner.object)) return addEdges(body, partner);
  const btCollisionShape& shape = *partner.object->getCollisionShape();
  if (!shape.isConvex() && !shape.isCompound()) return;
  const DeepestContact hit = deepestOf(body, *body.surface.object, *partner.object);
  if (!hit.any) return;
  SoftContact c = contactOf(body, hit);
  readSide(body.surface.object, hit.triangle, hit.position, c.side);
  if (c.side.weights.isZero(0.0)) return;
  add(body, c, partner);
}

/// Adds the present contacts of the body with its sensors to its report, after a tick: of the points, or,
/// where no point touches, of the triangles or springs with convex objects, and of the edges with soft
/// bodies. For one thread.
void reportSensors(SoftBodyData& body) {
  if (!body.surface.object || body.surface.object->getWorldArrayIndex() < 0) return;
  for (const ObjectHandle& partner : body.sensors)
    if (isValid(*body.world, partner) && !addPoints(body, partner)) addSurfaceOf(body, partner);
}

}  // namespace

bool addSensor(SoftBodyData& body, btCollisionObject& partner) {
  const SurfaceObject* own = body.surface.object;
  if (!own || (own->hasContactResponse() && partner.hasContactResponse())) return false;
  if (own->mayTouch(partner) && !PointMass::from(&partner)) body.sensors.push_back(handleOf(partner));
  return true;
}

ContactSide pointSide(std::uint32_t point) {
  ContactSide side;
  side.points = {point, point, point};
  side.weights = Vector3d::UnitX();
  return side;
}

ContactSide sideOf(const ContactPoint& p) {
  ContactSide side;
  for (std::uint32_t i = 0; i < 3; ++i) side.points[i] = p.point[std::min(i, p.count - 1)];
  for (std::uint32_t i = 0; i < p.count; ++i) side.weights[i] = p.weight[i];
  return side;
}

void reportContacts(const std::vector<SoftBodyData*>& bodies, const TickContacts& pairs,
                    const btDiscreteDynamicsWorld& world, double tick, const Parallel& parallel) {
  parallel.forEach(bodies.size(), [&](std::size_t i) {
    ContactReport& report = bodies[i]->report;
    report.fresh = true;
    report.contacts.clear();
    report.partners.clear();
    report.hasTriangles = false;
    addRows(*bodies[i], world, tick);
    report.planeCount = report.contacts.size();
  });
  const bool anyInBullet = std::any_of(bodies.begin(), bodies.end(),
                                       [](const SoftBodyData* body) { return !isSurfaceBody(*body); });
  for (const TickContact& c : pairs.contacts)
    if (c.source.body && isValid(world, c.source.partner)) addPair(c);
  for (const TickContact& c : pairs.sensed)
    if (isValid(world, c.source.partner)) addSensed(c, pairs);
  for (SoftBodyData* body : bodies)
    if (!body->sensors.empty()) reportSensors(*body);
  if (!anyInBullet) return;
  for (SoftBodyData* body : bodies) body->report.ownCount = body->report.contacts.size();
  forEachManifold(const_cast<btDispatcher&>(*world.getDispatcher()), exchangeImpulses);
}

SoftContact readContact(const btPersistentManifold& manifold, int point) {
  if (point < 0 || point >= manifold.getNumContacts()) return {};
  SoftContact c = readContact(manifold, point, true);
  if (!c.body) c = readContact(manifold, point, false);
  return c.body ? c : SoftContact();
}

// --- triangles ---------------------------------------------------------------------------------------------

namespace {

bool hasCorner(const Triangle& triangle, std::uint32_t point) {
  return triangle[0] == point || triangle[1] == point || triangle[2] == point;
}

/// Returns the cosine of the angle between a triangle's normal and a direction; of two-sided triangles, its
/// absolute value.
double facing(const SoftBodyData& body, std::uint32_t triangle, const Eigen::Vector3d& direction) {
  const Triangle& t = body.model->topology.triangles[triangle];
  const Points& x = body.state.position;
  const Eigen::Vector3d a = x.col(t[0]), normal = (x.col(t[1]) - a).cross(x.col(t[2]) - a).stableNormalized();
  const double along = normal.dot(direction);
  return body.model->topology.oneSided[triangle] ? along : std::abs(along);
}

/// Returns the triangle that has all points of the side and faces the direction best; of equals, the first.
std::uint32_t triangleOf(const SoftBodyData& body, const ContactSide& side,
                         const Eigen::Vector3d& direction) {
  const IndexLists& around = body.model->topology.trianglesAround;
  std::uint32_t best = ContactSide::kNone;
  double bestFacing = -2.0;
  for (const std::uint32_t* t = around.begin(side.points[0]); t != around.end(side.points[0]); ++t) {
    const Triangle& corners = body.model->topology.triangles[*t];
    if (!hasCorner(corners, side.points[1]) || !hasCorner(corners, side.points[2])) continue;
    const double value = facing(body, *t, direction);
    if (value > bestFacing) bestFacing = value, best = *t;
  }
  return best;
}

/// Sets the side to the triangle and assigns the weights to its corners.
void setTriangle(ContactSide& side, std::uint32_t triangle, const Triangle& corners) {
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (corners[static_cast<std::size_t>(j)] == side.points[static_cast<std::size_t>(i)]) {
        weights[j] += side.weights[i];
        break;
      }
  side = {triangle, {corners[0], corners[1], corners[2]}, weights};
}

void findTriangle(const SoftBodyData& body, ContactSide& side, const Eigen::Vector3d& direction) {
  if (!hasSurface(body) || side.triangle != ContactSide::kNone || side.weights.isZero(0.0)) return;
  const std::uint32_t triangle = triangleOf(body, side, direction);
  if (triangle != ContactSide::kNone) setTriangle(side, triangle, body.model->network->surface[triangle]);
}

}  // namespace

void findTriangles(SoftContact& contact) {
  const Eigen::Vector3d normal = toEigen(contact.normal);
  findTriangle(dataOf(*contact.body), contact.side, -normal);
  if (contact.otherBody) findTriangle(dataOf(*contact.otherBody), contact.otherSide, normal);
}

void dropInvalidContacts(SoftBodyData& body) {
  ContactReport& r = body.report;
  std::size_t count = 0;
  const bool inWorld = !r.contacts.empty() && anyInWorld(body);
  for (std::size_t i = 0; inWorld && i < r.contacts.size(); ++i) {
    if (!isValid(*body.world, r.partners[i])) continue;
    if (count != i) r.contacts[count] = r.contacts[i], r.partners[count] = r.partners[i];
    ++count;
  }
  r.contacts.resize(count);
  r.partners.resize(count);
}

const std::vector<SoftContact>& readReport(SoftBodyData& body) {
  dropInvalidContacts(body);
  ContactReport& report = body.report;
  if (!report.hasTriangles)
    for (SoftContact& contact : report.contacts) findTriangles(contact);
  report.hasTriangles = true;
  return report.contacts;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

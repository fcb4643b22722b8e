// SPDX-License-Identifier: Zlib

// This file fills the contact reports of bodies after a tick from the plane contacts of points, the contacts
// between bodies and Bullet's manifolds. It finds the triangles of the contacts when a report is read.

#include "bullet/contact_report.h"

#include "bullet/body_in_world.h"
#include "bullet/bullet_objects.h"
#include "bullet/point_contacts.h"
#include "bullet/soft_body_data.h"
#include "bullet/surface_body.h"
#include "bullet/tick_contacts.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Multiple of the radius. Surfaces nearer than this are reported as contacts even without an impulse.
constexpr double kMaxReportedDistance = 0.05;

bool isReported(const Vector3d& impulse, double distance, double radius) {
  return distance < kMaxReportedDistance * radius || !impulse.isZero(0.0);
}

void addImpulse(SoftContact& c, const TickImpulse& impulse) {
  c.normalImpulse += impulse.along;
  c.impulse += toBullet(impulse.sum);
  c.frictionImpulse += toBullet(impulse.sum - impulse.pressing);
}

void add(SoftBodyData& body, const SoftContact& contact, const ObjectHandle& partner) {
  body.report.contacts.push_back(contact);
  body.report.partners.push_back(partner);
}

ContactSide pointSide(std::uint32_t point) {
  ContactSide side;
  side.points = {point, point, point};
  side.weights = Vector3d::UnitX();
  return side;
}

// --- on static and kinematic objects -----------------------------------------------------------------------

void addRow(SoftBodyData& body, const PlaneContact& row, const ObjectHandle& partner, double tick) {
  const Vector3d x = body.state.position.col(row.point);
  const double radius = double(body.masses.shape->getRadius());
  const double distance = row.normal.dot(x - row.touch - tick * row.surfaceVelocity);
  if (!isReported(row.impulse.sum, distance, radius)) return;
  SoftContact c;
  c.body = body.handle;
  c.other = partner.object;
  c.side = pointSide(row.point);
  c.position = toBullet(x - radius * row.normal);
  c.normal = toBullet(row.normal);
  c.distance = distance;
  addImpulse(c, row.impulse);
  add(body, c, partner);
}

void addRows(SoftBodyData& body, const btCollisionWorld& world, double tick) {
  const ObjectHandle* handle = nullptr;
  for (std::size_t i = 0; i < body.contacts.size(); ++i) {
    const btCollisionObject* partner = body.contactPartners[i];
    if (!handle || handle->object != partner) {
      const auto isPartner = [&](const ObjectHandle& m) { return m.object == partner; };
      const auto it = std::find_if(body.partnerHandles.begin(), body.partnerHandles.end(), isPartner);
      handle = it != body.partnerHandles.end() && isValid(world, *it) ? &*it : nullptr;
    }
    if (handle) addRow(body, body.contacts[i], *handle, tick);
  }
}

// --- with other moving bodies ------------------------------------------------------------------------------

ContactSide sideOf(const ContactPoint& p, const SoftBodyData& body, Vector3d& position) {
  ContactSide side;
  position.setZero();
  for (std::uint32_t i = 0; i < p.count; ++i) {
    side.points[i] = p.point[i];
    side.weights[i] = p.weight[i];
    position += p.weight[i] * body.state.position.col(p.point[i]);
  }
  for (std::uint32_t i = p.count; i < 3; ++i) side.points[i] = side.points[i - 1];
  return side;
}

/// Returns the contact as seen from the second body, whose partner is `object`.
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

void addPair(const Contact& pair, const ContactSource& source) {
  SoftBodyData &body = *source.body, *other = source.other;
  const double radius = double(body.masses.shape->getRadius());
  if (!isReported(pair.impulse.sum, pair.gap, radius)) return;
  SoftContact c;
  Vector3d x, y;
  c.body = body.handle;
  c.other = source.partner.object;
  c.side = sideOf(pair.a, body, x);
  if (other) {
    c.otherBody = other->handle;
    c.otherSide = sideOf(pair.b, *other, y);
  }
  c.position = toBullet(x - radius * pair.normal);
  c.normal = toBullet(pair.normal);
  c.distance = pair.gap;
  addImpulse(c, pair.impulse);
  if (body.report.fresh) add(body, c, source.partner);
  const bool together = other && other != &body && pair.b.kind == ContactPoint::Kind::Soft;
  if (!together || !other->report.fresh || !anyInWorld(body)) return;
  const btCollisionObject* object = body.surface.object;
  if (!object) object = body.masses.bodies[pair.a.point[0]];
  add(*other, mirrored(c, *object), handleOf(*object));
}

// --- contacts of points that Bullet's solver handled -------------------------------------------------------

TickImpulse impulseOf(const btManifoldPoint& p, double sign) {
  const Vector3d normal = sign * toEigen(p.m_normalWorldOnB);
  const Vector3d friction = sign * toEigen(p.m_appliedImpulseLateral1 * p.m_lateralFrictionDir1 +
                                           p.m_appliedImpulseLateral2 * p.m_lateralFrictionDir2);
  const double magnitude = double(p.m_appliedImpulse);
  return {magnitude * normal + friction, magnitude * normal, magnitude};
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

/// Adds the impulse of Bullet's contact to the reported contact, or reports a new one if that is nullptr.
void addBulletImpulse(SoftContact* reported, SoftBodyData& body, const PointMass& point,
                      const btCollisionObject& other, const btManifoldPoint& p, bool isFirst) {
  const TickImpulse impulse = impulseOf(p, isFirst ? 1.0 : -1.0);
  if (reported) return addImpulse(*reported, impulse);
  const double radius = double(body.masses.shape->getRadius()), distance = double(p.getDistance());
  if (!isReported(impulse.sum, distance, radius)) return;
  SoftContact c;
  c.body = body.handle;
  c.other = &other;
  c.side = pointSide(point.index());
  if (const PointMass* theirs = PointMass::from(&other); theirs && theirs->owner()) {
    c.otherBody = theirs->owner()->handle;
    c.otherSide = pointSide(theirs->index());
  }
  c.position = isFirst ? p.m_positionWorldOnA : p.m_positionWorldOnB;
  c.normal = isFirst ? p.m_normalWorldOnB : -p.m_normalWorldOnB;
  c.distance = distance;
  addImpulse(c, impulse);
  add(body, c, handleOf(other));
}

/// Adds a manifold to the reports of its soft bodies. A manifold of two points also gets the impulse of
/// their contact.
void addManifold(btPersistentManifold& manifold) {
  const SoftContact* pointContact = nullptr;
  for (int side = 0; side < 2; ++side) {
    const btCollisionObject* object = side == 0 ? manifold.getBody0() : manifold.getBody1();
    const btCollisionObject* other = side == 0 ? manifold.getBody1() : manifold.getBody0();
    const PointMass* point = PointMass::from(object);
    SoftBodyData* body = point ? point->owner() : nullptr;
    if (!body || !body->alive || !body->report.fresh) continue;
    for (int p = 0; p < manifold.getNumContacts(); ++p) {
      btManifoldPoint& contact = manifold.getContactPoint(p);
      const btVector3 normal = side == 0 ? contact.m_normalWorldOnB : -contact.m_normalWorldOnB;
      SoftContact* reported = findContact(body->report, point->index(), other, normal);
      addBulletImpulse(reported, *body, *point, *other, contact, side == 0);
      if (reported && PointMass::from(other)) pointContact = reported;
    }
  }
  // two spheres have one contact
  if (pointContact)
    manifold.getContactPoint(0).m_appliedImpulse = static_cast<btScalar>(pointContact->normalImpulse);
}

}  // namespace

void reportContacts(const std::vector<SoftBodyData*>& bodies, const TickContacts& pairs,
                    const btDiscreteDynamicsWorld& world, double tick) {
  bool anyInBullet = false;
  for (SoftBodyData* body : bodies) {
    body->report.fresh = !body->asleep;
    if (body->asleep) continue;
    body->report.contacts.clear();
    body->report.partners.clear();
    body->report.hasTriangles = false;
    addRows(*body, world, tick);
    body->report.planeCount = body->report.contacts.size();
    anyInBullet = anyInBullet || !isSurfaceBody(*body);
  }
  for (std::size_t i = 0; i < pairs.contacts.size(); ++i)
    if (pairs.sources[i].body && isValid(world, pairs.sources[i].partner))
      addPair(pairs.contacts[i], pairs.sources[i]);
  if (!anyInBullet) return;
  for (SoftBodyData* body : bodies) body->report.ownCount = body->report.contacts.size();
  auto& dispatcher = const_cast<btDispatcher&>(*world.getDispatcher());
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m)
    addManifold(*dispatcher.getManifoldByIndexInternal(m));
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

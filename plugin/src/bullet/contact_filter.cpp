// SPDX-License-Identifier: Zlib

// This file shows contacts to the user's filter and applies its answers.

#include "bullet/contact_report.h"
#include "bullet/system_impl.h"

#include <LinearMath/btAabbUtil2.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

// --- the triangle of a concave object ----------------------------------------------------------------------

/// Finds the triangle nearest to a point, both in the coordinates of the shape.
struct NearestTriangle final : btTriangleCallback {
  explicit NearestTriangle(const Vector3d& position) : x(position) {}
  Vector3d x;
  double squaredDistance = std::numeric_limits<double>::max();
  int part = -1, triangle = -1;

  void processTriangle(btVector3* corners, int partId, int index) override {
    const Vector3d a = toEigen(corners[0]), b = toEigen(corners[1]), c = toEigen(corners[2]);
    const Vector3d w = nearestBarycentric({a, b, c}, x);
    const double squared = (w[0] * a + w[1] * b + w[2] * c - x).squaredNorm();
    if (!(squared < squaredDistance)) return;
    squaredDistance = squared;
    part = partId;
    triangle = index;
  }
};

/// Searches the shape and the children of compounds within `reach` (m) of a position in the world.
void findTriangle(const btCollisionShape& shape, const btTransform& pose, const btVector3& position,
                  btScalar reach, ShapeCache& shapes, ContactCandidate& c, double& squaredDistance) {
  const btVector3 local = pose.invXform(position), extent(reach, reach, reach);
  if (shape.isCompound()) {
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    forEachChildIn({local - extent, local + extent}, compound, [&](int i) {
      findTriangle(*compound.getChildShape(i), pose * compound.getChildTransform(i), position, reach, shapes,
                   c, squaredDistance);
    });
    return;
  }
  if (!shape.isConcave() || shape.getShapeType() == STATIC_PLANE_PROXYTYPE) return;
  NearestTriangle nearest(toEigen(local));
  nearest.squaredDistance = squaredDistance;
  {
    const std::unique_lock<std::mutex> lock = shapes.lockMesh(shape);
    static_cast<const btConcaveShape&>(shape).processAllTriangles(&nearest, local - extent, local + extent);
  }
  if (nearest.triangle < 0) return;
  squaredDistance = nearest.squaredDistance;
  c.otherPart = nearest.part;
  c.otherTriangle = nearest.triangle;
}

// --- questions ---------------------------------------------------------------------------------------------

/// Asks the filters of both sides, once if they are the same. Makes numbers of the answer valid.
void ask(const SoftBodyData& body, const SoftBodyData* other, ContactCandidate& c) {
  c.body = body.handle;
  if (other) c.otherBody = other->handle;
  if (!other && c.other) {
    double squaredDistance = std::numeric_limits<double>::max();
    const btScalar reach =
        btScalar(2) * (btFabs(static_cast<btScalar>(c.distance)) + static_cast<btScalar>(radiusOf(body)));
    findTriangle(*c.other->getCollisionShape(), c.other->getWorldTransform(),
                 c.position - static_cast<btScalar>(c.distance) * c.normal, reach, *body.shapes, c,
                 squaredDistance);
  }
  if (isFiltered(body)) (*body.filter)(c);
  if (other && other->filter != body.filter && isFiltered(*other)) (*other->filter)(c);
  if (!(c.friction >= 0.0)) c.friction = 0.0;
  if (!isSound(c.surfaceVelocity)) c.surfaceVelocity.setZero();
  if (!isFinite(c.facing)) c.facing.setZero();
  if (!(c.restitution >= 0.0)) c.restitution = 0.0;
  c.restitution = std::min(c.restitution, 1.0);
}

/// Returns the part of a velocity across a unit normal.
Vector3d acrossOf(const btVector3& velocity, const Vector3d& normal) {
  const Vector3d v = toEigen(velocity);
  return v - normal.dot(v) * normal;
}

/// Returns whether the direction is one that a one-sided contact has.
bool isFacing(const Vector3d& normal, const btVector3& facing) {
  return !(normal.dot(toEigen(facing)) < 0.0);
}

// --- plane contacts ----------------------------------------------------------------------------------------

/// Returns the nearest point of the pieces that a following contact follows.
HeldPoint nearestPiece(const PlaneContact& row, const Vector3d& x) {
  HeldPoint best;
  best.height = std::numeric_limits<double>::max();
  const HeldPiece* first = row.around->all->pieces.data() + row.around->begin;
  const HeldPiece* end = row.around->all->pieces.data() + row.around->end;
  for (const HeldPiece* next = first; first != end; first = next) {
    next = endOfSolid(first, end);
    if (first->owner != row.owner) continue;
    const HeldPoint point = nearestOn(first, next, x);
    if (point.height < best.height) best = point;
  }
  return best;
}

/// Returns whether the contact acts, or may act later in the tick. `answer` receives the answer.
bool filterPlane(const SoftBodyData& body, PlaneContact& row, ContactCandidate& answer) {
  const Vector3d x = body.state.position.col(row.point);
  Vector3d normal = row.normal;
  double gap = normal.dot(x - row.touch);
  if (row.away) {
    const HeldPoint nearest = nearestPiece(row, x);
    normal = nearest.normal;
    gap = nearest.height - radiusOf(body);
  }
  answer.other = partnerOf(body, row).handle.object;
  answer.side = pointSide(row.point);
  answer.position = toBullet(x - radiusOf(body) * normal);
  answer.normal = toBullet(normal);
  answer.distance = gap;
  answer.friction = row.friction;
  answer.restitution = row.restitution;
  ask(body, nullptr, answer);
  if (answer.response != ContactResponse::Act) return false;
  row.friction = answer.friction;
  row.restitution = answer.restitution;
  row.surfaceVelocity += acrossOf(answer.surfaceVelocity, normal);
  if (!row.around) return isFacing(normal, answer.facing);
  row.facing = toEigen(answer.facing);
  row.away = row.away || !isFacing(normal, answer.facing);
  return true;
}

/// Removes the entries for which keep(entry), which may change it, is false. Keeps the order.
template <class Entry, class Keep>
void keepOnly(std::vector<Entry>& entries, Keep keep) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (!keep(entries[i])) continue;
    if (count != i) entries[count] = entries[i];
    ++count;
  }
  entries.erase(entries.begin() + static_cast<std::ptrdiff_t>(count), entries.end());
}

/// Makes a contact for the report of a plane contact.
TickContact sensedContact(SoftBodyData& body, const PlaneContact& row, const ContactCandidate& answer) {
  TickContact c;
  static_cast<ContactBase&>(c) = row;
  c.normal = toEigen(answer.normal);
  c.gap = answer.distance;
  c.a = softPoint(body.index, row.point);
  c.b.velocity = row.surfaceVelocity;
  c.source.body = &body;
  c.source.partner = partnerOf(body, row).handle;
  return c;
}

// --- contacts of moving bodies -----------------------------------------------------------------------------

double validMassFactor(double factor) { return factor > 0.0 ? std::clamp(factor, 1e-6, 1e6) : 1.0; }

bool isAsked(const ContactSource& source) {
  return source.body && (isFiltered(*source.body) || (source.other && isFiltered(*source.other)));
}

/// `positions`: of the points of the body on side a.
ContactResponse filterPair(TickContact& contact, const Points& positions) {
  const ContactSource& source = contact.source;
  const SoftBodyData& body = *source.body;
  ContactCandidate answer;
  answer.other = source.partner.object;
  answer.side = sideOf(contact.a);
  if (source.other) answer.otherSide = sideOf(contact.b);
  answer.position = toBullet(positionOf(contact.a, positions) - radiusOf(body) * contact.normal);
  answer.normal = toBullet(contact.normal);
  answer.distance = contact.gap;
  answer.friction = contact.friction;
  answer.restitution = contact.restitution;
  ask(body, source.other, answer);
  contact.friction = answer.friction;
  contact.restitution = answer.restitution;
  if (source.other != source.body) {
    contact.a.massFactor = validMassFactor(answer.massFactor);
    contact.b.massFactor = validMassFactor(answer.otherMassFactor);
  }
  contact.b.velocity += acrossOf(answer.surfaceVelocity, contact.normal);
  const bool acts = answer.response == ContactResponse::Act;
  return acts && !isFacing(contact.normal, answer.facing) ? ContactResponse::Ignore : answer.response;
}

}  // namespace

void SoftBodySystem::setContactFilter(ContactFilter filter) {
  impl_->filter = std::move(filter);
  impl_->wakeAll();
}

void filterPlanes(SoftBodyData& body, std::vector<PlaneContact>& rows, TickContacts* found) {
  keepOnly(rows, [&](PlaneContact& row) {
    ContactCandidate answer;
    if (filterPlane(body, row, answer)) return true;
    if (found && answer.response == ContactResponse::Report)
      found->sensed.push_back(sensedContact(body, row, answer));
    return false;
  });
}

void filterPairs(TickContacts& found, std::vector<std::uint32_t>& newIndex) {
  newIndex.clear();
  std::uint32_t count = 0;
  keepOnly(found.contacts, [&](TickContact& c) {
    newIndex.push_back(count);
    const ContactResponse response =
        isAsked(c.source) ? filterPair(c, c.source.body->state.position) : ContactResponse::Act;
    if (response == ContactResponse::Report) found.sensed.push_back(c);
    if (response == ContactResponse::Act) ++count;
    return response == ContactResponse::Act;
  });
  newIndex.push_back(count);
  for (SurfaceCandidate& m : found.candidates) m.first = newIndex[m.first], m.end = newIndex[m.end];
}

void filterPairs(std::vector<TickContact>& contacts) {
  keepOnly(contacts, [](TickContact& c) {
    return !isAsked(c.source) ||
           filterPair(c, *c.source.body->surface.moving.position) == ContactResponse::Act;
  });
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

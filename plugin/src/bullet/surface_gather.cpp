// SPDX-License-Identifier: Zlib
#include "bullet/surface_gather.h"

#include "bullet/concave_patch.h"
#include "bullet/contact_reach.h"
#include "bullet/convert.h"
#include "bullet/pair_gather.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Of the radius: surfaces nearer than this are contacts even if they do not approach.
constexpr double kMargin = 1.0 / 3.0;

/// Of the radius: how far an edge or triangle may be in a static surface on which all its corners rest. It
/// sinks into round ones between its corners.
constexpr double kSagging = 0.5;

/// Cosine between the normals of a contact and of those of the corners that bear for it.
constexpr double kSameSide = 0.9;

const MovingSurface& movingSurface(SoftBodyData& body, double tick) {
  SurfaceData& s = body.surface;
  if (!s.foreseen) {
    s.motion = tick * body.state.velocity + tick * tick * body.state.acceleration;
    s.moving = {s.topology.get(), &body.state.position, &s.motion, double(body.masses.shape->getRadius()),
                &s.boxes};
    s.foreseen = true;
  }
  return s.moving;
}

const MovingSurface& boxedSurface(SoftBodyData& body, double tick) {
  const MovingSurface& moving = movingSurface(body, tick);
  if (!body.surface.fitted) fitBoxes(moving, body.surface.boxes);
  body.surface.fitted = true;
  return moving;
}

bool areNear(const MovingSurface& a, const MovingSurface& b, double margin) {
  if (a.boxes->nodes.empty() || b.boxes->nodes.empty()) return false;
  return separation(a.boxes->nodes[0], b.boxes->nodes[0]) <= margin;
}

/// The last search with a part of a partner; a new one if there was none in the last tick.
KeptContacts& searchWith(SoftBodyData& body, const btCollisionObject& partner, std::uint64_t part) {
  std::vector<KeptSearch>& searches = body.surface.searches;
  const int id = partner.getBroadphaseHandle()->m_uniqueId;
  const auto isThis = [&](const KeptSearch& s) { return s.partner == id && s.part == part; };
  auto it = std::find_if(searches.begin(), searches.end(), isThis);
  if (it == searches.end()) {
    it = std::find_if(searches.begin(), searches.end(), [](const KeptSearch& s) { return s.partner == 0; });
    if (it == searches.end()) it = searches.emplace(searches.end());
    it->partner = id;
    it->part = part;
    it->kept.topologyA = nullptr;
  }
  it->used = true;
  return it->kept;
}

/// What is no longer near gives its memory to what comes near.
void forgetOldSearches(SoftBodyData& body) {
  for (KeptSearch& search : body.surface.searches) {
    if (!search.used) search.partner = 0;
    search.used = false;
  }
}

ContactPlace softPlace(const SoftBodyData& body, const SurfacePlace& place) {
  ContactPlace p;
  p.kind = ContactPlace::Kind::Soft;
  p.body = body.index;
  p.count = place.kind == FeatureKind::OnVertex ? 1 : place.kind == FeatureKind::OnEdge ? 2 : 3;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    p.point[i] = place.points[i];
    p.weight[i] = place.weights[i];
  }
  return p;
}

Vector3d positionOf(const MovingSurface& surface, const SurfacePlace& place) {
  Vector3d x = Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    x += place.weights[i] * surface.position->col(place.points[static_cast<std::size_t>(i)]);
  return x;
}

const btCollisionObject& frictionObject(const SoftBodyData& body) { return *body.surface.object; }

/// What the two have in common whatever they touch with.
PairContact contactOf(const SoftBodyData& body, const btCollisionObject& partner, const SurfaceContact& c) {
  PairContact pair;
  pair.a = softPlace(body, c.a);
  pair.normal = c.normal;
  pair.gap = c.gap;
  pair.friction = double(gCalculateCombinedFrictionCallback(&frictionObject(body), &partner));
  pair.restitution = double(gCalculateCombinedRestitutionCallback(&frictionObject(body), &partner));
  pair.recoverySpeed = recoverySpeed(double(body.masses.shape->getRadius()));
  return pair;
}

ContactSource sourceOf(SoftBodyData& body, const btCollisionObject& partner, std::uint64_t key) {
  ContactSource source;
  source.body = &body;
  source.partner = markOf(partner);
  source.key = key;
  return source;
}

/// Points that are attached to a body do not collide with it, nor do the edges and triangles they end.
bool isAttached(const SoftBodyData& body, const btCollisionObject& partner, const SurfacePlace& place) {
  if (body.anchors.empty()) return false;
  return std::any_of(place.points.begin(), place.points.end(),
                     [&](std::uint32_t point) { return body.masses.bodies[point]->attachedTo == &partner; });
}

// --- rigid bodies that move --------------------------------------------------------------------------------

/// Both sides get their impulses at one place, where the soft one's points, edges and triangles are when they
/// touch: no couple is left over.
btVector3 commonPlace(const MovingSurface& soft, const MovingSurface& rigid, const SurfaceContact& c) {
  return toBullet(Vector3d(positionOf(rigid, c.b) + (rigid.radius + soft.radius) * c.normal));
}

void addFree(SoftBodyData& body, btRigidBody& partner, const RigidPart& part, std::uint64_t partNumber,
             double tick, SurfaceSearch& s, TickContacts& found) {
  const MovingSurface& soft = movingSurface(body, tick);
  const double margin = kMargin * soft.radius;
  KeptContacts& kept = searchWith(body, partner, partNumber);
  if (!refreshContacts(soft, part.moving, margin, kept)) {
    boxedSurface(body, tick);
    s.contacts.clear();
    if (areNear(soft, part.moving, margin))
      findSurfaceContacts(soft, part.moving, margin, s.search, s.contacts);
    keepContacts(soft, part.moving, s.contacts, kept);
  }
  for (const SurfaceContact& c : kept.contacts) {
    if (isAttached(body, partner, c.a)) continue;
    PairContact pair = contactOf(body, partner, c);
    pair.b = placeOn(found, partner, commonPlace(soft, part.moving, c));
    found.add(pair, sourceOf(body, partner, c.key ^ (partNumber << 56)));
  }
}

void gatherFree(SoftBodyData& body, btRigidBody& partner, double tick, RigidSurfaces& rigids,
                SurfaceSearch& s, TickContacts& found) {
  const RigidSurfaces::Range parts = rigids.partsOf(partner, tick);
  if (parts.begin == parts.end) return gatherPairs(body, partner, static_cast<btScalar>(tick), found);
  for (std::size_t i = parts.begin; i < parts.end; ++i)
    addFree(body, partner, rigids.part(i - 1), i - parts.begin, tick, s, found);
}

// --- static and kinematic objects --------------------------------------------------------------------------

/// Holds the box of the whole surface, without fitting all of them.
SweptBox roughBox(const MovingSurface& soft) {
  SweptBox box = sweptBounds(soft);
  double depth = 0.0;
  for (const double limit : soft.topology->depthLimit) depth = std::max(depth, limit);
  box.low -= depth;
  box.high += depth;
  return box;
}

/// Whether something of the part that is neither flat nor a plane's end is near: else the points are enough.
bool hasSharpNear(const SweptBox& box, const RigidPart& part) {
  const SurfaceTopology& t = part.surface->topology;
  if (t.edges.empty()) return true;
  for (const std::uint32_t e : part.surface->sharpEdges) {
    const Edge& edge = t.edges[e];
    const SweptBox edgeBox = merged(part.boxes.points[edge[0]], part.boxes.points[edge[1]]);
    if (separation(box, edgeBox) <= 0.0) return true;
  }
  return false;
}

/// Whether edges and triangles sink into a sphere or capsule by less than kSagging where their corners rest
/// on it: no place is farther than c = L / sqrt(3) from a corner if the longest edge is L, and c^2 / (2 R) is
/// how deep that is under a sphere of radius R.
bool bendsGently(const MovingSurface& soft, const RigidPart& part) {
  if (!part.surface->topology.triangles.empty()) return false;
  const double most = 6.0 * kSagging * soft.radius * (part.surface->radius + soft.radius);
  const auto& edges = soft.topology->edges;
  return std::all_of(edges.begin(), edges.end(), [&](const Edge& e) {
    return (soft.position->col(e[1]) - soft.position->col(e[0])).squaredNorm() <= most;
  });
}

bool isBorne(const SoftBodyData& body, std::uint32_t point, const btCollisionObject& partner,
             const Vector3d& normal) {
  const RowRange rows = rowsOfPoint(body.contacts, point);
  for (std::size_t r = rows.begin; r < rows.end; ++r)
    if (body.contactPartners[r] == &partner && body.contacts[r].normal.dot(normal) > kSameSide) return true;
  return false;
}

/// Whether the points at the corners bear for it.
bool cornersBear(const SoftBodyData& body, const btCollisionObject& partner, const SurfaceContact& c) {
  if (c.gap < -kSagging * double(body.masses.shape->getRadius())) return false;
  for (const std::uint32_t point : c.a.points)
    if (!isBorne(body, point, partner, c.normal)) return false;
  return true;
}

void addHeld(SoftBodyData& body, const btCollisionObject& partner, const RigidPart& part,
             std::uint64_t partNumber, double tick, SurfaceSearch& s, TickContacts& found) {
  const MovingSurface& soft = movingSurface(body, tick);
  const double margin = kMargin * soft.radius;
  if (bendsGently(soft, part) || !hasSharpNear(roughBox(soft), part)) return;
  boxedSurface(body, tick);
  if (!areNear(soft, part.moving, margin) || !hasSharpNear(soft.boxes->nodes[0], part)) return;
  findSurfaceContacts(soft, part.moving, margin, s.search, s.contacts);
  for (const SurfaceContact& c : s.contacts) {
    if (c.a.kind == FeatureKind::OnVertex || isAttached(body, partner, c.a)) continue;
    if (cornersBear(body, partner, c)) continue;
    PairContact pair = contactOf(body, partner, c);
    pair.b.velocity = velocityOf(partner, commonPlace(soft, part.moving, c));
    found.add(pair, sourceOf(body, partner, c.key ^ (partNumber << 56)));
  }
}

void gatherHeld(SoftBodyData& body, const btCollisionObject& partner, double tick, RigidSurfaces& rigids,
                SurfaceSearch& s, TickContacts& found) {
  if (partner.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE) return;
  if (partner.getCollisionShape()->isConcave()) {
    const RigidPart* patch = patchAround(body, partner, boxedSurface(body, tick));
    if (patch) addHeld(body, partner, *patch, 0, tick, s, found);
    return;
  }
  const RigidSurfaces::Range parts = rigids.partsOf(partner, tick);
  for (std::size_t i = parts.begin; i < parts.end; ++i)
    addHeld(body, partner, rigids.part(i - 1), i - parts.begin, tick, s, found);
}

// --- soft bodies -------------------------------------------------------------------------------------------

/// A place on a body that this system does not step in this tick; its points are told to users only.
ContactPlace strangePlace(const SoftBodyData& body, const SurfacePlace& place) {
  ContactPlace p = softPlace(body, place);
  p.kind = ContactPlace::Kind::World;
  if (body.asleep) return p;
  for (int i = 0; i < 3; ++i)
    p.velocity += place.weights[i] * body.state.velocity.col(place.points[static_cast<std::size_t>(i)]);
  return p;
}

void gatherSoft(SoftBodyData& body, SoftBodyData& other, double tick, SurfaceSearch& s, TickContacts& found) {
  if (!other.alive || !other.surface.topology) return;
  const bool together = other.system == body.system && !other.asleep;
  if (together && other.index < body.index) return;
  const MovingSurface &a = movingSurface(body, tick), &b = movingSurface(other, tick);
  const double margin = kMargin * std::min(a.radius, b.radius);
  KeptContacts& kept = searchWith(body, frictionObject(other), 0);
  if (!refreshContacts(a, b, margin, kept)) {
    boxedSurface(body, tick);
    boxedSurface(other, tick);
    s.contacts.clear();
    if (areNear(a, b, margin)) findSurfaceContacts(a, b, margin, s.search, s.contacts);
    keepContacts(a, b, s.contacts, kept);
  }
  for (const SurfaceContact& c : kept.contacts) {
    PairContact pair = contactOf(body, frictionObject(other), c);
    pair.b = together ? softPlace(other, c.b) : strangePlace(other, c.b);
    ContactSource source = sourceOf(body, frictionObject(other), c.key);
    source.other = &other;
    found.add(pair, source);
  }
}

void gatherSelf(SoftBodyData& body, double tick, SurfaceSearch& s, TickContacts& found) {
  const MovingSurface& surface = boxedSurface(body, tick);
  findSelfContacts(surface, kMargin * surface.radius, s.search, s.contacts);
  for (const SurfaceContact& c : s.contacts) {
    PairContact pair = contactOf(body, frictionObject(body), c);
    pair.b = softPlace(body, c.b);
    ContactSource source = sourceOf(body, frictionObject(body), c.key);
    source.other = &body;
    found.add(pair, source);
  }
}

}  // namespace

void gatherSurfacePairs(SoftBodyData& body, btScalar tick, RigidSurfaces& rigids, SurfaceSearch& search,
                        TickContacts& found) {
  if (!body.surface.topology) return;
  const double h = double(tick);
  for (btRigidBody* partner : body.freePartners) gatherFree(body, *partner, h, rigids, search, found);
  for (const btCollisionObject* partner : body.partners) gatherHeld(body, *partner, h, rigids, search, found);
  for (SoftBodyData* other : body.softPartners) gatherSoft(body, *other, h, search, found);
  if (body.settings.selfCollision) gatherSelf(body, h, search, found);
  forgetOldSearches(body);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This file finds the pairs of bodies that move together and touch only because something stops one of them:
// of a falling stack the lowest body hits the floor, and within the same tick the next one hits the lowest.

#include "bullet/surface_gather.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

// --- motions -----------------------------------------------------------------------------------------------

/// The motions of bodies, as displacements (m) in the tick. Each body has the box of its own mean motion and
/// of those of all that may stop it: what sticks together moves by something between them.
class Motions {
 public:
  Motions(double tick, SurfaceSearch& search)
      : tick_(tick), rigids_(search.motions), numbers_(search.motionOf) {
    rigids_.clear();
  }

  /// Gives each body of the pair its own motion, and that of static and kinematic objects that it touches.
  void start(const SurfaceCandidate& m) {
    for (SoftBodyData* body : {m.body, m.other})
      if (body) startSoft(*body);
    if (m.partner && !find(*m.partner)) startRigid(*m.partner);
  }

  /// Adds the motions of what the rigid bodies touch in Bullet.
  void addManifolds(btDispatcher& dispatcher) {
    if (rigids_.empty()) return;
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
      if (manifold.getNumContacts() == 0) continue;
      addTouched(*manifold.getBody0(), *manifold.getBody1());
      addTouched(*manifold.getBody1(), *manifold.getBody0());
    }
  }

  AlignedBox3d& of(SoftBodyData& body) { return body.surface.motions; }
  AlignedBox3d& ofOther(const SurfaceCandidate& m) { return m.other ? of(*m.other) : find(*m.partner)->box; }
  AlignedBox3d ofBoth(const SurfaceCandidate& m) { return of(*m.body).merged(ofOther(m)); }

  /// Lets each body of the pair stop the other. Returns whether a box has grown.
  bool join(const SurfaceCandidate& m) {
    const AlignedBox3d all = ofBoth(m);
    AlignedBox3d &a = of(*m.body), &b = ofOther(m);
    if (a.contains(all) && b.contains(all)) return false;
    a = b = all;
    return true;
  }

 private:
  void startSoft(SoftBodyData& body) {
    AlignedBox3d& box = body.surface.motions;
    if (!box.isEmpty()) return;
    box.extend(Vector3d(body.surface.motion.rowwise().mean()));
    for (const PlaneContact& row : body.contacts) box.extend(Vector3d(tick_ * row.surfaceVelocity));
  }

  void startRigid(const btRigidBody& body) {
    const auto index = static_cast<std::size_t>(body.getWorldArrayIndex());
    if (index >= numbers_.size()) numbers_.resize(index + 1);
    numbers_[index] = static_cast<std::uint32_t>(rigids_.size());
    // what it stands on may be unknown in its first tick
    const Vector3d coasting = tick_ * toEigen(body.getLinearVelocity());
    rigids_.push_back({&body, AlignedBox3d(coasting).extend(Vector3d(coasting + fallOf(body, tick_)))});
  }

  RigidMotions* find(const btCollisionObject& object) {
    const auto index = static_cast<std::size_t>(object.getWorldArrayIndex());
    if (index >= numbers_.size() || numbers_[index] >= rigids_.size()) return nullptr;
    RigidMotions& motions = rigids_[numbers_[index]];
    return motions.body == &object ? &motions : nullptr;
  }

  void addTouched(const btCollisionObject& object, const btCollisionObject& touched) {
    if (RigidMotions* motions = find(object))
      motions->box.extend(
          Vector3d(tick_ * velocityOf(touched, touched.getWorldTransform().getOrigin(), tick_)));
  }

  double tick_;
  std::vector<RigidMotions>& rigids_;
  std::vector<std::uint32_t>& numbers_;
};

// --- may they meet? ----------------------------------------------------------------------------------------

Extent extentOf(const AlignedBox3d& box, const Vector3d& direction) {
  const double middle = direction.dot(box.center()), half = 0.5 * direction.cwiseAbs().dot(box.sizes());
  return {middle - half, middle + half};
}

Extent extentOf(const Points& points, const Vector3d& direction) {
  Extent all{SweptBox::kEmpty, -SweptBox::kEmpty};
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const double at = direction.dot(points.col(i));
    all = {std::min(all.low, at), std::max(all.high, at)};
  }
  return all;
}

/// Returns the extent while it is displaced within a box.
Extent displaced(const Extent& extent, const AlignedBox3d& displacement, const Vector3d& direction) {
  const Extent moved = extentOf(displacement, direction);
  return {extent.low + std::min(0.0, moved.low), extent.high + std::max(0.0, moved.high)};
}

bool separates(const SeparatingAxis& s, const AlignedBox3d& motionsOfA, const AlignedBox3d& motionsOfB) {
  const Extent a = displaced(s.a, motionsOfA, s.direction), b = displaced(s.b, motionsOfB, s.direction);
  return a.low > b.high || b.low > a.high;
}

/// Returns whether two surfaces, without their radii, may meet if each moves by a displacement (m) in its
/// box: whether their extents along 13 directions do. If not, sets `found`. Overlaps of the radii alone are
/// found in the next tick.
bool mayMeet(const MovingSurface& a, const AlignedBox3d& motionsOfA, const MovingSurface& b,
             const AlignedBox3d& motionsOfB, SeparatingAxis& found) {
  // one of each two opposite ones of the 26 directions to the neighbours of a cell
  for (int i = 14; i < 27; ++i) {
    const Eigen::Vector3i cell(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const Vector3d direction = cell.cast<double>().normalized();
    found = {true, direction, extentOf(*a.position, direction), extentOf(*b.position, direction)};
    if (separates(found, motionsOfA, motionsOfB)) return false;
  }
  found.isKnown = false;
  return true;
}

// --- the pairs ---------------------------------------------------------------------------------------------

bool isBetweenMovingBodies(const SurfaceCandidate& m) { return !m.held && m.other != m.body; }

/// `axis` is what separated the pair in an earlier round; it is renewed.
bool mayTouchNow(const SurfaceCandidate& m, Motions& motions, double tick, SurfaceSearch& search,
                 SeparatingAxis& axis) {
  const AlignedBox3d &a = motions.of(*m.body), &b = motions.ofOther(m);
  if (axis.isKnown && separates(axis, a, b)) return false;
  const MovingSurface& other = m.other ? m.other->surface.moving : m.part->moving;
  return mayMeet(m.body->surface.moving, a, other, b, axis) && mayTouch(m, tick, search);
}

/// Moves the pairs that may touch now to found.candidates. Returns whether there are any.
bool takeStopped(Motions& motions, TickContacts& found, SurfaceSearch& search) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found.waiting.size(); ++i) {
    SurfaceCandidate& m = found.waiting[i];
    m.stopped = motions.ofBoth(m).diagonal().norm();
    if (mayTouchNow(m, motions, found.tick, search, search.axes[i])) {
      if (m.partner) found.add(*m.partner);
      found.candidates.push_back(m);
    } else {
      search.axes[kept] = search.axes[i];
      found.waiting[kept++] = m;
    }
  }
  const bool any = kept < found.waiting.size();
  found.waiting.resize(kept);
  return any;
}

}  // namespace

void addStoppedPairs(btDispatcher& dispatcher, TickContacts& found, SurfaceSearch& search) {
  if (found.waiting.empty()) return;
  Motions motions(found.tick, search);
  search.axes.assign(found.waiting.size(), SeparatingAxis());
  for (const SurfaceCandidate& m : found.waiting) motions.start(m);
  for (const SurfaceCandidate& m : found.candidates)
    if (isBetweenMovingBodies(m)) motions.start(m);
  motions.addManifolds(dispatcher);
  for (bool grown = true; grown;) {
    grown = false;
    for (const SurfaceCandidate& m : found.candidates)
      if (isBetweenMovingBodies(m)) grown = motions.join(m) || grown;
    grown = takeStopped(motions, found, search) || grown;
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

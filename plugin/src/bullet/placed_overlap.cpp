// SPDX-License-Identifier: Zlib
// Gets a body out of a solid at rest into which it has been placed: all points along one direction, since the
// nearest faces would push different points to different sides. Points on the far side of a thin solid pass
// through it on their way.
#include "bullet/bullet_objects.h"
#include "bullet/point_contacts.h"
#include "bullet/soft_body_data.h"
#include "bullet/surface_body.h"
#include "solver/held_surface.h"

#include <algorithm>
#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Returns the nearest point on the only solid of a partner.
HeldPoint nearestOnSolid(const SoftBodyData& body, const HeldPartner& held, std::uint32_t i) {
  const HeldPiece* piece = body.held.pieces.data() + held.solid;
  return nearestOn(piece, piece + 1, body.state.position.col(i));
}

/// Returns the place between two at which the height over a solid, a convex function, is least.
Vector3d deepestBetween(const HeldPiece& solid, Vector3d from, Vector3d to) {
  constexpr int kSteps = 24;  // to 6e-5 of the distance
  const auto heightAt = [&](const Vector3d& x) { return nearestOn(&solid, &solid + 1, x).height; };
  for (int step = 0; step < kSteps; ++step) {
    const Vector3d third = (to - from) / 3.0;
    if (heightAt(from + third) < heightAt(to - third))
      to -= third;
    else
      from += third;
  }
  return 0.5 * (from + to);
}

/// Whether the place is in the body. Its boxes are fitted.
bool isInBody(const SoftBodyData& body, const Vector3d& place, double depth) {
  const NearestOnSurface nearest = nearestOnSurface(body.surface.moving, place, HUGE_VAL);
  return nearest.behind && nearest.distance > depth;
}

/// Whether an edge of the body's surface passes from one side of a solid to the other, somewhere deeper in it
/// than `deepest` (m, below 0). One that lies on a round solid is between ends on the same side.
bool passesThrough(const SoftBodyData& body, const HeldPartner& held, const Edge& edge, double deepest) {
  const auto [a, b] = edge;
  const Vector3d from = body.state.position.col(a), to = body.state.position.col(b);
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
bool overlaps(const SoftBodyData& body, const HeldPartner& held, const Vector3d& middle) {
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
  const auto consider = [&](const Vector3d& direction) {
    if (!(direction.norm() > 0.0)) return;
    const Vector3d unit = direction.normalized();
    const btVector3 farthest = pose * shape.localGetSupportingVertex(toBullet(unit) * pose.getBasis());
    const double end = unit.dot(toEigen(farthest));
    const double way = end - (unit.transpose() * body.state.position).minCoeff();
    if (way < shortest) shortest = way, held.out = unit, held.end = end;
  };
  consider(body.state.position.rowwise().mean() - toEigen(pose.getOrigin()));
  for (int k = 0; k < 3; ++k) {
    const Vector3d axis = toEigen(pose.getBasis().getColumn(k));
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
  const Vector3d x = body.state.position.col(i);
  const double ahead = held.end - held.out.dot(x);
  if (!(ahead > 0.0)) return false;
  const HeldPiece& solid = body.held.pieces[held.solid];
  const Vector3d place = deepestBetween(solid, x, x + ahead * held.out);
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

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

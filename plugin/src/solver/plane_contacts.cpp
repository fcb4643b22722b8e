// SPDX-License-Identifier: Zlib
#include "solver/plane_contacts.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// Sweeps over the rows of a point between two or three surfaces.
constexpr int kSweepsInCorners = 8;

/// Within a substep.
constexpr int kMaxFlights = 8;

/// Brings the point's normal speed relative to the surface up to `target`; friction against sliding.
inline void applyRow(PlaneContact& row, const PointView& points, double target) {
  auto velocity = points.velocityOf(row.point);
  const Eigen::Vector3d relative = velocity - row.surfaceVelocity;
  const double speed = row.normal.dot(relative);
  row.touching = speed < target && row.mass > 0.0;
  if (!row.touching) return;
  const double normalImpulse = (target - speed) * row.mass;
  Eigen::Vector3d impulse = normalImpulse * row.normal;
  if (row.friction > 0.0) {
    // what stops the sliding altogether, if friction can give so much; no root while it sticks
    Eigen::Vector3d positionImpulse = (speed * row.normal - relative) * row.mass;
    const double most = row.friction * normalImpulse, squared = positionImpulse.squaredNorm();
    if (squared > most * most) positionImpulse *= most / std::sqrt(squared);
    impulse += positionImpulse;
  }
  velocity += points.inverseMassOf(row.point).cwiseProduct(impulse);
  row.impulse.add(impulse, row.normal, normalImpulse);
}

inline double speedAlong(const PlaneContact& row, const PointView& points) {
  return row.normal.dot(points.velocityOf(row.point) - row.surfaceVelocity);
}

/// Sets what the point needs before a drift of dt from `time`. What would meet the surface in it parts by
/// Newton's law of restitution.
inline void aimRow(PlaneContact& row, const PointView& points, double time, double dt) {
  const double gap = row.normal.dot(points.positionOf(row.point) - row.touch - time * row.surfaceVelocity);
  row.target = gap >= 0.0 ? -gap / dt : std::min(-kRecovery * gap / dt, row.recoverySpeed);
  row.bounces = false;
  if (!(row.restitution > 0.0)) return;
  const double approach = -speedAlong(row, points);
  if (!(gap < approach * dt)) return;
  const double before = row.normal.dot(row.surfaceVelocity - row.settled);
  const Bounce bounce = bounceOf(gap, approach, before, row.restitution, row.bounceThreshold, dt);
  if (bounce.rests) return;
  row.bounces = true;
  row.target = gap < 0.0 ? std::max(bounce.mean, row.target) : bounce.mean;
  row.rebound = bounce.rebound;
}

/// The second half of a bounce, which is an impulse along the normal or against it.
inline void finishBounce(PlaneContact& row, const PointView& points) {
  if (row.rebound > 0.0) return applyRow(row, points, speedAlong(row, points) + row.rebound);
  const double size = row.rebound * row.mass;
  const Eigen::Vector3d impulse = size * row.normal;
  points.velocityOf(row.point) += points.inverseMassOf(row.point).cwiseProduct(impulse);
  row.impulse.add(impulse, row.normal, size);
}

/// Of the radius: how far beyond a point's way surfaces are followed, since other contacts push it there; and
/// how near a surface is that bears the point at the end of a substep.
constexpr double kFollowBeyond = 1.0 / 3.0, kBearing = 0.01;

double massAlongNormal(const PlaneContact& row, const PointView& points) {
  const double mobility = row.normal.dot(points.inverseMassOf(row.point).cwiseProduct(row.normal));
  return mobility > 0.0 && !row.coupled && !row.away ? 1.0 / mobility : 0.0;
}

HeldNeighbourhood* neighbourhoodOf(const PlaneContact* rows, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].around) return rows[i].around;
  return nullptr;
}

/// The row without a contact whose plane was most like this one's, or nullptr.
PlaneContact* rowFor(const HeldContact& c, PlaneContact* rows, std::size_t count) {
  PlaneContact* best = nullptr;
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].around && rows[i].away && rows[i].owner == c.owner)
      if (!best || rows[i].normal.dot(c.normal) > best->normal.dot(c.normal)) best = rows + i;
  return best;
}

/// Of most points: one plane that stays.
bool isLonePlane(const PlaneContact* rows, std::size_t count) { return count == 1 && !rows->around; }

/// Calls visit(rows, count) for each point.
template <class Visit>
void forEachPoint(std::vector<PlaneContact>& rows, Visit visit) {
  PlaneContact *first = rows.data(), *last = first + rows.size();
  for (PlaneContact* end = first; first != last; first = end) {
    do ++end;
    while (end != last && end->point == first->point);
    visit(first, static_cast<std::size_t>(end - first));
  }
}

void follow(PlaneContact* rows, std::size_t count, const PointView& points, double dt, double beyond) {
  if (const HeldNeighbourhood* around = neighbourhoodOf(rows, count))
    followSurface(rows, count, points, dt * points.velocityOf(rows->point), beyond * around->radius);
}

void stopPoint(PlaneContact* rows, std::size_t count, const PointView& points, double time, double dt) {
  follow(rows, count, points, dt, kFollowBeyond);
  bool changes = true;
  for (int sweep = 0; sweep < (count > 1 ? kSweepsInCorners : 1) && changes; ++sweep) {
    changes = false;
    for (std::size_t i = 0; i < count; ++i) {
      PlaneContact& row = rows[i];
      if (sweep == 0) aimRow(row, points, time, dt);
      const bool before = sweep > 0 && row.touching;
      applyRow(row, points, row.target);
      changes = changes || row.touching;
      row.touching = row.touching || before;
    }
  }
}

/// Of the surfaces that have been followed to where the point is now.
void touchWhatIsNear(PlaneContact* rows, std::size_t count, const PointView& points) {
  for (std::size_t i = 0; i < count; ++i) {
    PlaneContact& row = rows[i];
    if (!row.around) continue;
    const double gap = row.normal.dot(points.positionOf(row.point) - row.touch);
    row.touching = !row.away && (row.touching || gap <= kBearing * row.around->radius);
  }
}

void settlePoint(PlaneContact* rows, std::size_t count, const PointView& points) {
  bool touches = false;
  for (std::size_t i = 0; i < count; ++i)
    touches = touches || rows[i].touching || (rows[i].coupled && rows[i].around);
  if (!touches) return;
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].touching && rows[i].bounces) finishBounce(rows[i], points);
  follow(rows, count, points, 0.0, kBearing);
  touchWhatIsNear(rows, count, points);
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].touching && !rows[i].bounces) applyRow(rows[i], points, 0.0);
}

}  // namespace

ContactRange contactsOfPoint(const std::vector<PlaneContact>& rows, std::uint32_t point) {
  const auto isBefore = [](const PlaneContact& row, std::uint32_t i) { return row.point < i; };
  const auto first = std::lower_bound(rows.begin(), rows.end(), point, isBefore);
  auto end = first;
  while (end != rows.end() && end->point == point) ++end;
  return {static_cast<std::size_t>(first - rows.begin()), static_cast<std::size_t>(end - rows.begin())};
}

void followSurface(PlaneContact* rows, std::size_t count, const PointView& points,
                   const Eigen::Vector3d& displacement, double within) {
  HeldNeighbourhood* around = neighbourhoodOf(rows, count);
  if (!around) return;
  findContacts(*around, points.positionOf(rows->point), displacement, within);
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].around) rows[i].away = true, rows[i].mass = 0.0;
  for (const HeldContact& c : around->all->contacts) {
    PlaneContact* row = rowFor(c, rows, count);
    if (!row) continue;
    row->away = false;
    row->normal = c.normal;
    row->touch = c.touch;
    row->mass = massAlongNormal(*row, points);
  }
}

void followSurfaces(std::vector<PlaneContact>& rows, const PointView& points, double dt) {
  forEachPoint(
      rows, [&](PlaneContact* first, std::size_t count) { follow(first, count, points, dt, kFollowBeyond); });
}

void prepareContacts(std::vector<PlaneContact>& rows, const PointView& points) {
  for (PlaneContact& row : rows) {
    row.mass = massAlongNormal(row, points);
    row.settled = points.velocityOf(row.point);
  }
}

Bounce bounceOf(double gap, double approach, double before, double restitution, double slow, double dt) {
  const double displacement = std::max(gap, 0.0);
  const double kick = approach - before, pressing = 2.0 * kick / dt;
  // below 0 by rounding alone: it gets there within the substep
  const double impact = std::sqrt(std::max(0.0, before * before + 2.0 * pressing * displacement));
  double speed = restitution * impact;
  double rest =
      dt - (displacement > 0.0 ? std::min(dt, 2.0 * displacement / (approach - kick + impact)) : 0.0);
  if (!(impact > slow)) return {};
  for (int flights = 0; pressing * rest > 2.0 * speed; ++flights) {
    if (restitution < 1.0 && (flights == kMaxFlights || !(speed > slow))) return {};
    const double flight = 2.0 * speed / pressing;
    rest -= restitution < 1.0 ? flight : flight * std::floor(rest / flight);
    speed *= restitution;
  }
  const double mean = (speed * rest - 0.5 * pressing * rest * rest - displacement) / dt;
  return {false, mean, speed - pressing * rest + kick - mean};
}

void solvePositions(std::vector<PlaneContact>& rows, const PointView& points, double time, double dt) {
  forEachPoint(rows, [&](PlaneContact* first, std::size_t count) {
    if (!isLonePlane(first, count)) return stopPoint(first, count, points, time, dt);
    aimRow(*first, points, time, dt);
    applyRow(*first, points, first->target);
  });
}

void solveVelocities(std::vector<PlaneContact>& rows, const PointView& points) {
  forEachPoint(rows, [&](PlaneContact* first, std::size_t count) {
    if (!isLonePlane(first, count)) return settlePoint(first, count, points);
    if (!first->touching) return;
    if (first->bounces) return finishBounce(*first, points);
    applyRow(*first, points, 0.0);
  });
  for (PlaneContact& row : rows)
    if (row.restitution > 0.0) row.settled = points.velocityOf(row.point);
}

}  // namespace limber

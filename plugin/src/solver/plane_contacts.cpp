// SPDX-License-Identifier: Zlib
#include "solver/plane_contacts.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// Sweeps over the rows of a point between two or three surfaces.
constexpr int kSweepsInCorners = 8;

/// Bounces within a substep; a point with more of them rests.
constexpr int kMaxBounces = 8;

/// Brings the point's normal speed relative to the surface up to `target`, with friction against sliding.
inline void applyRow(PlaneContact& row, const PointView& points, double target) {
  auto velocity = points.velocityOf(row.point);
  const Eigen::Vector3d relative = velocity - row.surfaceVelocity - row.time * row.surfaceAcceleration;
  const double speed = row.normal.dot(relative);
  row.touching = speed < target && row.mass > 0.0;
  if (!row.touching) return;
  Eigen::Vector3d impulse;
  const double along = kernel::contactImpulse(row.normal.data(), relative.data(), speed, target, row.mass,
                                              row.friction, impulse.data());
  velocity += points.inverseMassOf(row.point).cwiseProduct(impulse);
  row.impulse.add(impulse, row.normal, along);
}

inline double speedAlong(const PlaneContact& row, const PointView& points) {
  return row.normal.dot(points.velocityOf(row.point) - row.surfaceVelocity);
}

/// Sets the target speed of the point before a drift of dt from `time`.
inline void setTarget(PlaneContact& row, const PointView& points, double time, double dt) {
  const double gap = row.normal.dot(points.positionOf(row.point) - row.touch - time * row.surfaceVelocity);
  row.target = minSpeed(gap, row.recoverySpeed, dt);
  row.time = time + 0.5 * dt;
  row.bounces = false;
  if (!(row.restitution > 0.0)) return;
  const double before = row.normal.dot(row.surfaceVelocity - row.lastVelocity);
  addBounce(row, row, gap, -speedAlong(row, points), before, dt);
}

/// Applies the second half of a bounce, an impulse along the normal or against it.
inline void finishBounce(PlaneContact& row, const PointView& points) {
  if (row.rebound > 0.0) return applyRow(row, points, row.speedAfter(speedAlong(row, points)));
  const double size = row.rebound * row.mass;
  const Eigen::Vector3d impulse = size * row.normal;
  points.velocityOf(row.point) += points.inverseMassOf(row.point).cwiseProduct(impulse);
  row.impulse.add(impulse, row.normal, size);
}

/// Shares of the radius. Surfaces are followed to the first distance beyond a point's displacement, since
/// other contacts may push it there. Surfaces within the second support the point at the end of a substep.
constexpr double kSearchBeyond = 1.0 / 3.0, kSupportDistance = 0.01;

double massAlongNormal(const PlaneContact& row, const PointView& points) {
  const double mobility = row.normal.dot(points.inverseMassOf(row.point).cwiseProduct(row.normal));
  return mobility > 0.0 && !row.coupled && !row.away ? 1.0 / mobility : 0.0;
}

HeldNeighbourhood* neighbourhoodOf(const PlaneContact* rows, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].around) return rows[i].around;
  return nullptr;
}

/// Returns the unused row of the contact's owner whose plane was most similar to the contact's, or nullptr.
PlaneContact* unusedRowFor(const HeldContact& c, PlaneContact* rows, std::size_t count) {
  PlaneContact* best = nullptr;
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].around && rows[i].away && rows[i].owner == c.owner)
      if (!best || rows[i].normal.dot(c.normal) > best->normal.dot(c.normal)) best = rows + i;
  return best;
}

/// Sets the row's plane to that of the contact.
void setPlane(PlaneContact& row, const HeldContact& c, const PointView& points) {
  row.away = c.normal.dot(row.facing) < 0.0;
  row.normal = c.normal;
  row.surfaceVelocity -= c.normal.dot(row.surfaceVelocity) * c.normal;
  row.touch = c.touch;
  row.mass = massAlongNormal(row, points);
}

/// The case of most points: one fixed plane.
bool isSingleFixedPlane(const PlaneContact* rows, std::size_t count) { return count == 1 && !rows->around; }

/// Calls visit(rows, count) for each point.
template <class Visit>
void forEachPoint(ContactRows rows, Visit visit) {
  PlaneContact* first = rows.first;
  for (PlaneContact* end = first; first != rows.last; first = end) {
    do ++end;
    while (end != rows.last && end->point == first->point);
    visit(first, static_cast<std::size_t>(end - first));
  }
}

void follow(PlaneContact* rows, std::size_t count, const PointView& points, double dt, double beyond) {
  if (const HeldNeighbourhood* around = neighbourhoodOf(rows, count))
    followSurface(rows, count, points, dt * points.velocityOf(rows->point), beyond * around->radius);
}

void solvePointPosition(PlaneContact* rows, std::size_t count, const PointView& points, double time,
                        double dt) {
  follow(rows, count, points, dt, kSearchBeyond);
  bool changes = true;
  for (int sweep = 0; sweep < (count > 1 ? kSweepsInCorners : 1) && changes; ++sweep) {
    changes = false;
    for (std::size_t i = 0; i < count; ++i) {
      PlaneContact& row = rows[i];
      if (sweep == 0) setTarget(row, points, time, dt);
      const bool before = sweep > 0 && row.touching;
      applyRow(row, points, row.target);
      changes = changes || row.touching;
      row.touching = row.touching || before;
    }
  }
}

/// Sets `touching` for surfaces that have been followed to the present position of the point.
void updateTouching(PlaneContact* rows, std::size_t count, const PointView& points) {
  for (std::size_t i = 0; i < count; ++i) {
    PlaneContact& row = rows[i];
    if (!row.around) continue;
    const double gap = row.normal.dot(points.positionOf(row.point) - row.touch);
    row.touching = !row.away && (row.touching || gap <= kSupportDistance * row.around->radius);
  }
}

void solvePointVelocity(PlaneContact* rows, std::size_t count, const PointView& points) {
  bool touches = false;
  for (std::size_t i = 0; i < count; ++i)
    touches = touches || rows[i].touching || (rows[i].coupled && rows[i].around);
  if (!touches) return;
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].touching && rows[i].bounces) finishBounce(rows[i], points);
  follow(rows, count, points, 0.0, kSupportDistance);
  updateTouching(rows, count, points);
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].touching && !rows[i].bounces) applyRow(rows[i], points, 0.0);
}

}  // namespace

bool areFixedPlanes(const std::vector<PlaneContact>& rows) {
  const auto isOther = [](const PlaneContact& row) { return row.around || row.restitution > 0.0; };
  const auto haveOnePoint = [](const PlaneContact& a, const PlaneContact& b) { return a.point == b.point; };
  return std::none_of(rows.begin(), rows.end(), isOther) &&
         std::adjacent_find(rows.begin(), rows.end(), haveOnePoint) == rows.end();
}

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
  if (count == 1 && isSingleSolid(*around)) {
    HeldContact c;
    if (findContact(*around, points.positionOf(rows->point), displacement, within, c))
      setPlane(*rows, c, points);
    else
      rows->away = true, rows->mass = 0.0;
    return;
  }
  findContacts(*around, points.positionOf(rows->point), displacement, within);
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].around) rows[i].away = true, rows[i].mass = 0.0;
  for (const HeldContact& c : around->contacts) {
    if (PlaneContact* row = unusedRowFor(c, rows, count)) setPlane(*row, c, points);
  }
}

void followSurfaces(std::vector<PlaneContact>& rows, const PointView& points, double dt) {
  forEachPoint(
      rows, [&](PlaneContact* first, std::size_t count) { follow(first, count, points, dt, kSearchBeyond); });
}

void prepareContacts(std::vector<PlaneContact>& rows, const PointView& points) {
  for (PlaneContact& row : rows) {
    row.mass = massAlongNormal(row, points);
    row.lastVelocity = points.velocityOf(row.point);
  }
}

Bounce bounceOf(double gap, double approach, double before, double restitution, double slow, double dt) {
  const double distance = std::max(gap, 0.0);
  const double kick = approach - before, pressing = 2.0 * kick / dt;
  // the sum is negative by rounding only: the point hits the surface within the substep
  const double impact = std::sqrt(std::max(0.0, before * before + 2.0 * pressing * distance));
  double speed = restitution * impact;
  double timeLeft = dt - (distance > 0.0 ? std::min(dt, 2.0 * distance / (approach - kick + impact)) : 0.0);
  if (!(impact > slow)) return {};
  for (int bounces = 0; pressing * timeLeft > 2.0 * speed; ++bounces) {
    if (restitution < 1.0 && (bounces == kMaxBounces || !(speed > slow))) return {};
    const double flightTime = 2.0 * speed / pressing;
    timeLeft -= restitution < 1.0 ? flightTime : flightTime * std::floor(timeLeft / flightTime);
    speed *= restitution;
  }
  const double mean = (speed * timeLeft - 0.5 * pressing * timeLeft * timeLeft - distance) / dt;
  const double after = speed - pressing * timeLeft;
  return {false, mean, after + kick - mean, std::max(restitution * impact, after)};
}

void addBounce(ContactTarget& target, const ContactBase& contact, double gap, double approach, double before,
               double dt) {
  if (!(gap < approach * dt)) return;
  const Bounce bounce = bounceOf(gap, approach, before, contact.restitution, contact.bounceThreshold, dt);
  if (bounce.rests) return;
  target = {gap < 0.0 ? std::max(bounce.mean, target.target) : bounce.mean, bounce.rebound, bounce.fastest,
            true};
}

void solvePositions(ContactRows rows, const PointView& points, double time, double dt) {
  forEachPoint(rows, [&](PlaneContact* first, std::size_t count) {
    if (!isSingleFixedPlane(first, count)) return solvePointPosition(first, count, points, time, dt);
    setTarget(*first, points, time, dt);
    applyRow(*first, points, first->target);
  });
}

void solveVelocities(ContactRows rows, const PointView& points) {
  forEachPoint(rows, [&](PlaneContact* first, std::size_t count) {
    if (!isSingleFixedPlane(first, count)) return solvePointVelocity(first, count, points);
    if (!first->touching) return;
    if (first->bounces) return finishBounce(*first, points);
    applyRow(*first, points, 0.0);
  });
  for (PlaneContact* row = rows.first; row != rows.last; ++row)
    if (row->restitution > 0.0) row->lastVelocity = points.velocityOf(row->point);
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "core/contact_rows.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// Sweeps over the rows of a point between two or three surfaces.
constexpr int kSweepsInCorners = 8;

/// Brings the point's normal speed relative to the surface up to `target`; friction against sliding.
inline void applyRow(ContactRow& row, const PointView& points, double target) {
  auto velocity = points.velocityOf(row.point);
  const Eigen::Vector3d relative = velocity - row.surfaceVelocity;
  const double speed = row.normal.dot(relative);
  row.touching = speed < target && row.mass > 0.0;
  if (!row.touching) return;
  const double normalImpulse = (target - speed) * row.mass;
  Eigen::Vector3d impulse = normalImpulse * row.normal;
  if (row.friction > 0.0) {
    // what stops the sliding altogether, if friction can give so much; no root while it sticks
    Eigen::Vector3d stopping = (speed * row.normal - relative) * row.mass;
    const double most = row.friction * normalImpulse, squared = stopping.squaredNorm();
    if (squared > most * most) stopping *= most / std::sqrt(squared);
    impulse += stopping;
  }
  velocity += points.inverseMassOf(row.point).cwiseProduct(impulse);
  row.impulse += impulse;
}

/// m/s that the point needs before a drift of dt from `time`. What would meet the surface in it parts by
/// Newton's law of restitution.
inline double targetOf(const ContactRow& row, const PointView& points, double time, double dt) {
  const double gap = row.normal.dot(points.positionOf(row.point) - row.touch - time * row.surfaceVelocity);
  if (row.restitution > 0.0) {
    const double approach = row.normal.dot(row.surfaceVelocity - points.velocityOf(row.point));
    if (approach > kLeastBounce && gap < approach * dt) return row.restitution * approach;
  }
  return gap >= 0.0 ? -gap / dt : std::min(-kRecovery * gap / dt, row.recoverySpeed);
}

bool pointsHaveOneRowEach(const std::vector<ContactRow>& rows) {
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].point == rows[i - 1].point) return false;
  return true;
}

}  // namespace

RowRange rowsOfPoint(const std::vector<ContactRow>& rows, std::uint32_t point) {
  const auto isBefore = [](const ContactRow& row, std::uint32_t i) { return row.point < i; };
  const auto first = std::lower_bound(rows.begin(), rows.end(), point, isBefore);
  auto end = first;
  while (end != rows.end() && end->point == point) ++end;
  return {static_cast<std::size_t>(first - rows.begin()), static_cast<std::size_t>(end - rows.begin())};
}

void prepareContacts(std::vector<ContactRow>& rows, const PointView& points) {
  for (ContactRow& row : rows) {
    const double mobility = row.normal.dot(points.inverseMassOf(row.point).cwiseProduct(row.normal));
    row.mass = mobility > 0.0 && !row.coupled ? 1.0 / mobility : 0.0;
  }
}

void stopAtContacts(std::vector<ContactRow>& rows, const PointView& points, double time, double dt) {
  const int sweeps = pointsHaveOneRowEach(rows) ? 1 : kSweepsInCorners;
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (ContactRow& row : rows) {
      if (sweep == 0) row.target = targetOf(row, points, time, dt);
      const bool before = sweep > 0 && row.touching;
      applyRow(row, points, row.target);
      row.touching = row.touching || before;
    }
}

void settleContacts(std::vector<ContactRow>& rows, const PointView& points) {
  for (ContactRow& row : rows)
    if (row.touching) applyRow(row, points, 0.0);
}

}  // namespace limber

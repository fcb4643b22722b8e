// SPDX-License-Identifier: Zlib
#include "core/contact_rows.h"

#include <algorithm>

namespace limber {
namespace {

/// Share of a penetration taken back per substep, and the speed (m/s) it may cost at most: a body that was
/// placed inside something must come out, not be thrown out.
constexpr double kRecovery = 0.2;
constexpr double kRecoverySpeed = 0.5;

/// Sweeps over the rows of a point between two or three surfaces.
constexpr int kSweepsInCorners = 8;

/// Brings the point's normal speed relative to the surface up to `target`; friction against sliding.
void applyRow(ContactRow& row, const PointView& points, double target) {
  const Eigen::Vector3d w = points.inverseMassOf(row.point);
  const double mobility = row.normal.dot(w.cwiseProduct(row.normal));
  const Eigen::Vector3d relative = points.velocityOf(row.point) - row.surfaceVelocity;
  const double speed = row.normal.dot(relative);
  row.touching = speed < target && mobility > 0.0;
  if (!row.touching) return;
  const double normalImpulse = (target - speed) / mobility;
  Eigen::Vector3d impulse = normalImpulse * row.normal;
  const Eigen::Vector3d sliding = relative - speed * row.normal;
  const double slidingSpeed = sliding.norm();
  if (slidingSpeed > 0.0 && row.friction > 0.0) {
    const double stopping = slidingSpeed / mobility;
    impulse -= std::min(stopping, row.friction * normalImpulse) / slidingSpeed * sliding;
  }
  points.velocityOf(row.point) += w.cwiseProduct(impulse);
  row.impulse += impulse;
}

bool pointsHaveOneRowEach(const std::vector<ContactRow>& rows) {
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].point == rows[i - 1].point) return false;
  return true;
}

}  // namespace

void stopAtContacts(std::vector<ContactRow>& rows, const PointView& points, double time, double dt) {
  const int sweeps = pointsHaveOneRowEach(rows) ? 1 : kSweepsInCorners;
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (ContactRow& row : rows) {
      const Eigen::Vector3d touch = row.touch + time * row.surfaceVelocity;
      const double gap = row.normal.dot(points.positionOf(row.point) - touch);
      const bool before = sweep > 0 && row.touching;
      applyRow(row, points, gap >= 0.0 ? -gap / dt : std::min(-kRecovery * gap / dt, kRecoverySpeed));
      row.touching = row.touching || before;
    }
}

void settleContacts(std::vector<ContactRow>& rows, const PointView& points) {
  for (ContactRow& row : rows)
    if (row.touching) applyRow(row, points, 0.0);
}

}  // namespace limber

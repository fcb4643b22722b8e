// SPDX-License-Identifier: Zlib
#include "solver/pair_levers.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using ConstMap = Eigen::Map<const Vector3d>;

/// A triangle's share may leave it by so much before its place stays put until the next tick.
constexpr double kMostShare = 1.25;

/// Of the arm of a rigid body's place: what stops it from farther away acts as if it had come nearer.
constexpr double kMostReach = 0.3;

/// Points across a normal that are this much thinner one way than the other, squared, are in a line.
constexpr double kThin = 1e-6;

constexpr std::size_t kMostRowPoints = 6;

/// The points of a row as its axes show them.
struct Places {
  std::size_t count = 0;
  std::array<Vector3d, kMostRowPoints> way;  ///< m, from the middle of the side: along the normal, then across
  Vector3d apart = Vector3d::Zero();      ///< m, from place b to a, likewise
  Matrix2d inverse;                       ///< 1/m^2, of M

  Vector2d lever(std::size_t i) const { return way[i].tail<2>(); }
};

Vector3d vectorInAxes(const PairRow& row, const Vector3d& x) {
  return {ConstMap(row.axes[0]).dot(x), ConstMap(row.axes[1]).dot(x), ConstMap(row.axes[2]).dot(x)};
}

/// The soft points from `first` to `end`.
void addSide(const PairRows& rows, const PairRow& row, std::uint32_t first, std::uint32_t end,
             const Vector3d& origin, Places& places) {
  const std::size_t start = places.count;
  Vector3d middle = Vector3d::Zero();
  for (std::uint32_t i = first; i < end; ++i) {
    const Vector3d x = vectorInAxes(row, ConstMap(rows.levers[i].position) - origin);
    places.apart += rows.points[i].share * x;
    places.way[places.count++] = x;
    middle += x / double(end - first);
  }
  for (std::size_t i = start; i < places.count; ++i) places.way[i] -= middle;
}

/// The inverse of m with eigenvalues below `least` at 1 / (least^2 / value): any function f of a symmetric
/// matrix of two rows is the straight line through f at its eigenvalues, middle -+ half.
Matrix2d cautiousInverse(const Matrix2d& m, double least) {
  const auto inverted = [&](double value) {
    return value > 0.0 ? std::min(1.0 / value, value / (least * least)) : 0.0;
  };
  const double middle = 0.5 * m.trace(), half = std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
  const double low = inverted(middle - half), high = inverted(middle + half);
  const double slope = half > 0.0 ? 0.5 * (high - low) / half : 0.0;
  return 0.5 * (low + high) * Matrix2d::Identity() + slope * (m - middle * Matrix2d::Identity());
}

/// The inverse of M; where levers are shorter than `apart` (m), less: they would have to bear more than the
/// contact.
void invert(Places& places, double apart) {
  Matrix2d m = Matrix2d::Zero();
  for (std::size_t i = 0; i < places.count; ++i) m += places.lever(i) * places.lever(i).transpose();
  const double least = std::max(apart * apart, kThin * m.trace());
  const double middle = 0.5 * m.trace(), determinant = m.determinant();
  const double smallest = middle - std::sqrt(std::max(0.0, middle * middle - determinant));
  places.inverse = smallest > least ? Matrix2d(m.inverse()) : cautiousInverse(m, least);
}

void setShare(PairRows& rows, std::uint32_t i, double share) {
  RowPoint& point = rows.points[i];
  point.share = share;
  for (int k = 0; k < 3; ++k) point.response[k] = share * rows.levers[i].inverseMass[k];
}

/// Makes the places meet across the normal, as far as the soft ones can be moved. `first`: the row's point
/// that places begins with.
void moveShares(PairRows& rows, std::uint32_t first, Places& places) {
  const Vector2d more = places.inverse * places.apart.tail<2>();
  std::array<double, kMostRowPoints> shares;
  for (std::size_t i = 0; i < places.count; ++i) {
    shares[i] = rows.points[first + i].share - places.lever(i).dot(more);
    if (!(std::abs(shares[i]) <= kMostShare)) return;
  }
  for (std::size_t i = 0; i < places.count; ++i) {
    places.apart -= places.lever(i).dot(more) * places.way[i];
    setShare(rows, first + static_cast<std::uint32_t>(i), shares[i]);
  }
}

void setLever(const PairRow& row, const Vector2d& across, RowLever& lever) {
  for (int k = 0; k < 2; ++k) lever.across[k] = across[k];
  for (int k = 0; k < 3; ++k) lever.response[k] = lever.inverseMass[k] * row.axes[0][k];
}

void joinSoft(PairRows& rows, const PairRow& row) {
  const Vector3d origin = ConstMap(rows.levers[row.firstPoint].position);
  Places places;
  addSide(rows, row, row.firstPoint, row.firstOfB, origin, places);
  addSide(rows, row, row.firstOfB, row.endPoint, origin, places);
  invert(places, places.apart[0]);
  moveShares(rows, row.firstPoint, places);
  for (std::size_t i = 0; i < places.count; ++i)
    setLever(row, places.apart[0] * (places.inverse * places.lever(i)), rows.levers[row.firstPoint + i]);
}

void joinRigid(PairRows& rows, const PairRow& row, const PairContact& c) {
  const bool softIsA = c.a.kind == ContactPlace::Kind::Soft;
  RowTurn& turn = rows.turns[row.firstTurn];
  Vector3d arm = softIsA ? c.b.arm : c.a.arm;
  const Vector3d origin = turn.body->position + arm;
  Places places;
  if (softIsA)
    addSide(rows, row, row.firstPoint, row.firstOfB, origin, places);
  else
    addSide(rows, row, row.firstOfB, row.endPoint, origin, places);
  invert(places, 0.0);
  moveShares(rows, softIsA ? row.firstPoint : row.firstOfB, places);
  const double sign = softIsA ? -1.0 : 1.0;
  const double most = kMostReach * arm.norm(), distance = places.apart.norm();
  if (distance > most) places.apart *= most / distance;
  for (int k = 0; k < 3; ++k) arm -= sign * places.apart[k] * ConstMap(row.axes[k]);
  for (int k = 0; k < 3; ++k) {
    const Vector3d speeds = sign * arm.cross(ConstMap(row.axes[k]));
    Eigen::Map<Vector3d>(turn.speeds[k]) = speeds;
    Eigen::Map<Vector3d>(turn.response[k]) = turn.body->inverseInertia * speeds;
  }
}

/// 1/kg: speeds along, across and across both, of one impulse in each of these directions.
Matrix3d mobilityOf(const PairRows& rows, const PairRow& row) {
  const Eigen::Map<const Matrix3d> axes(row.axes[0]);  // its columns
  Matrix3d mobility = Matrix3d::Zero();
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i) {
    const RowPoint& point = rows.points[i];
    const RowLever& lever = rows.levers[i];
    const Vector3d across(0.0, lever.across[0], lever.across[1]);
    const Matrix3d changes =
        ConstMap(point.response).asDiagonal() * axes + ConstMap(lever.response) * across.transpose();
    mobility += (point.share * axes + axes.col(0) * across.transpose()).transpose() * changes;
  }
  for (std::uint32_t i = row.firstTurn; i < row.endTurn; ++i)
    mobility += Eigen::Map<const Matrix3d>(rows.turns[i].speeds[0]).transpose() *
                Eigen::Map<const Matrix3d>(rows.turns[i].response[0]);
  return mobility;
}

}  // namespace

void joinPlaces(PairRows& rows, std::size_t contact) {
  PairRow& row = rows.rows[contact];
  if (row.couple == Couple::Nobody) return;
  if (row.couple == Couple::Soft)
    joinSoft(rows, row);
  else
    joinRigid(rows, row, rows.contacts[contact]);
  // a sweep that takes a row for heavier than it is diverges
  setMobility(row, mobilityOf(rows, row));
}

}  // namespace limber

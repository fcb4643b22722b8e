// SPDX-License-Identifier: Zlib
#pragma once

// The linear system of an implicit Euler substep (implicit_euler.h): rows, springs, iterations.

#include "solver/implicit_euler.h"
#include "solver/verlet_step.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4f;

/// Square of the largest phase (rad) of a spring in a substep, from k dt^2 times the inverse masses of its
/// ends. Contacts are solved with the masses alone, and springs that are much stiffer than that would throw
/// the bodies back.
constexpr double kLargestImplicitPhaseSquared = 500.0;

/// rad: a spring that turns by this much in a substep is as stiff across as along. Its energy is then below
/// that of the linearised step at any turn (Liu, Bargteil, O'Brien, Kavan 2013, equation 6), so that even
/// violent motion cannot gain energy; slow motion would be slowed down.
constexpr double kLargeTurn = 0.25;

/// Bodies that are solved together: one, or all of an island with the rigid bodies that springs, anchors or
/// contacts join to them.
struct Part {
  SolverIsland& group;
  std::size_t begin, end;  ///< bodies
  bool together;           ///< all bodies, and the rigid ones

  PointState& points(std::size_t body) const { return *group.bodies[body].points; }
};

inline Vector4f padded(const Vector3d& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), 0.0f};
}

inline Vector3d unpadded(const Vector4f& v) { return v.head<3>().cast<double>(); }

/// Calls visit(body, firstColumn) for the bodies of the part; returns the number of their points.
template <class Visit>
inline Index forEachBody(const Part& part, Visit visit) {
  Index first = 0;
  for (std::size_t i = part.begin; i < part.end; ++i) {
    visit(part.group.bodies[i], first);
    first += part.points(i).position.cols();
  }
  return first;
}

inline Index pointColumns(const Part& part) {
  return forEachBody(part, [](const SolverBody&, Index) {});
}

inline Index columnOfPoint(const ImplicitSystem& s, const Part& part, std::uint32_t body,
                           std::uint32_t point) {
  return s.firstColumn[body - part.begin] + point;
}

/// The column of a rigid body's velocity; the next one is that of its angular velocity.
inline Index columnOfRigid(const ImplicitSystem& s, std::uint32_t rigid) {
  return s.firstColumn.back() + 2 * Index{rigid};
}

// --- rows -------------------------------------------------------------------------------------------------

inline void beginRow(ImplicitSystem& s, double constant = 0.0, bool external = false) {
  s.rows.push_back({s.terms.size(), s.terms.size(), constant, external});
}

/// Adds q q^T + across 1 to a diagonal block.
inline void addBlock(ImplicitSystem& s, Index column, const Vector3d& q, double across) {
  double* block = s.block.col(column).data();
  block[0] += q[0] * q[0] + across;
  block[1] += q[1] * q[1] + across;
  block[2] += q[2] * q[2] + across;
  block[3] += q[0] * q[1];
  block[4] += q[1] * q[2];
  block[5] += q[2] * q[0];
}

inline void removeBlock(ImplicitSystem& s, Index column, const Vector3d& q) {
  s.block.col(column).head<3>() -= q.cwiseAbs2();
  s.block.col(column).tail<3>() -= Vector3d(q[0] * q[1], q[1] * q[2], q[2] * q[0]);
}

inline void addTerm(ImplicitSystem& s, Index column, const Vector3d& share) {
  s.terms.push_back({static_cast<std::uint32_t>(column), share, padded(share)});
  s.rows.back().endTerm = s.terms.size();
  addBlock(s, column, share, 0.0);
}

/// Returns the impulse along the row at these velocities.
inline double impulseOf(const ImplicitSystem& s, const StiffRow& row, const Points& velocity) {
  double speed = 0.0;
  for (std::size_t t = row.firstTerm; t < row.endTerm; ++t)
    speed += s.terms[t].share.dot(velocity.col(s.terms[t].column));
  return row.constant - speed;
}

inline void apply(const ImplicitSystem& s, const StiffRow& row, double impulse, Points& sum) {
  for (std::size_t t = row.firstTerm; t < row.endTerm; ++t)
    sum.col(s.terms[t].column) += impulse * s.terms[t].share;
}

// --- springs ----------------------------------------------------------------------------------------------

/// A spring at the present positions: its force (N), and its stiffness along it (N/m).
struct SpringSlope {
  double force, along;
};

/// Returns a stiffness (N/m) of at most  kLargestImplicitPhaseSquared / phase,  phase (m/N) being the square
/// of the substep times the inverse masses.
inline double softened(double stiffness, double phase) {
  return stiffness * phase > kLargestImplicitPhaseSquared ? kLargestImplicitPhaseSquared / phase : stiffness;
}

/// Returns the slope at an elongation of `stretch` (m). `phase`: as in softened().
inline SpringSlope slopeOf(const SpringArrays& springs, std::size_t i, double stretch, double phase) {
  const double full = stretch > 0.0 ? springs->extensionStiffness[i] : springs->compressionStiffness[i];
  const double k = softened(full, phase);
  if (!(springs->limit.stiffenStrain > 0.0)) return {k * stretch, k};
  const double beyond = std::abs(stretch) - springs->limit.stiffenStrain * springs.original->restLength[i];
  const double stiffened = softened(full * springs->limit.stiffenFactor, phase);
  if (!(beyond > 0.0)) return {k * stretch, k};
  return {k * stretch + std::copysign((stiffened - k) * beyond, stretch), stiffened};
}

// --- the system -------------------------------------------------------------------------------------------

/// Sets the masses, springs, volumes and links of the part. s.start and s.kicked must be set.
void assembleParts(ImplicitSystem& s, const Part& part, double dt);

/// Adds the contacts and anchors that had an impulse in the last substep, and contacts that would close in
/// this one. `time`: s since the start of the tick.
void addHolds(ImplicitSystem& s, const Part& part, double time, double dt);

/// The inverse of a diagonal block, 0 along held axes.
Matrix3d freeInverse(const ImplicitSystem& s, Index column);

/// Solves for s.step, the change of s.start, by conjugate gradients (Golub, Van Loan 2013, algorithm 11.5.1).
void solveSystem(ImplicitSystem& s, int iterations);

/// Makes the springs that the solution turns by more than kLargeTurn stiffer across. Returns whether there
/// are any: the system must then be solved again.
bool stiffenTurning(ImplicitSystem& s, double dt);

/// Stores the impulses of contacts and anchors at the new velocities (s.start), and sets s.push to those of
/// all external rows. From then on the rows have no impulse.
void finishHolds(ImplicitSystem& s);

/// Takes the impulses from contacts and anchors.
void dropHolds(ImplicitSystem& s);

}  // namespace limber

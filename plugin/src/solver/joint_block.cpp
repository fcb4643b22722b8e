// SPDX-License-Identifier: Zlib
#include "solver/joint_block.h"

#include "solver/contacts.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Root mean square of the rows' widths in L above which sweeps are faster: each solve factors anew.
constexpr double kMostWidth = 64.0;

/// Pivots below this share of the diagonal are rounding errors of rows that depend on those before.
constexpr double kLeastPivot = 1e-9;

bool isInBlock(const JointConstraint& j) {
  return j.contact == JointConstraint::kHeld && j.mass > 0.0 && j.isBilateral();
}

bool haveACommonBody(const JointConstraint& i, const JointConstraint& j) {
  const auto isOf = [&](std::uint32_t body) {
    return body != JointConstraint::kHeld && (body == j.a || body == j.b);
  };
  return isOf(i.a) || isOf(i.b);
}

/// Returns the speed of row i per impulse of row j, by the body of one side of i.
double mobility(std::uint32_t body, const Vector3d& linear, const Vector3d& angular, const JointConstraint& j,
                const LinkedBodies& bodies) {
  if (body == JointConstraint::kHeld || (body != j.a && body != j.b)) return 0.0;
  const RigidState& rigid = bodies.rigids[body];
  const Vector3d move = linear.cwiseProduct(rigid.inverseMass), turn = rigid.inverseInertia * angular;
  double sum = 0.0;
  if (body == j.a) sum += move.dot(j.linearA) + turn.dot(j.angularA);
  if (body == j.b) sum += move.dot(j.linearB) + turn.dot(j.angularB);
  return sum;
}

double mobility(const JointConstraint& i, const JointConstraint& j, const LinkedBodies& bodies) {
  return mobility(i.a, i.linearA, i.angularA, j, bodies) + mobility(i.b, i.linearB, i.angularB, j, bodies);
}

/// Row i of L from its first column on.
double* rowOf(JointBlock& block, std::size_t i) { return block.lower.data() + block.begin[i]; }

/// Replaces row i of A by that of L:  L_ij D_j = A_ij - sum over k < j of L_ik D_k L_jk.
void factorRow(JointBlock& block, std::size_t i) {
  const std::size_t first = block.first[i];
  double* const row = rowOf(block, i);
  for (std::size_t j = first; j < i; ++j) {
    const double* const other = rowOf(block, j);
    const std::size_t otherFirst = block.first[j];
    for (std::size_t k = std::max(first, otherFirst); k < j; ++k)
      row[j - first] -= row[k - first] * other[k - otherFirst];
  }
  double pivot = block.diagonal[i];
  for (std::size_t j = first; j < i; ++j) {
    double& value = row[j - first];
    const double scaled = block.pivots[j] > 0.0 ? value / block.pivots[j] : 0.0;
    pivot -= scaled * value;
    value = scaled;
  }
  block.pivots[i] = pivot > kLeastPivot * block.diagonal[i] ? pivot : 0.0;
}

}  // namespace

void listBlock(std::vector<JointConstraint>& joints, JointBlock& block) {
  block.rows.clear(), block.first.clear();
  block.begin.assign(1, 0);
  double squares = 0.0;
  for (std::uint32_t index = 0; index < joints.size(); ++index) {
    joints[index].inBlock = isInBlock(joints[index]);
    if (!joints[index].inBlock) continue;
    const auto neighbour = std::find_if(block.rows.begin(), block.rows.end(), [&](std::uint32_t other) {
      return haveACommonBody(joints[index], joints[other]);
    });
    const std::size_t first = static_cast<std::size_t>(neighbour - block.rows.begin());
    const std::size_t width = block.rows.size() - first;
    squares += static_cast<double>(width * width);
    block.first.push_back(static_cast<std::uint32_t>(first));
    block.begin.push_back(block.begin.back() + width);
    block.rows.push_back(index);
  }
  const std::size_t n = block.rows.size();
  if (squares > kMostWidth * kMostWidth * static_cast<double>(n)) {
    for (JointConstraint& j : joints) j.inBlock = false;
    block.rows.clear();
    return;
  }
  block.lower.resize(block.begin[n]);
  block.pivots.resize(n), block.diagonal.resize(n), block.change.resize(n);
}

void factorBlock(const std::vector<JointConstraint>& joints, const LinkedBodies& bodies, double softness,
                 JointBlock& block) {
  for (std::size_t i = 0; i < block.rows.size(); ++i) {
    const JointConstraint& joint = joints[block.rows[i]];
    double* const row = rowOf(block, i);
    for (std::size_t j = block.first[i]; j < i; ++j)
      row[j - block.first[i]] = mobility(joint, joints[block.rows[j]], bodies);
    block.diagonal[i] = (1.0 + softness) / joint.mass;
    factorRow(block, i);
  }
}

void solveBlock(JointBlock& block) {
  const std::size_t n = block.rows.size();
  std::vector<double>& x = block.change;
  for (std::size_t i = 0; i < n; ++i) {
    const double* const row = rowOf(block, i);
    for (std::size_t j = block.first[i]; j < i; ++j) x[i] -= row[j - block.first[i]] * x[j];
  }
  for (std::size_t i = 0; i < n; ++i) x[i] = block.pivots[i] > 0.0 ? x[i] / block.pivots[i] : 0.0;
  for (std::size_t i = n; i-- > 0;) {
    const double* const row = rowOf(block, i);
    for (std::size_t j = block.first[i]; j < i; ++j) x[j] -= row[j - block.first[i]] * x[i];
  }
}

}  // namespace limber

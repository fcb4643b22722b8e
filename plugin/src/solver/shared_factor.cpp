// SPDX-License-Identifier: Zlib
#include "solver/shared_factor.h"

#include "solver/midpoint_damping.h"

#include <algorithm>

namespace limber {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

bool equal(const Sparse& a, const Sparse& b) {
  if (a.rows() != b.rows() || a.nonZeros() != b.nonZeros()) return false;
  const auto count = static_cast<std::size_t>(a.nonZeros());
  return std::equal(a.valuePtr(), a.valuePtr() + count, b.valuePtr()) &&
         std::equal(a.innerIndexPtr(), a.innerIndexPtr() + count, b.innerIndexPtr()) &&
         std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.cols() + 1, b.outerIndexPtr());
}

std::shared_ptr<const SharedFactor> makeFactor(Sparse matrix) {
  auto shared = std::make_shared<SharedFactor>();
  shared->factor = factorise(matrix);
  shared->matrix = std::move(matrix);
  return shared;
}

using Entries = std::vector<Eigen::Triplet<double>>;

/// Adds  weight (e_a - e_b)(e_a - e_b)^T,  without what belongs to held points.
void join(std::uint32_t a, std::uint32_t b, double weight, const Points& inverseMass, Entries& entries) {
  const bool heldA = isHeld(inverseMass, a), heldB = isHeld(inverseMass, b);
  if (!heldA) entries.emplace_back(a, a, weight);
  if (!heldB) entries.emplace_back(b, b, weight);
  if (heldA || heldB) return;
  entries.emplace_back(a, b, -weight);
  entries.emplace_back(b, a, -weight);
}

void joinCorners(const TetrahedronVolumes& v, const Points& inverseMass, double h, Entries& entries) {
  for (std::size_t t = 0; t < v.tetrahedra.size(); ++t) {
    const Eigen::Array4d squares = v.restGradientSquares.col(static_cast<Eigen::Index>(t));
    const double factor = 0.25 * h * h * v.modulus / v.restVolume[t];
    for (Eigen::Index i = 0; i < 4; ++i)
      for (Eigen::Index j = 0; j < i; ++j)
        join(v.tetrahedra[t][static_cast<std::size_t>(i)], v.tetrahedra[t][static_cast<std::size_t>(j)],
             0.25 * factor * (2.0 * squares.sum() - squares[i] - squares[j]), inverseMass, entries);
  }
}

}  // namespace

void SharedFactor::solve(Points& b, Points& scratch) const {
  for (Eigen::Index i = 0; i < b.cols(); ++i) scratch.col(factor.place[i]) = b.col(i);
  solveOrdered(factor, scratch.transpose());
  for (Eigen::Index i = 0; i < b.cols(); ++i) b.col(i) = scratch.col(factor.place[i]);
}

Sparse midpointMatrix(const ElasticParts& parts, const Points& inverseMass, double h) {
  Entries entries;
  const SpringArrays& springs = parts.springs;
  for (std::uint32_t i = 0; i < inverseMass.cols(); ++i)
    entries.emplace_back(i, i, isHeld(inverseMass, i) ? 1.0 : massOf(inverseMass, i));
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const double k = std::max(springs.extensionStiffness[s], springs.compressionStiffness[s]);
    const double weight = 0.25 * h * h * k + dampingWeight(springs, inverseMass, s, h);
    join(springs.a[s], springs.b[s], weight, inverseMass, entries);
  }
  if (parts.tetrahedra) joinCorners(*parts.tetrahedra, inverseMass, h, entries);
  Sparse matrix(inverseMass.cols(), inverseMass.cols());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

std::shared_ptr<const SharedFactor> SharedFactors::get(Sparse matrix) {
  known_.erase(std::remove_if(known_.begin(), known_.end(), [](const auto& f) { return f.expired(); }),
               known_.end());
  for (const auto& known : known_)
    if (auto factor = known.lock(); factor && equal(factor->matrix, matrix)) return factor;
  auto factor = makeFactor(std::move(matrix));
  known_.push_back(factor);
  return factor;
}

}  // namespace limber

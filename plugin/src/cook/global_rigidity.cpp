// SPDX-License-Identifier: Zlib
#include "cook/global_rigidity.h"

#include "cook/prime_field.h"
#include "core/random.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <algorithm>
#include <array>

namespace limber {
namespace {

using prime_field::Element;

/// Rows of the rigidity matrix without division by lengths: b - a at b, a - b at a. A stress s of it is in
/// equilibrium when  sum_s stress_s row_s = 0.
struct Framework {
  std::size_t points = 0;
  std::vector<std::array<std::uint32_t, 2>> ends;   ///< #springs
  std::vector<std::array<Element, 3>> differences;  ///< #springs, b - a
};

/// Point numbers that keep the elimination of a matrix with an entry for each spring sparse.
std::vector<std::uint32_t> eliminationOrder(const SpringNetwork& network) {
  const auto count = static_cast<int>(network.restPoints.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < count; ++i) entries.emplace_back(i, i, 1.0);
  for (const NetworkSpring& s : network.springs) {
    entries.emplace_back(static_cast<int>(s.a), static_cast<int>(s.b), 1.0);
    entries.emplace_back(static_cast<int>(s.b), static_cast<int>(s.a), 1.0);
  }
  Eigen::SparseMatrix<double> graph(count, count);
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic> order;
  Eigen::AMDOrdering<int>()(graph, order);
  std::vector<std::uint32_t> place(network.restPoints.size());
  for (int i = 0; i < count; ++i)
    place[static_cast<std::size_t>(order.indices()[i])] = static_cast<std::uint32_t>(i);
  return place;
}

Framework randomPlacement(const SpringNetwork& network, Random& random) {
  std::vector<std::array<Element, 3>> places(network.restPoints.size());
  for (auto& place : places)
    for (Element& x : place) x = prime_field::random(random);
  const std::vector<std::uint32_t> order = eliminationOrder(network);
  Framework framework;
  framework.points = network.restPoints.size();
  for (const NetworkSpring& s : network.springs) {
    framework.ends.push_back({order[s.a], order[s.b]});
    std::array<Element, 3> d{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      d[axis] = prime_field::difference(places[s.b][axis], places[s.a][axis]);
    framework.differences.push_back(d);
  }
  return framework;
}

std::vector<Element> randomVector(std::size_t size, Random& random) {
  std::vector<Element> v(size);
  for (Element& x : v) x = prime_field::random(random);
  return v;
}

/// K = R^T D R with the spring constants D, all of whose ranks of leading blocks are, for random constants,
/// those of the columns of R.
prime_field::Matrix stiffness(const Framework& f, const std::vector<Element>& constants) {
  using namespace prime_field;
  Matrix k(3 * f.points, 3 * f.points);
  for (std::size_t s = 0; s < f.ends.size(); ++s) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const Element entry = product(constants[s], product(f.differences[s][i], f.differences[s][j]));
        for (std::size_t row = 0; row < 2; ++row)
          for (std::size_t column = 0; column < 2; ++column) {
            Element& at = k(3 * f.ends[s][row] + i, 3 * f.ends[s][column] + j);
            at = row == column ? sum(at, entry) : difference(at, entry);
          }
      }
    }
  }
  return k;
}

/// R^T w
std::vector<Element> forces(const Framework& f, const std::vector<Element>& w) {
  using namespace prime_field;
  std::vector<Element> result(3 * f.points, 0);
  for (std::size_t s = 0; s < f.ends.size(); ++s) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Element force = product(w[s], f.differences[s][i]);
      Element &a = result[3 * f.ends[s][0] + i], &b = result[3 * f.ends[s][1] + i];
      a = difference(a, force);
      b = sum(b, force);
    }
  }
  return result;
}

/// What is left of random tensions g once the points have moved into equilibrium:  g - D R x,  K x = R^T g.
std::vector<Element> equilibriumStress(const Framework& f, const std::vector<Element>& constants,
                                       std::vector<Element> g, const std::vector<Element>& x) {
  using namespace prime_field;
  for (std::size_t s = 0; s < f.ends.size(); ++s) {
    Element stretch = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Element apart = difference(x[3 * f.ends[s][1] + i], x[3 * f.ends[s][0] + i]);
      stretch = sum(stretch, product(f.differences[s][i], apart));
    }
    g[s] = difference(g[s], product(constants[s], stretch));
  }
  return g;
}

prime_field::Matrix stressMatrix(const Framework& f, const std::vector<Element>& stress) {
  using namespace prime_field;
  Matrix matrix(f.points, f.points);
  for (std::size_t s = 0; s < f.ends.size(); ++s) {
    const auto [a, b] = f.ends[s];
    matrix(a, a) = sum(matrix(a, a), stress[s]);
    matrix(b, b) = sum(matrix(b, b), stress[s]);
    matrix(a, b) = matrix(b, a) = difference(0, stress[s]);
  }
  return matrix;
}

}  // namespace

bool isGloballyRigid(const SpringNetwork& network, std::uint64_t seed,
                     const std::function<bool(double)>& goOn) {
  const std::size_t points = network.restPoints.size(), springs = network.springs.size();
  if (points <= 4) return springs == points * (points - 1) / 2;
  if (springs <= 3 * points - 6) return false;  // no stress
  Random random(seed);
  const Framework framework = randomPlacement(network, random);
  const std::vector<Element> constants = randomVector(springs, random),
                             tensions = randomVector(springs, random);
  std::vector<Element> x = forces(framework, tensions);
  if (prime_field::solveSymmetric(stiffness(framework, constants), x, goOn) != 3 * points - 6) return false;
  const auto afterSolving = [&](double) { return !goOn || goOn(1.0); };  // the rest takes a tenth as long
  return prime_field::rank(stressMatrix(framework, equilibriumStress(framework, constants, tensions, x)),
                           afterSolving) == points - 4;
}

}  // namespace limber

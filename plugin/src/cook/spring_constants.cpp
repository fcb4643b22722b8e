// SPDX-License-Identifier: Zlib
#include "cook/spring_constants.h"

#include "cook/elastic_moduli.h"
#include "cook/fourth_degree.h"
#include "cook/tetrahedron_faces.h"
#include "mesh/edges.h"

#include <algorithm>
#include <utility>

namespace limber {
namespace {

/// How much staying near Van Gelder's constants counts against the wanted elasticity.
constexpr double kStay = 0.2;

/// Least share of Van Gelder's constant: a weaker spring would hold nothing.
constexpr double kLeastOfVanGelder = 0.2;

/// By how much the springs around a point of the surface are to be stiffer than those inside: the value that
/// makes the Young's modulus of the same body nearly the same on coarse and fine lattices. Without it a cube
/// of 300 points has 0.82 and one of 1200 points 0.90 of what it has inside.
constexpr double kSurfaceFactor = 1.6;

constexpr int kSweeps = 60;

/// Times at most that the elasticity asked for is corrected by the one that the body turns out to have, and
/// the isotropy that is enough.
constexpr int kCorrections = 10;
constexpr double kEnoughIsotropy = 0.96;

struct Edges {
  std::vector<Edge> ends;            ///< #edges, sorted
  std::vector<FourthDegree> powers;  ///< #edges, of their directions
  std::vector<double> vanGelder;     ///< #edges, m^3, the sum of V: the constant for 1 Pa times L^2
  std::vector<double> pointVolumes;  ///< #points, m^3, a quarter of the tetrahedra around
  std::vector<double> factors;       ///< #points, kSurfaceFactor at the surface, else 1
};

Edges collectEdges(const SpringNetwork& network) {
  std::vector<std::pair<Edge, double>> all;
  Edges edges;
  edges.pointVolumes.assign(network.restPoints.size(), 0.0);
  edges.factors.assign(network.restPoints.size(), 1.0);
  for (const Triangle& t : network.surface)
    for (const std::uint32_t point : t) edges.factors[point] = kSurfaceFactor;
  for (const Tetrahedron& t : network.tetrahedra) {
    const double volume = volumeOf(network.restPoints, t);
    for (std::size_t i = 0; i < 4; ++i) {
      edges.pointVolumes[t[i]] += volume / 4.0;
      for (std::size_t j = i + 1; j < 4; ++j)
        all.push_back({edgeBetween(t[i], t[j]), volume});
    }
  }
  std::sort(all.begin(), all.end());
  for (const auto& [ends, volume] : all) {
    if (edges.ends.empty() || ends != edges.ends.back()) {
      edges.ends.push_back(ends);
      edges.vanGelder.push_back(0.0);
      edges.powers.push_back(
          fourthPower((network.restPoints[ends[1]] - network.restPoints[ends[0]]).normalized()));
    }
    edges.vanGelder.back() += volume;
  }
  return edges;
}

/// Changes x = k L^2, one edge after the other, towards the least of
///     sum over points |sum over its edges x T / 2 - f V C|^2 / V  +  stay sum over edges (x - x0)^2 / x0
/// with T the powers, V and f the points' volumes and factors, C the elasticity and x0 Van Gelder's values.
void fitElasticity(const Edges& edges, const FourthDegree& elasticity, std::vector<double>& x) {
  std::vector<FourthDegree> misfit;
  for (std::size_t p = 0; p < edges.pointVolumes.size(); ++p)
    misfit.push_back(-edges.factors[p] * edges.pointVolumes[p] * elasticity);
  const auto add = [&](std::size_t e, double change) {
    for (const std::uint32_t p : edges.ends[e]) misfit[p] += 0.5 * change * edges.powers[e];
  };
  for (std::size_t e = 0; e < x.size(); ++e) add(e, x[e]);
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (std::size_t e = 0; e < x.size(); ++e) {
      double slope = kStay * (x[e] / edges.vanGelder[e] - 1.0), curvature = kStay / edges.vanGelder[e];
      for (const std::uint32_t p : edges.ends[e]) {
        slope += 0.5 * edges.powers[e].dot(misfit[p]) / edges.pointVolumes[p];
        curvature += 0.25 / edges.pointVolumes[p];  // the powers have length 1
      }
      const double next = std::max(x[e] - slope / curvature, kLeastOfVanGelder * edges.vanGelder[e]);
      add(e, next - x[e]);
      x[e] = next;
    }
}

void setSprings(SpringNetwork& network, const Edges& edges, const std::vector<double>& x) {
  const std::vector<Edge> outer = uniqueEdges(network.surface);
  network.springs.clear();
  for (std::size_t e = 0; e < x.size(); ++e) {
    const auto [a, b] = edges.ends[e];
    const bool isOuter = std::binary_search(outer.begin(), outer.end(), edges.ends[e]);
    const double stiffness = x[e] / (network.restPoints[b] - network.restPoints[a]).squaredNorm();
    network.springs.push_back({a, b, isOuter ? SpringKind::Structural : SpringKind::Brace, stiffness});
  }
}

/// The springs have the constants (N/m) for an asked modulus of 1 Pa.
void normalise(SpringNetwork& network, double measuredModulus) {
  double mean = 0.0;
  for (const NetworkSpring& s : network.springs)
    mean += s.stiffnessScale / static_cast<double>(network.springs.size());
  for (NetworkSpring& s : network.springs) s.stiffnessScale /= mean;
  network.stiffnessPerModulus = mean / measuredModulus;
}

}  // namespace

double setMaterialSprings(SpringNetwork& network, const std::function<bool(double)>& goOn) {
  const Edges edges = collectEdges(network);
  const FourthDegree isotropic = isotropicElasticity();
  FourthDegree wanted = isotropic;
  std::vector<double> x = edges.vanGelder, best;
  ElasticModuli bestModuli;
  for (int i = 0; i <= kCorrections; ++i) {
    fitElasticity(edges, wanted, x);
    setSprings(network, edges, x);
    const ElasticModuli moduli = measureModuli({network});
    if (moduli.isotropy > bestModuli.isotropy) {
      best = x;
      bestModuli = moduli;
    }
    if (moduli.isotropy > kEnoughIsotropy || (goOn && !goOn(static_cast<double>(i) / kCorrections))) break;
    wanted += isotropic - symmetricPart(moduli.elasticity) / moduli.youngsModulus;
    wanted *= isotropic.squaredNorm() / isotropic.dot(wanted);  // its shape alone: E is calibrated
  }
  setSprings(network, edges, best);
  normalise(network, bestModuli.youngsModulus);
  return bestModuli.youngsModulus;
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
// Builds networks of tetrahedra with the elasticity of a material: chooses the spring constants, and the
// settings of a body with the requested elasticity.

#include <limber/network_builder.h>

#include "mesh/edges.h"
#include "network/material.h"
#include "network/tetrahedra.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace limber {
namespace {

/// Returns the square roots of the numbers of occurrences of the entries: 1, 4, 6 and 12.
FourthDegree rootsOfCounts() {
  FourthDegree roots;
  roots.head<3>().setOnes();
  roots.segment<6>(3).setConstant(2.0);
  roots.segment<3>(9).setConstant(std::sqrt(6.0));
  roots.tail<3>().setConstant(std::sqrt(12.0));
  return roots;
}

FourthDegree weighted(const FourthDegree& entries) {
  static const FourthDegree roots = rootsOfCounts();
  return entries.cwiseProduct(roots);
}

}  // namespace

FourthDegree fourthPower(const Eigen::Vector3d& n) {
  const double x = n[0], y = n[1], z = n[2], xx = x * x, yy = y * y, zz = z * z;
  FourthDegree t;
  t << xx * xx, yy * yy, zz * zz, xx * x * y, xx * x * z, yy * y * x, yy * y * z, zz * z * x, zz * z * y,
      xx * yy, yy * zz, zz * xx, xx * y * z, yy * z * x, zz * x * y;
  return weighted(t);
}

FourthDegree isotropicElasticity() {
  FourthDegree t = FourthDegree::Zero();
  t.head<3>().setConstant(1.2);
  t.segment<3>(9).setConstant(0.4);
  return weighted(t);
}

FourthDegree symmetricPart(const Eigen::Matrix<double, 6, 6>& c) {
  const auto mean = [](double once, double twice) { return (once + 2.0 * twice) / 3.0; };
  FourthDegree t;
  t << c(0, 0), c(1, 1), c(2, 2), c(0, 5), c(0, 4), c(1, 5), c(1, 3), c(2, 4), c(2, 3),
      mean(c(0, 1), c(5, 5)), mean(c(1, 2), c(3, 3)), mean(c(2, 0), c(4, 4)), mean(c(0, 3), c(4, 5)),
      mean(c(1, 4), c(3, 5)), mean(c(2, 5), c(3, 4));
  return weighted(t);
}

namespace {

/// Weight of the distance from Van Gelder's constants, relative to the error of the elasticity.
constexpr double kStayWeight = 0.2;

/// Smallest fraction of Van Gelder's constant: a weaker spring would have no effect.
constexpr double kMinVanGelderFraction = 0.2;

/// Factor by which the springs around a point of the surface should be stiffer than those inside. With this
/// value, the Young's modulus of one body is nearly the same on coarse and fine lattices. Without it, a cube
/// of 300 points has 0.82 and one of 1200 points 0.90 of the modulus inside.
constexpr double kSurfaceFactor = 1.6;

constexpr int kSweeps = 60;

/// Largest number of corrections of the target elasticity by the measured one, and the isotropy that ends
/// them.
constexpr int kMaxCorrections = 10;
constexpr double kSufficientIsotropy = 0.96;

struct Edges {
  std::vector<Edge> ends;            ///< #edges, sorted
  std::vector<FourthDegree> powers;  ///< #edges, of their directions
  std::vector<double> vanGelder;  ///< #edges, m^3, sum of the volumes around: the constant for 1 Pa times L^2
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
      for (std::size_t j = i + 1; j < 4; ++j) all.push_back({edgeBetween(t[i], t[j]), volume});
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

/// Changes x = k L^2, one edge after the other, towards the minimum of
///     sum over points |sum over its edges x T / 2 - f V C|^2 / V
///     + kStayWeight sum over edges (x - x0)^2 / x0
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
      double slope = kStayWeight * (x[e] / edges.vanGelder[e] - 1.0),
             curvature = kStayWeight / edges.vanGelder[e];
      for (const std::uint32_t p : edges.ends[e]) {
        slope += 0.5 * edges.powers[e].dot(misfit[p]) / edges.pointVolumes[p];
        curvature += 0.25 / edges.pointVolumes[p];  // the powers have length 1
      }
      const double next = std::max(x[e] - slope / curvature, kMinVanGelderFraction * edges.vanGelder[e]);
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

/// Scales the springs, whose constants (N/m) are for a requested modulus of 1 Pa.
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
  FourthDegree target = isotropic;
  std::vector<double> x = edges.vanGelder, best;
  ElasticModuli bestModuli;
  for (int i = 0; i <= kMaxCorrections; ++i) {
    fitElasticity(edges, target, x);
    setSprings(network, edges, x);
    const ElasticModuli moduli = measureModuli({network});
    if (moduli.isotropy > bestModuli.isotropy) {
      best = x;
      bestModuli = moduli;
    }
    if (moduli.isotropy > kSufficientIsotropy || (goOn && !goOn(static_cast<double>(i) / kMaxCorrections)))
      break;
    target += isotropic - symmetricPart(moduli.elasticity) / moduli.youngsModulus;
    target *= isotropic.squaredNorm() / isotropic.dot(target);  // only its shape: E is calibrated
  }
  setSprings(network, edges, best);
  normalise(network, bestModuli.youngsModulus);
  return bestModuli.youngsModulus;
}

namespace {

/// Smallest mass of a point, relative to the mean: the lightest point limits the time step.
constexpr double kMinCornerShare = 0.2;

/// Tolerance of Poisson's ratio, and the largest number of measurements.
constexpr double kPoissonError = 5e-4;
constexpr int kMaxMeasurements = 6;

double volumeOfTetrahedra(const SpringNetwork& network) {
  double volume = 0.0;
  for (const Tetrahedron& t : network.tetrahedra) volume += volumeOf(network.restPoints, t);
  return volume;
}

/// Gives a quarter of each tetrahedron's volume to each of its corners.
std::vector<double> volumeShares(const SpringNetwork& network) {
  std::vector<double> shares(network.restPoints.size(), 0.0);
  const double volume = volumeOfTetrahedra(network);
  for (const Tetrahedron& t : network.tetrahedra)
    for (const std::uint32_t point : t) shares[point] += volumeOf(network.restPoints, t) / (4.0 * volume);
  double sum = 0.0;
  for (double& share : shares) {
    share = std::max(share, kMinCornerShare / static_cast<double>(shares.size()));
    sum += share;
  }
  for (double& share : shares) share /= sum;
  return shares;
}

std::string outOfRange(const char* name, double value, const char* rule) {
  char text[128];
  std::snprintf(text, sizeof text, "%s is %g, must be %s", name, value, rule);
  return text;
}

/// Settings of a body of this network for a Young's modulus of 1 Pa.
struct UnitMaterial {
  double stiffness = 0.0;      ///< m
  double volumeModulus = 0.0;  ///< per Pa
};

/// Springs alone have lambda = mu = 2/5 E; a volume term of modulus K adds K to lambda. With
/// nu = lambda / (2 (lambda + mu)) that is  nu = (mu + K) / (2 (2 mu + K)),  so
/// K = mu (4 nu - 1) / (1 - 2 nu). A network is a little softer than this estimate, so the target nu is
/// corrected by the measured nu.
UnitMaterial findUnitMaterial(const SpringNetwork& network, double poissonRatio,
                              const Eigen::Vector3d& scale) {
  const double mu = 0.4;
  double targetRatio = poissonRatio;
  UnitMaterial unit;
  for (int i = 0; i < kMaxMeasurements; ++i) {
    // computed as if the springs were of 1 Pa; scaled below
    const double modulus = mu * (4.0 * targetRatio - 1.0) / (1.0 - 2.0 * targetRatio);
    const ElasticModuli moduli = measureModuli({network, network.stiffnessPerModulus, modulus, scale});
    unit = {network.stiffnessPerModulus / moduli.youngsModulus, modulus / moduli.youngsModulus};
    const double error = poissonRatio - moduli.poissonRatio;
    if (std::abs(error) < kPoissonError || (targetRatio <= 0.25 && error < 0.0)) break;
    targetRatio = std::clamp(targetRatio + error, 0.25, 0.5 * (targetRatio + 0.5));
  }
  return unit;
}

}  // namespace

Result<void> validate(const Material& m) {
  if (!std::isfinite(m.youngsModulus) || m.youngsModulus <= 0.0)
    return Error{outOfRange("youngsModulus", m.youngsModulus, "above 0")};
  if (!(m.poissonRatio >= 0.25 && m.poissonRatio < 0.5))
    return Error{outOfRange("poissonRatio", m.poissonRatio, "from 0.25 to below 0.5")};
  if (!std::isfinite(m.density) || m.density <= 0.0)
    return Error{outOfRange("density", m.density, "above 0")};
  if (m.dampingTime && !(std::isfinite(*m.dampingTime) && *m.dampingTime >= 0.0))
    return Error{outOfRange("dampingTime", *m.dampingTime, "0 or more")};
  return {};
}

Material Material::jelly() { return {5e4, 0.4, 1000.0, 0.01}; }
Material Material::rubber() { return {1e6, 0.4, 1100.0, 0.003}; }
Material Material::foam() { return {1e5, 0.25, 60.0, 0.02}; }
Material Material::stiff() { return {1e7, 0.3, 1100.0, 0.001}; }

Result<SpringNetwork> fillWithMaterial(const WeldedMesh& welded, const MaterialMesh& settings,
                                       const WeldedMesh* fit) {
  bool going = true;  // once false, it stays false
  const auto reportProgress = [&](const char* what, double done) {
    return going = going && (!settings.progress || settings.progress(what, done));
  };
  if (settings.spacing && !(std::isfinite(*settings.spacing) && *settings.spacing > 0.0))
    return Error{outOfRange("spacing", *settings.spacing, "above 0")};
  if (!reportProgress("tetrahedra", 0.0)) return Error{kEnded};
  const auto fillingProgress = [&](double done) { return reportProgress("tetrahedra", done); };
  Result<TetrahedralMesh> filling = settings.spacing
                                        ? fillWithTetrahedra(welded, *settings.spacing, fit)
                                        : fillWithPoints(welded, settings.points, fillingProgress);
  if (!reportProgress("tetrahedra", 1.0)) return Error{kEnded};
  if (!filling) return Error{filling.error()};
  SpringNetwork network;
  network.restPoints = std::move(filling->points);
  network.tetrahedra = std::move(filling->tetrahedra);
  network.surface = std::move(filling->surface);
  network.report = welded.report;
  network.massFractions = volumeShares(network);
  setMaterialSprings(network, [&](double done) { return reportProgress("spring constants", done); });
  if (!going) return Error{kEnded};
  return network;
}

Result<SharedNetwork> buildMaterialNetwork(const TriangleMesh& mesh, const MaterialMesh& settings) {
  const Result<WeldedMesh> welded = weld(mesh);
  if (!welded) return Error{welded.error()};
  const Result<SpringNetwork> network = fillWithMaterial(*welded, settings);
  if (!network) return Error{network.error()};
  if (settings.progress && !settings.progress("skin", 0.0)) return Error{kEnded};
  Result<SharedNetwork> skinned = withSkin(*network, mesh, {SkinKind::Barycentric, 32, 0.0});
  if (settings.progress && !settings.progress("skin", 1.0)) return Error{kEnded};
  return skinned;
}

Result<SoftBodySettings> withMaterial(const SpringNetwork& network, const Material& material,
                                      SoftBodySettings settings) {
  if (network.tetrahedra.empty() || network.stiffnessPerModulus <= 0.0)
    return Error{"the network has no tetrahedra to be of a material: make it with buildMaterialNetwork"};
  if (Result<void> valid = validate(material); !valid) return Error{valid.error()};
  if (Result<void> valid = validate(settings); !valid) return Error{valid.error()};
  const UnitMaterial unit = findUnitMaterial(network, material.poissonRatio, settings.scale.cwiseAbs());
  settings.extensionStiffness = settings.compressionStiffness = unit.stiffness * material.youngsModulus;
  settings.volumeModulus = unit.volumeModulus * material.youngsModulus;
  if (material.dampingTime) settings.damping = *material.dampingTime * settings.extensionStiffness;
  settings.totalMass = material.density * volumeOfTetrahedra(network) * std::abs(settings.scale.prod());
  if (Result<void> valid = validate(settings); !valid)
    return Error{"a body of this material: " + valid.error()};
  return settings;
}

}  // namespace limber

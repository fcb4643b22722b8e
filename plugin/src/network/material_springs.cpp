// SPDX-License-Identifier: Zlib
// Makes springs of the edges of tetrahedra, with constants that give the network the elasticity of a
// material, and fits these to the response of the solid.

#include "network/material.h"

#include <map>

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

namespace {

/// Weight of the distance from Van Gelder's constants, relative to the error of the elasticity.
constexpr double kStayWeight = 0.2;

constexpr int kSweeps = 60;

/// Limits of a constant as fractions of Van Gelder's, besides the given minimum. A stiffer spring shortens
/// the time step. Springs at the points that limit the time step may grow only by `fast`, others by `most`.
struct Growth {
  double fast, most;
};
constexpr Growth kUsualGrowth{1.15, 1.8};

/// Of bodies that remain too stiff in some response, as bars of two cells in torsion: some of their springs
/// must be much softer, and others stiffer, than Van Gelder's. They need 1.3 to 1.5 times as many substeps.
constexpr Growth kLargeGrowth{2.0, 4.0};
constexpr double kTooStiff = 1.2;

struct Edges {
  std::vector<Edge> ends;            ///< #edges, sorted
  std::vector<FourthDegree> powers;  ///< #edges, of their directions
  std::vector<double> vanGelder;  ///< #edges, m^3, sum of the volumes around: the constant for 1 Pa times L^2
  std::vector<double> squaredLengths;  ///< #edges, m^2
  std::vector<double> pointVolumes;    ///< #points, m^3, a quarter of the tetrahedra around

  void add(const Edge& edge, const Eigen::Vector3d& along, double constant) {
    ends.push_back(edge);
    powers.push_back(fourthPower(along.normalized()));
    vanGelder.push_back(constant);
    squaredLengths.push_back(along.squaredNorm());
  }
};

Edges collectEdges(const SpringNetwork& network) {
  std::vector<std::pair<Edge, double>> all;
  Edges edges;
  edges.pointVolumes.assign(network.restPoints.size(), 0.0);
  for (const Tetrahedron& t : network.tetrahedra) {
    const double volume = volumeOf(network.restPoints, t);
    for (std::size_t i = 0; i < 4; ++i) {
      edges.pointVolumes[t[i]] += volume / 4.0;
      for (std::size_t j = i + 1; j < 4; ++j) all.push_back({edgeBetween(t[i], t[j]), volume});
    }
  }
  std::sort(all.begin(), all.end());
  for (const auto& [ends, volume] : all) {
    if (edges.ends.empty() || ends != edges.ends.back())
      edges.add(ends, network.restPoints[ends[1]] - network.restPoints[ends[0]], 0.0);
    edges.vanGelder.back() += volume;
  }
  return edges;
}

/// Returns x = k L^2 that, changed for one edge after the other, nears the minimum of
///     sum over points |sum over its edges x T / 2 - V C|^2 / V
///     + kStayWeight sum over edges (x - x0)^2 / x0
/// with T the powers, V the points' volumes, C their isotropic elasticities and x0 Van Gelder's values.
std::vector<double> isotropicConstants(const Edges& edges, const std::vector<FourthDegree>& elasticities,
                                       double minGrowth) {
  std::vector<double> x = edges.vanGelder;
  std::vector<FourthDegree> misfit;
  for (std::size_t p = 0; p < edges.pointVolumes.size(); ++p)
    misfit.push_back(-edges.pointVolumes[p] * elasticities[p]);
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
      const double next = std::max(x[e] - slope / curvature, minGrowth * edges.vanGelder[e]);
      add(e, next - x[e]);
      x[e] = next;
    }
  return x;
}

void setSprings(SpringNetwork& network, const Edges& edges, const std::vector<double>& x) {
  const std::vector<Edge> outer = uniqueEdges(network.surface);
  network.springs.clear();
  for (std::size_t e = 0; e < x.size(); ++e) {
    const auto [a, b] = edges.ends[e];
    const bool isOuter = std::binary_search(outer.begin(), outer.end(), edges.ends[e]);
    network.springs.push_back(
        {a, b, isOuter ? SpringKind::Structural : SpringKind::Brace, x[e] / edges.squaredLengths[e]});
  }
}

/// Returns the limits of the springs. The sum of the constants around a point over its mass is a measure of
/// its fastest oscillation. The slower a point, the more its springs may grow.
SpringLimits limitsOf(const Edges& edges, double minGrowth, const Growth& allowed) {
  const auto& volumes = edges.pointVolumes;
  const double points = static_cast<double>(volumes.size());
  const double minVolume = kMinMassShare * std::accumulate(volumes.begin(), volumes.end(), 0.0) / points;
  std::vector<double> speeds(volumes.size(), 0.0);
  for (std::size_t e = 0; e < edges.ends.size(); ++e)
    for (const std::uint32_t p : edges.ends[e])
      speeds[p] += edges.vanGelder[e] / (edges.squaredLengths[e] * std::max(volumes[p], minVolume));
  const double fastest = *std::max_element(speeds.begin(), speeds.end());
  SpringLimits limits;
  for (std::size_t e = 0; e < edges.ends.size(); ++e) {
    const double vanGelder = edges.vanGelder[e] / edges.squaredLengths[e];
    const double growth = fastest / std::max(speeds[edges.ends[e][0]], speeds[edges.ends[e][1]]);
    limits.smallest.push_back(minGrowth * vanGelder);
    limits.largest.push_back(
        std::clamp(allowed.fast / kUsualGrowth.fast * growth, allowed.fast, allowed.most) * vanGelder);
  }
  return limits;
}

/// Fits the springs, and once more with large growth if they need it.
void fitSprings(SpringNetwork& network, const Edges& edges, double minGrowth,
                const std::function<bool(double)>& goOn) {
  bool stopped = false;
  double before = 0.0;  // progress of the first fit
  const auto halfOf = [&](double progress) {
    stopped = goOn && !goOn(before + 0.5 * progress);
    return !stopped;
  };
  const SolidResponses wanted = solidResponses({network.restPoints, network.tetrahedra, network.surface});
  const double stiffest = fitResponses(network, wanted, limitsOf(edges, minGrowth, kUsualGrowth), halfOf);
  before = 0.5;
  if (stiffest > kTooStiff && !stopped)
    fitResponses(network, wanted, limitsOf(edges, minGrowth, kLargeGrowth), halfOf);
}

/// Least isotropy at which the mean modulus over all directions tells how stiff a network is. Thin plates
/// have less: they bend as they were fitted to, and stretch and shear more or less easily.
constexpr double kEven = 0.9;

/// Scales the springs, whose constants (N/m) are for a requested modulus of 1 Pa.
void normalise(SpringNetwork& network, double measuredModulus) {
  double mean = 0.0;
  for (const NetworkSpring& s : network.springs)
    mean += s.stiffnessScale / static_cast<double>(network.springs.size());
  for (NetworkSpring& s : network.springs) s.stiffnessScale /= mean;
  network.stiffnessPerModulus = mean / measuredModulus;
}

}  // namespace

double setMaterialSprings(SpringNetwork& network, const std::function<bool(double)>& goOn, double minGrowth) {
  const Edges edges = collectEdges(network);
  const std::vector<FourthDegree> elasticities(network.restPoints.size(), isotropicElasticity());
  setSprings(network, edges, isotropicConstants(edges, elasticities, minGrowth));
  fitSprings(network, edges, minGrowth, goOn);
  const ElasticModuli moduli = measureModuli({network});
  const double modulus = moduli.isotropy > kEven ? moduli.youngsModulus : 1.0;
  normalise(network, modulus);
  return modulus;
}

// --- sheets ------------------------------------------------------------------------------------------------

namespace {

/// Returns the elasticity of springs that run evenly in all directions of a plane with this normal, of 1 Pa
/// m: the mean of 3 n n n n. Five directions give it exactly.
FourthDegree flatElasticity(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  FourthDegree sum = FourthDegree::Zero();
  for (int i = 0; i < 5; ++i)
    sum += 3.0 / 5.0 * fourthPower(std::cos(i * kPi / 5.0) * u + std::sin(i * kPi / 5.0) * v);
  return sum;
}

/// Smallest constant of a sheet's spring as a fraction of Van Gelder's.
constexpr double kLeastSheet = 0.2;

/// Largest rate of a point's oscillation squared, as a multiple of the median.
constexpr double kFastest = 1.5;

/// Returns the sum of the areas of the triangles at each edge, m^2.
std::map<Edge, double> areasAtEdges(const SpringNetwork& network) {
  std::map<Edge, double> areas;
  for (const Triangle& t : network.surface) {
    const double area = areaVector(network.restPoints, t).norm();
    for (std::size_t i = 0; i < 3; ++i) areas[edgeBetween(t[i], t[(i + 1) % 3])] += area;
  }
  return areas;
}

using Constants = std::vector<std::map<std::uint32_t, double>>;  ///< #points, of the edges to other points

/// Returns the largest constant of two edges in a row from a to b, as springs in series.
double constantOfDetour(const Constants& constants, std::uint32_t a, std::uint32_t b) {
  double largest = 0.0;
  for (const auto& [middle, first] : constants[a]) {
    const auto second = constants[b].find(middle);
    if (second != constants[b].end())
      largest = std::max(largest, first * second->second / (first + second->second));
  }
  return largest;
}

/// Returns Van Gelder's constants of the edges (N/m for 1 Pa m).
Constants sheetConstants(const SpringNetwork& network, const std::map<Edge, double>& areas) {
  Constants constants(network.restPoints.size());
  for (const auto& [edge, area] : areas) {
    const double squared = (network.restPoints[edge[1]] - network.restPoints[edge[0]]).squaredNorm();
    constants[edge[0]][edge[1]] = constants[edge[1]][edge[0]] = area / squared;
  }
  return constants;
}

/// Returns the springs of a sheet, with areas as the volumes of its points.
Edges sheetEdges(const SpringNetwork& network, const std::map<Edge, double>& areas, double bending) {
  const Constants constants = sheetConstants(network, areas);
  Edges edges;
  for (const NetworkSpring& s : network.springs) {
    const Eigen::Vector3d along = network.restPoints[s.b] - network.restPoints[s.a];
    const auto area = areas.find({s.a, s.b});
    const double brace = 2.0 * bending * constantOfDetour(constants, s.a, s.b) * along.squaredNorm();
    edges.add({s.a, s.b}, along, area != areas.end() ? area->second : brace);
  }
  edges.pointVolumes.assign(network.restPoints.size(), 0.0);
  for (const auto& [edge, area] : areas)
    for (const std::uint32_t p : edge) edges.pointVolumes[p] += area / 6.0;
  return edges;
}

/// Either side of a triangle counts alike: sheets with one side are oriented inconsistently somewhere.
std::vector<FourthDegree> sheetElasticities(const SpringNetwork& network) {
  const std::vector<Eigen::Vector3d>& points = network.restPoints;
  std::vector<Eigen::Vector3d> normals(points.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : network.surface) {
    const Eigen::Vector3d vector = areaVector(points, t);
    for (const std::uint32_t p : t) normals[p] += normals[p].dot(vector) < 0.0 ? -vector : vector;
  }
  std::vector<FourthDegree> elasticities;
  for (const Eigen::Vector3d& normal : normals) elasticities.push_back(flatElasticity(normal.normalized()));
  return elasticities;
}

/// Limits the constants x = k L^2 at points that would oscillate faster than most, as those of slivers, which
/// alone would shorten the time step: to kFastest times the median of  sum k / m.
void limitFastPoints(const SpringNetwork& network, const Edges& edges, std::vector<double>& x) {
  std::vector<double> rates(network.restPoints.size(), 0.0);
  for (std::size_t e = 0; e < x.size(); ++e)
    for (const std::uint32_t p : edges.ends[e])
      rates[p] += x[e] / edges.squaredLengths[e] / network.massFractions[p];
  std::vector<double> sorted = rates;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double largest = kFastest * *middle;
  for (std::size_t e = 0; e < x.size(); ++e) {
    const double rate = std::max(rates[edges.ends[e][0]], rates[edges.ends[e][1]]);
    if (rate > largest) x[e] *= largest / rate;
  }
}

}  // namespace

void setSheetSprings(SpringNetwork& network, double bending) {
  const std::map<Edge, double> areas = areasAtEdges(network);
  const Edges edges = sheetEdges(network, areas, bending);
  std::vector<double> x = isotropicConstants(edges, sheetElasticities(network), kLeastSheet);
  limitFastPoints(network, edges, x);
  double sum = 0.0;
  for (std::size_t e = 0; e < x.size(); ++e)
    if (network.springs[e].kind == SpringKind::Structural) sum += x[e] / edges.squaredLengths[e];
  for (std::size_t e = 0; e < x.size(); ++e)
    network.springs[e].stiffnessScale = x[e] / edges.squaredLengths[e] / sum * double(areas.size());
}

// --- the fit to the response of the solid ------------------------------------------------------------------

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Weight of the change of the constants relative to the misfit of the compliance.
constexpr double kChangeWeight = 0.1;

/// Largest number of trial steps, and the weighted relative error of a compliance that is small enough.
constexpr int kMaxTrials = 12;
constexpr double kSufficientError = 0.015;

/// A step that lessens the objective by a smaller fraction is the last one.
constexpr double kMinProgress = 0.01;

/// Damping of the first step, relative to kChangeWeight, and its factors after a good and a bad step.
constexpr double kFirstDamping = 20.0, kLessDamping = 0.5, kMoreDamping = 3.0, kMaxDamping = 1e4;

/// Limits of the conjugate gradients: number, and the fraction of the first residual's square.
constexpr int kMaxGradients = 30;
constexpr double kGradientTolerance = 1e-4;

struct Responder {
  SpringNetwork& network;
  const SolidResponses& wanted;
  VectorXd start, shares;      ///< #springs: log k0; kChangeWeight times the share of the sum of k L^2
  VectorXd smallest, largest;  ///< #springs, limits of log k
};

/// A trial: logarithms of the constants, and what follows from them.
struct Trial {
  VectorXd logs;           ///< #springs
  MatrixXd displacements;  ///< 3 #points x #loads
  MatrixXd misfit;         ///< #loads x #loads, weighted
  double objective = 0.0;
};

double squaredLength(const SpringNetwork& network, const NetworkSpring& s) {
  return (network.restPoints[s.b] - network.restPoints[s.a]).squaredNorm();
}

Responder makeResponder(SpringNetwork& network, const SolidResponses& wanted, const SpringLimits& limits) {
  const auto count = static_cast<Index>(network.springs.size());
  Responder r{network, wanted, VectorXd(count), VectorXd(count), VectorXd(count), VectorXd(count)};
  for (Index i = 0; i < count; ++i) {
    const NetworkSpring& s = network.springs[std::size_t(i)];
    r.start[i] = std::log(s.stiffnessScale);
    r.shares[i] = s.stiffnessScale * squaredLength(network, s);
    r.smallest[i] = std::log(limits.smallest[std::size_t(i)]);
    r.largest[i] = std::log(limits.largest[std::size_t(i)]);
  }
  r.shares *= kChangeWeight / r.shares.sum();
  return r;
}

/// Sets the springs and measures the response.
Trial respond(const Responder& r, VectorXd logs) {
  for (Index i = 0; i < logs.size(); ++i)
    r.network.springs[std::size_t(i)].stiffnessScale = std::exp(logs[i]);
  Trial trial{std::move(logs), LinearResponse({r.network}).displacements(r.wanted.loads), {}, 0.0};
  const MatrixXd compliance = transposedProduct(r.wanted.loads, trial.displacements);
  trial.misfit = (compliance - r.wanted.compliance).cwiseProduct(r.wanted.weights);
  trial.objective = trial.misfit.squaredNorm() + r.shares.dot((trial.logs - r.start).cwiseAbs2());
  return trial;
}

/// Returns the springs' extensions under the loads times the root of the constant, #springs x #loads.
MatrixXd weightedExtensions(const Responder& r, const MatrixXd& displacements) {
  MatrixXd extensions(r.start.size(), displacements.cols());
  for (Index i = 0; i < extensions.rows(); ++i) {
    const NetworkSpring& s = r.network.springs[std::size_t(i)];
    const Eigen::Vector3d along = (r.network.restPoints[s.b] - r.network.restPoints[s.a]).normalized();
    extensions.row(i) =
        std::sqrt(s.stiffnessScale) * along.transpose() *
        (displacements.middleRows<3>(3 * Index(s.b)) - displacements.middleRows<3>(3 * Index(s.a)));
  }
  return extensions;
}

/// The derivative of the weighted misfit with respect to the logarithms of the constants.
struct Derivative {
  MatrixXd extensions;      ///< #springs x #loads, see weightedExtensions()
  const MatrixXd& weights;  ///< #loads x #loads

  MatrixXd times(const VectorXd& change) const {
    const MatrixXd scaled = change.asDiagonal() * extensions;
    return -transposedProduct(extensions, scaled).cwiseProduct(weights);
  }
  VectorXd transposedTimes(const MatrixXd& misfit) const {
    const MatrixXd weighted = misfit.cwiseProduct(weights);
    return -extensions.cwiseProduct(product(extensions, weighted)).rowwise().sum();
  }
};

/// Returns 1 for springs that may follow the gradient, 0 for those that are held by a limit.
VectorXd freeSprings(const Responder& r, const VectorXd& logs, const VectorXd& gradient) {
  VectorXd isFree = VectorXd::Ones(logs.size());
  for (Index i = 0; i < logs.size(); ++i)
    if ((logs[i] <= r.smallest[i] && gradient[i] > 0.0) || (logs[i] >= r.largest[i] && gradient[i] < 0.0))
      isFree[i] = 0.0;
  return isFree;
}

/// Solves  (J^T J + diagonal) step = right  for the free springs by conjugate gradients.
VectorXd solveStep(const Derivative& derivative, const VectorXd& diagonal, const VectorXd& isFree,
                   const VectorXd& right) {
  VectorXd step = VectorXd::Zero(right.size()), residual = right,
           direction = residual.cwiseQuotient(diagonal);
  double squared = residual.dot(direction);
  const double sufficient = kGradientTolerance * squared;
  for (int i = 0; i < kMaxGradients && squared > sufficient; ++i) {
    const VectorXd image = isFree.cwiseProduct(derivative.transposedTimes(derivative.times(direction))) +
                           diagonal.cwiseProduct(direction);
    const double length = squared / direction.dot(image);
    step += length * direction;
    residual -= length * image;
    const VectorXd preconditioned = residual.cwiseQuotient(diagonal);
    const double next = residual.dot(preconditioned);
    direction = preconditioned + next / squared * direction;
    squared = next;
  }
  return step;
}

}  // namespace

double fitResponses(SpringNetwork& network, const SolidResponses& wanted, const SpringLimits& limits,
                    const std::function<bool(double)>& goOn) {
  const Responder r = makeResponder(network, wanted, limits);
  Trial best = respond(r, r.start.cwiseMax(r.smallest).cwiseMin(r.largest));
  const double sufficient = kSufficientError * kSufficientError * wanted.weights.diagonal().squaredNorm();
  double damping = kFirstDamping;
  bool hasNewDerivative = true;
  Derivative derivative{{}, wanted.weights};
  VectorXd gradient, isFree;
  for (int i = 0; i < kMaxTrials && damping < kMaxDamping && best.misfit.squaredNorm() > sufficient; ++i) {
    if (goOn && !goOn(static_cast<double>(i) / kMaxTrials)) break;
    if (hasNewDerivative) {
      derivative.extensions = weightedExtensions(r, best.displacements);
      gradient = derivative.transposedTimes(best.misfit) + r.shares.cwiseProduct(best.logs - r.start);
      isFree = freeSprings(r, best.logs, gradient);
    }
    const VectorXd step =
        solveStep(derivative, (1.0 + damping) * r.shares, isFree, -gradient.cwiseProduct(isFree));
    Trial trial = respond(r, (best.logs + step).cwiseMax(r.smallest).cwiseMin(r.largest));
    hasNewDerivative = trial.objective < best.objective;
    damping *= hasNewDerivative ? kLessDamping : kMoreDamping;
    if (!hasNewDerivative) continue;
    const bool isLast = trial.objective > (1.0 - kMinProgress) * best.objective;
    best = std::move(trial);
    if (isLast) break;
  }
  for (Index i = 0; i < best.logs.size(); ++i)
    network.springs[std::size_t(i)].stiffnessScale = std::exp(best.logs[i]);
  // the misfit is that of the compliance times the weight
  const VectorXd errors = best.misfit.diagonal().cwiseQuotient(wanted.weights.diagonal());
  return (1.0 + errors.cwiseQuotient(wanted.compliance.diagonal()).array()).inverse().maxCoeff();
}

}  // namespace limber

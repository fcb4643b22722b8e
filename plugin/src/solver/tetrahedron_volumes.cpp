// SPDX-License-Identifier: Zlib
// The volume term of tetrahedra: forces, energy and an upper bound of the frequency of oscillation.
#include "solver/volumes.h"

#include "mesh/surface.h"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// The present shape of a tetrahedron.
struct Shape {
  double volume;                         ///< m^3, signed
  Eigen::Matrix<double, 3, 4> gradient;  ///< m^2, of the volume with respect to the corners
};

/// Computes the shape with  V = b . (c x d) / 6,  where b, c, d are the edges from the first corner.
Shape shapeOf(const Tetrahedron& t, const Points& position) {
  const Vector3d a = position.col(t[0]), b = position.col(t[1]) - a, c = position.col(t[2]) - a,
                 d = position.col(t[3]) - a;
  const Vector3d gb = c.cross(d) / 6.0, gc = d.cross(b) / 6.0, gd = b.cross(c) / 6.0;
  Shape shape{b.dot(gb), {}};
  shape.gradient << -(gb + gc + gd), gb, gc, gd;
  return shape;
}

/// Relative volume within which a change of the push counts as near.
constexpr double kNear = 0.2;

/// Returns the largest change of the push per relative volume (Pa) near this relative volume.
double stiffnessNear(const TetrahedronVolumes& v, double relativeVolume) {
  const bool nearlyCrushed = relativeVolume < kernel::kCrushed + kNear;
  const bool compressed = relativeVolume < 1.0 + kernel::kLargestCompression - kNear;
  return (compressed ? 0.0 : v->modulus) + (nearlyCrushed ? v->crushModulus : 0.0);
}

/// Returns the integral of the relative volume change, limited below and above, minus `from`, from `from` to
/// c.
double energyOfChange(double c, double from, double smallest) {
  const double change = std::clamp(c, smallest, kernel::kLargestSwelling) - from;
  // where the push has reached its limit, the integral is linear
  return change * (c - from - 0.5 * change);
}

/// A volume change above this fraction of the rest volume is far from rest.
constexpr double kFar = 0.5;

bool springsRunAlongEdges(const SpringNetwork& network) {
  std::vector<Edge> edges;
  for (const NetworkSpring& s : network.springs) edges.push_back(edgeBetween(s.a, s.b));
  std::sort(edges.begin(), edges.end());
  for (const Tetrahedron& t : network.tetrahedra)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (!std::binary_search(edges.begin(), edges.end(), edgeBetween(t[i], t[j]))) return false;
  return true;
}

}  // namespace

TetrahedronVolumes makeTetrahedronVolumes(const SpringNetwork& network, const SoftBodySettings& settings) {
  if (network.tetrahedra.empty()) return {};
  TetrahedronConstants v;
  v.division = divideTetrahedra(network);
  for (const std::uint32_t i : v.division.order) v.tetrahedra.push_back(network.tetrahedra[i]);
  const Points rest = scaledRest(network, settings.scale);
  double sum = 0.0;
  v.restGradientSquares.resize(4, static_cast<Index>(v.tetrahedra.size()));
  for (std::size_t i = 0; i < v.tetrahedra.size(); ++i) {
    if (settings.scale.prod() < 0.0) std::swap(v.tetrahedra[i][2], v.tetrahedra[i][3]);
    const Shape shape = shapeOf(v.tetrahedra[i], rest);
    v.restVolume.push_back(std::abs(shape.volume));
    v.inverseRest.push_back(1.0 / (6.0 * v.restVolume.back()));
    sum += v.restVolume.back();
    v.restGradientSquares.col(static_cast<Index>(i)) = shape.gradient.colwise().squaredNorm();
  }
  v.edgesAreSprings = springsRunAlongEdges(network);
  const double stiffness = std::max(settings.extensionStiffness, settings.compressionStiffness);
  const double springModulus = networkModulus(network, settings.scale, stiffness, sum);
  v.modulus = settings.volumeModulus.value_or(springModulus);
  v.crushModulus = springModulus - 0.5 * std::min(springModulus, v.modulus);
  TetrahedronVolumes volumes;
  volumes.stabilityScale.assign(v.tetrahedra.size(), 0.0);
  volumes.mobility.assign(v.tetrahedra.size(), 0.0);
  volumes.constants = SharedConstants<TetrahedronConstants>(std::move(v));
  return volumes;
}

void prepareTetrahedra(TetrahedronVolumes& v, double dt) {
  const double stiffest = std::max(v->modulus, v->crushModulus);
  const double factor = stiffest * dt * dt / (36.0 * kLargestCornerPhaseSquared);
  for (std::size_t i = 0; i < v->tetrahedra.size(); ++i)
    v.stabilityScale[i] = factor * v.mobility[i] / v->restVolume[i];
}

bool isHeldBack(TetrahedronVolumes& v, const PointState& state, double dt) {
  prepareTetrahedra(v, dt);
  for (std::size_t i = 0; i < v->tetrahedra.size(); ++i) {
    const double squares = 36.0 * shapeOf(v->tetrahedra[i], state.position).gradient.squaredNorm();
    if (v.stabilityScale[i] * squares > 1.0) return true;
  }
  return false;
}

kernel::Tetrahedra<double> kernelTetrahedra(const TetrahedronVolumes& v) {
  if (v.empty()) return {};
  return {static_cast<kernel::Index>(v->tetrahedra.size()),
          v->tetrahedra.front().data(),
          v->inverseRest.data(),
          v.stabilityScale.data(),
          &v->modulus,
          &v->crushModulus};
}

void addTetrahedronForces(const TetrahedronVolumes& v, PointState& state) {
  state.allocateForces();
  kernel::addTetrahedronForces(kernelTetrahedra(v), state.position.data(), state.force.data());
}

double tetrahedronEnergy(const TetrahedronVolumes& v, const Points& position) {
  double energy = 0.0;
  for (std::size_t i = 0; i < v->tetrahedra.size(); ++i) {
    const double change = shapeOf(v->tetrahedra[i], position).volume / v->restVolume[i] - 1.0;
    const double crushed = std::min(change, kernel::kCrushed - 1.0);
    energy += v->restVolume[i] *
              (v->modulus * energyOfChange(change, 0.0, kernel::kLargestCompression) +
               v->crushModulus * energyOfChange(crushed, kernel::kCrushed - 1.0, kernel::kLargestShrinking));
  }
  return energy;
}

TetrahedronSlope tetrahedronSlope(const TetrahedronVolumes& v, std::size_t i, const Points& position) {
  const Shape shape = shapeOf(v->tetrahedra[i], position);
  const double change = shape.volume / v->restVolume[i] - 1.0;
  const bool limited = change < kernel::kLargestCompression || change > kernel::kLargestSwelling;
  const bool crushed = change < kernel::kCrushed - 1.0 && change >= kernel::kLargestShrinking;
  return {shape.gradient,
          ((limited ? 0.0 : v->modulus) + (crushed ? v->crushModulus : 0.0)) / v->restVolume[i]};
}

// --- the bound of the frequency ----------------------------------------------------------------------------

namespace {

void resetScratch(TetrahedronVolumes& v, std::size_t points) {
  TetrahedronScratch& s = v.scratch;
  s.squares.resize(4, static_cast<Index>(v->tetrahedra.size()));
  s.stiffness.resize(v->tetrahedra.size());
  s.directions.assign(points, Eigen::Matrix3d::Zero());
  s.rates.resize(points);
  s.rowSums.assign(points, 0.0);
  v.mobility.resize(v->tetrahedra.size());
}

/// Lengths (m) of the sides of the faces opposite to the corners, summed.
Eigen::Array4d perimeters(const Tetrahedron& t, const Points& x) {
  const auto length = [&](std::size_t i, std::size_t j) { return (x.col(t[i]) - x.col(t[j])).norm(); };
  const double ab = length(0, 1), ac = length(0, 2), ad = length(0, 3), bc = length(1, 2), bd = length(1, 3),
               cd = length(2, 3);
  return {bc + bd + cd, ac + ad + cd, ab + ad + bd, ab + ac + bc};
}

/// Whether this relative volume is far from rest, or will be after a tick at this rate (1/s).
bool isFar(double relativeVolume, double rate, double tick) {
  return std::abs(relativeVolume - 1.0) > kFar || std::abs(tick * rate) > kFar;
}

/// Adds a tetrahedron to the sums of its corners.
void addTetrahedron(TetrahedronVolumes& v, std::size_t i, const PointState& state, double tick) {
  TetrahedronScratch& s = v.scratch;
  const Tetrahedron& t = v->tetrahedra[i];
  const Shape shape = shapeOf(t, state.position);
  const double relative = shape.volume / v->restVolume[i];
  s.stiffness[i] = stiffnessNear(v, relative) / v->restVolume[i];
  const double push = std::abs(kernel::tetrahedronPush(relative, v->modulus, v->crushModulus));
  const Eigen::Array4d edges = perimeters(t, state.position);
  double rate = 0.0;
  for (Index corner = 0; corner < 4; ++corner) {
    const std::uint32_t point = t[static_cast<std::size_t>(corner)];
    const Vector3d g = shape.gradient.col(corner);
    const double square = s.squares(corner, static_cast<Index>(i)) = g.squaredNorm();
    if (square > 0.0) s.directions[point].noalias() += (g / square) * g.transpose();
    s.rowSums[point] += push * edges[corner] / 6.0;
    rate += g.dot(state.velocity.col(point));
  }
  v.farFromRest = v.farFromRest || isFar(relative, rate / v->restVolume[i], tick);
}

/// Returns an upper bound of the largest eigenvalue of a symmetric, positive semidefinite matrix A, at most 7
/// % above it:  (trace of A^16)^(1/16).
double eigenvalueBound(const Eigen::Matrix3d& a) {
  const double trace = a.trace();
  if (!(trace > 0.0)) return 0.0;
  Eigen::Matrix3d power = a / trace;
  for (int doubling = 0; doubling < 3; ++doubling) power = (power * power).eval();
  return trace * std::sqrt(std::sqrt(std::sqrt(std::sqrt(power.squaredNorm()))));
}

}  // namespace

double tetrahedronFrequencyBoundSquared(TetrahedronVolumes& v, const PointState& state, double tick) {
  if (v.empty()) return 0.0;
  TetrahedronScratch& s = v.scratch;
  resetScratch(v, static_cast<std::size_t>(state.position.cols()));
  v.farFromRest = false;
  for (std::size_t i = 0; i < v->tetrahedra.size(); ++i) addTetrahedron(v, i, state, tick);
  double ofSecond = 0.0, ofGradients = 0.0;
  for (std::size_t i = 0; i < s.rates.size(); ++i) {
    const double w = state.inverseMass.col(static_cast<Index>(i)).maxCoeff();
    ofSecond = std::max(ofSecond, w * s.rowSums[i]);
    s.rates[i] = w * eigenvalueBound(s.directions[i]);
  }
  for (std::size_t i = 0; i < v->tetrahedra.size(); ++i) {
    const Tetrahedron& t = v->tetrahedra[i];
    const Eigen::Array4d squares = s.squares.col(static_cast<Index>(i));
    const Eigen::Array4d rates{s.rates[t[0]], s.rates[t[1]], s.rates[t[2]], s.rates[t[3]]};
    const double sum = squares.sum();
    v.mobility[i] = sum > 0.0 ? (rates * squares).sum() / sum : rates.maxCoeff();
    ofGradients = std::max(ofGradients, s.stiffness[i] * v.mobility[i] * sum);
  }
  return ofGradients + ofSecond;
}

}  // namespace limber

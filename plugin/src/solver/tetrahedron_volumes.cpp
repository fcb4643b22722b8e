// SPDX-License-Identifier: Zlib
// The volume term of tetrahedra: forces, energy and an upper bound of the frequency of oscillation.
#include "solver/volumes.h"

#include "mesh/surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace limber {
namespace {

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

double perimeter(const Tetrahedron& t, std::size_t without, const Points& x) {
  const std::uint32_t a = t[(without + 1) % 4], b = t[(without + 2) % 4], c = t[(without + 3) % 4];
  return (x.col(b) - x.col(a)).norm() + (x.col(c) - x.col(b)).norm() + (x.col(a) - x.col(c)).norm();
}

std::vector<double> valenceOf(const std::vector<Tetrahedron>& tetrahedra, std::size_t points) {
  std::vector<double> around(points, 0.0), valence;
  for (const Tetrahedron& t : tetrahedra)
    for (const std::uint32_t corner : t) around[corner] += 1.0;
  for (const Tetrahedron& t : tetrahedra)
    valence.push_back(std::max({around[t[0]], around[t[1]], around[t[2]], around[t[3]]}));
  return valence;
}

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
  v.restGradientSquares.resize(4, static_cast<Eigen::Index>(v.tetrahedra.size()));
  for (std::size_t i = 0; i < v.tetrahedra.size(); ++i) {
    if (settings.scale.prod() < 0.0) std::swap(v.tetrahedra[i][2], v.tetrahedra[i][3]);
    const Shape shape = shapeOf(v.tetrahedra[i], rest);
    v.restVolume.push_back(std::abs(shape.volume));
    v.inverseRest.push_back(1.0 / (6.0 * v.restVolume.back()));
    sum += v.restVolume.back();
    v.restGradientSquares.col(static_cast<Eigen::Index>(i)) = shape.gradient.colwise().squaredNorm();
  }
  v.valence = valenceOf(v.tetrahedra, network.restPoints.size());
  v.edgesAreSprings = springsRunAlongEdges(network);
  const double stiffness = std::max(settings.extensionStiffness, settings.compressionStiffness);
  const double springModulus = networkModulus(network, settings.scale, stiffness, sum);
  v.modulus = settings.volumeModulus.value_or(springModulus);
  v.crushModulus = springModulus - 0.5 * std::min(springModulus, v.modulus);
  TetrahedronVolumes volumes;
  volumes.stabilityScale.assign(v.tetrahedra.size(), 0.0);
  volumes.rowSums.assign(network.restPoints.size(), 0.0);
  volumes.constants = SharedConstants<TetrahedronConstants>(std::move(v));
  return volumes;
}

void prepareTetrahedra(TetrahedronVolumes& v, const Points& inverseMass, double dt) {
  const double stiffest = std::max(v->modulus, v->crushModulus);
  const double factor = stiffest * dt * dt / (36.0 * kLargestCornerPhaseSquared);
  for (std::size_t i = 0; i < v->tetrahedra.size(); ++i) {
    double largest = 0.0;
    for (const std::uint32_t corner : v->tetrahedra[i])
      largest = std::max(largest, inverseMass.col(corner).maxCoeff());
    v.stabilityScale[i] = factor * largest * v->valence[i] / v->restVolume[i];
  }
}

bool isHeldBack(TetrahedronVolumes& v, const PointState& state, double dt) {
  prepareTetrahedra(v, state.inverseMass, dt);
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

double tetrahedronFrequencyBoundSquared(TetrahedronVolumes& v, const PointState& state, double tick) {
  std::fill(v.rowSums.begin(), v.rowSums.end(), 0.0);
  v.farFromRest = false;
  for (std::size_t i = 0; i < v->tetrahedra.size(); ++i) {
    const Tetrahedron& t = v->tetrahedra[i];
    const Shape shape = shapeOf(t, state.position);
    const double relative = shape.volume / v->restVolume[i];
    const double stiffness = stiffnessNear(v, relative) / v->restVolume[i];
    const double push = std::abs(kernel::tetrahedronPush(relative, v->modulus, v->crushModulus));
    const Eigen::Array4d norms = shape.gradient.colwise().norm();
    double rate = 0.0;
    for (std::size_t corner = 0; corner < 4; ++corner)
      rate += shape.gradient.col(static_cast<Eigen::Index>(corner)).dot(state.velocity.col(t[corner]));
    const double foreseen = std::abs(tick * rate / v->restVolume[i]);
    v.farFromRest = v.farFromRest || std::abs(relative - 1.0) > kFar || foreseen > kFar;
    for (std::size_t corner = 0; corner < 4; ++corner)
      v.rowSums[t[corner]] += stiffness * norms[static_cast<Eigen::Index>(corner)] * norms.sum() +
                              push * perimeter(t, corner, state.position) / 6.0;
  }
  double largest = 0.0;
  for (std::size_t i = 0; i < v.rowSums.size(); ++i)
    largest =
        std::max(largest, state.inverseMass.col(static_cast<Eigen::Index>(i)).maxCoeff() * v.rowSums[i]);
  return largest;
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "core/tetrahedron_volumes.h"

#include "core/volume_kernel.h"
#include "core/volume_term.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace limber {
namespace {

using Eigen::Vector3d;

/// A tetrahedron as it is now.
struct Shape {
  double volume;                     ///< m^3, signed
  std::array<Vector3d, 4> gradient;  ///< m^2, of the volume by its corners
};

/// With edges b, c, d from the first corner: V = b . (c x d) / 6.
Shape shapeOf(const Tetrahedron& t, const Points& position) {
  const Vector3d a = position.col(t[0]), b = position.col(t[1]) - a, c = position.col(t[2]) - a,
                 d = position.col(t[3]) - a;
  const Vector3d gb = c.cross(d) / 6.0, gc = d.cross(b) / 6.0, gd = b.cross(c) / 6.0;
  return {b.dot(gb), {-(gb + gc + gd), gb, gc, gd}};
}

/// The changes of volume relative to that at rest that the two terms push against, limited.
struct Changes {
  double volume;  ///< above 0 swollen
  double crush;   ///< 0 or less
};

Changes changesOf(double relativeVolume) {
  const double limited =
      std::clamp(relativeVolume - 1.0, kernel::kLargestShrinking, kernel::kLargestSwelling);
  return {limited, std::min(0.0, limited + 1.0 - kCrushed)};
}

/// Pa, above 0 outwards.
double pushOf(const TetrahedronVolumes& v, double relativeVolume) {
  const Changes c = changesOf(relativeVolume);
  return -v.modulus * c.volume - v.crushModulus * c.crush;
}

/// Pa: the most by which that changes with the relative volume nearby.
double stiffnessOf(const TetrahedronVolumes& v, double relativeVolume) {
  const bool nearlyCrushed = relativeVolume < kCrushed + 0.2;
  return v.modulus + (nearlyCrushed ? v.crushModulus : 0.0);
}

double perimeter(const Tetrahedron& t, std::size_t without, const Points& x) {
  const std::uint32_t a = t[(without + 1) % 4], b = t[(without + 2) % 4], c = t[(without + 3) % 4];
  return (x.col(b) - x.col(a)).norm() + (x.col(c) - x.col(b)).norm() + (x.col(a) - x.col(c)).norm();
}

}  // namespace

TetrahedronVolumes makeTetrahedronVolumes(const SpringNetwork& network, const SoftBodySettings& settings) {
  TetrahedronVolumes v;
  v.tetrahedra = network.tetrahedra;
  const double scale = settings.scale.prod();
  double sum = 0.0;
  for (Tetrahedron& t : v.tetrahedra) {
    const Vector3d& a = network.restPoints[t[0]];
    const Vector3d b = network.restPoints[t[1]] - a, c = network.restPoints[t[2]] - a,
                   d = network.restPoints[t[3]] - a;
    v.restVolume.push_back(std::abs(b.dot(c.cross(d)) * scale) / 6.0);
    sum += v.restVolume.back();
    if (scale < 0.0) std::swap(t[2], t[3]);
  }
  if (v.empty()) return v;
  const double stiffness = std::max(settings.extensionStiffness, settings.compressionStiffness);
  v.crushModulus = networkModulus(network, settings.scale, stiffness, sum);
  v.modulus = settings.volumeModulus >= 0.0 ? settings.volumeModulus : v.crushModulus;
  return v;
}

void addTetrahedronForces(const TetrahedronVolumes& v, PointState& state) {
  for (std::size_t i = 0; i < v.tetrahedra.size(); ++i) {
    const Shape shape = shapeOf(v.tetrahedra[i], state.position);
    const double push = pushOf(v, shape.volume / v.restVolume[i]);
    for (std::size_t corner = 0; corner < 4; ++corner)
      state.force.col(v.tetrahedra[i][corner]) += push * shape.gradient[corner];
  }
}

double tetrahedronEnergy(const TetrahedronVolumes& v, const Points& position) {
  double energy = 0.0;
  for (std::size_t i = 0; i < v.tetrahedra.size(); ++i) {
    const double relative = shapeOf(v.tetrahedra[i], position).volume / v.restVolume[i];
    const Changes c = changesOf(relative);
    // the integral of a push that no longer grows is a straight line
    const double change = relative - 1.0, crush = std::min(0.0, relative - kCrushed);
    energy += v.restVolume[i] * (v.modulus * c.volume * (change - 0.5 * c.volume) +
                                 v.crushModulus * c.crush * (crush - 0.5 * c.crush));
  }
  return energy;
}

double tetrahedronFrequencyBoundSquared(const TetrahedronVolumes& v, const PointState& state,
                                        std::vector<double>& rowSums) {
  rowSums.assign(static_cast<std::size_t>(state.position.cols()), 0.0);
  for (std::size_t i = 0; i < v.tetrahedra.size(); ++i) {
    const Tetrahedron& t = v.tetrahedra[i];
    const Shape shape = shapeOf(t, state.position);
    const double relative = shape.volume / v.restVolume[i];
    const double stiffness = stiffnessOf(v, relative) / v.restVolume[i], push = std::abs(pushOf(v, relative));
    double norms = 0.0;
    for (const Vector3d& g : shape.gradient) norms += g.norm();
    for (std::size_t corner = 0; corner < 4; ++corner)
      rowSums[t[corner]] += stiffness * shape.gradient[corner].norm() * norms +
                            push * perimeter(t, corner, state.position) / 6.0;
  }
  double largest = 0.0;
  for (Eigen::Index i = 0; i < state.position.cols(); ++i)
    largest = std::max(largest, state.inverseMass.col(i).maxCoeff() * rowSums[static_cast<std::size_t>(i)]);
  return largest;
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "core/volume_term.h"

#include "core/surface_components.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

bool mayHaveVolume(const SpringNetwork& network) {
  return network.kind == NetworkKind::Solid && !network.surface.empty() && network.report.watertight() &&
         network.tetrahedra.empty();
}

std::string whyNoVolume(const SpringNetwork& network) {
  if (network.kind != NetworkKind::Solid || network.surface.empty())
    return "a rope or cloth encloses no volume";
  if (!network.tetrahedra.empty()) return "in material mode it is set by withMaterial()";
  const MeshReport& r = network.report;
  const auto edges = [](std::size_t count, const char* what) {
    return count == 0 ? std::string() : std::to_string(count) + " " + what + " edges, ";
  };
  const std::string found = edges(r.openEdges, "open") + edges(r.nonManifoldEdges, "non-manifold") +
                            edges(r.inconsistentEdges, "inconsistent");
  return "the surface is not closed: it has " + found.substr(0, found.size() - 2);
}

double volumeOf(VolumeArrays& v, std::size_t component, const Points& position) {
  return kernel::sixVolumes(kernelVolumes(v), static_cast<kernel::Index>(component), position.data()) / 6.0;
}

double longestEdge(const Triangle& t, const Points& x) {
  return std::sqrt(
      std::max({(x.col(t[1]) - x.col(t[0])).squaredNorm(), (x.col(t[2]) - x.col(t[1])).squaredNorm(),
                (x.col(t[0]) - x.col(t[2])).squaredNorm()}));
}

/// Of the change c of the volume relative to the rest volume: the integral of the limited c.
double swellingEnergy(double c) {
  const double limited = std::clamp(c, kernel::kLargestShrinking, kernel::kLargestSwelling);
  return limited * (c - 0.5 * limited);
}

/// The integral of -1 / v over the volume v relative to the rest volume, from 1 on.
double gasEnergy(double v) {
  const double least = kernel::kLeastGasVolume;
  return v > least ? -std::log(v) : -std::log(least) - (v - least) / least;
}

/// Surfaces that enclose less than this share of their box are flat, or not oriented: their pressure would be
/// without bounds.
constexpr double kLeastShare = 1e-6;

Points scaledRest(const SpringNetwork& network, const Eigen::Vector3d& scale) {
  Points rest(3, static_cast<Eigen::Index>(network.restPoints.size()));
  for (Eigen::Index i = 0; i < rest.cols(); ++i)
    rest.col(i) = network.restPoints[static_cast<std::size_t>(i)].cwiseProduct(scale);
  return rest;
}

double boxVolume(const Points& points) {
  return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).prod();
}

/// Adds component c with its outside outside, whichever way the mesh, the scale or a hollow had turned it.
void addComponent(VolumeArrays& v, const std::vector<Triangle>& surface, const SurfaceComponents& components,
                  std::uint32_t c, const Points& rest) {
  const std::size_t first = v.triangles.size();
  for (std::size_t t = 0; t < surface.size(); ++t)
    if (components.ofTriangle[t] == c) v.triangles.push_back(surface[t]);
  v.area.resize(3 * v.triangles.size());
  v.firstTriangle.push_back(static_cast<std::uint32_t>(v.triangles.size()));
  v.restVolume.push_back(0.0);
  const double volume = volumeOf(v, v.restVolume.size() - 1, rest);
  v.restVolume.back() = std::abs(volume);
  if (volume < 0.0)
    for (std::size_t t = first; t < v.triangles.size(); ++t) std::swap(v.triangles[t][1], v.triangles[t][2]);
  if (v.restVolume.back() > kLeastShare * boxVolume(rest)) return;
  v.triangles.resize(first);
  v.firstTriangle.pop_back();
  v.restVolume.pop_back();
}

/// The gradient of the volume, and a bound of the row sums of its second derivatives, at the points of
/// component c; what others have left there is overwritten. The area vectors must be there.
void gatherRows(VolumeArrays& v, std::size_t c, const Points& position) {
  const auto triangles = [&](auto visit) {
    for (std::size_t t = v.firstTriangle[c]; t < v.firstTriangle[c + 1]; ++t)
      for (const std::uint32_t corner : v.triangles[t]) visit(t, corner);
  };
  triangles([&](std::size_t, std::uint32_t corner) {
    v.gradient.col(corner).setZero();
    v.rowSums[corner] = 0.0;
  });
  triangles([&](std::size_t t, std::uint32_t corner) {
    v.gradient.col(corner) += Eigen::Map<const Eigen::Vector3d>(&v.area[3 * t]) / 6.0;
    v.rowSums[corner] += longestEdge(v.triangles[t], position) / 3.0;
  });
}

/// Of one component, see volumeFrequencyBoundSquared.
double componentBound(VolumeArrays& v, std::size_t c, const PointState& state) {
  const double volume = volumeOf(v, c, state.position);
  const double push = kernel::pushOf(volume, v.restVolume[c], v.modulus, v.pressure);
  gatherRows(v, c, state.position);
  double along = 0.0, across = 0.0;
  for (std::size_t t = v.firstTriangle[c]; t < v.firstTriangle[c + 1]; ++t) {
    for (const std::uint32_t i : v.triangles[t]) {
      const double w = state.inverseMass.col(i).maxCoeff();
      along += w * v.gradient.col(i).squaredNorm();
      across = std::max(across, w * v.rowSums[i]);
      v.gradient.col(i).setZero();  // counted once
    }
  }
  return volumeStiffness(v, c, volume) / v.restVolume[c] * along + std::abs(push) * across;
}

}  // namespace

double networkModulus(const SpringNetwork& network, const Eigen::Vector3d& scale, double stiffness,
                      double volume) {
  double sum = 0.0;
  for (const NetworkSpring& s : network.springs) {
    const Eigen::Vector3d d = network.restPoints[s.b] - network.restPoints[s.a];
    sum += stiffness * s.stiffnessScale * d.cwiseProduct(scale).squaredNorm();
  }
  return sum / (6.0 * volume);
}

std::string checkVolume(const SpringNetwork& network, const SoftBodySettings& settings) {
  const bool asked = settings.volumeModulus > 0.0 || settings.pressure > 0.0;
  if (!asked || mayHaveVolume(network)) return {};
  return std::string(settings.pressure > 0.0 ? "pressure" : "volumeModulus") + ": " + whyNoVolume(network);
}

VolumeArrays makeVolumes(const SpringNetwork& network, const SoftBodySettings& settings) {
  if (!mayHaveVolume(network) || (settings.volumeModulus == 0.0 && settings.pressure == 0.0)) return {};
  const Points rest = scaledRest(network, settings.scale);
  VolumeArrays v;
  v.firstTriangle = {0};
  const SurfaceComponents components = findComponents(network.restPoints.size(), network.surface);
  for (std::uint32_t c = 0; c < components.count; ++c) addComponent(v, network.surface, components, c, rest);
  double volume = 0.0;
  for (const double one : v.restVolume) volume += one;
  const double stiffness = std::max(settings.extensionStiffness, settings.compressionStiffness);
  v.modulus = settings.volumeModulus >= 0.0 || v.empty()
                  ? settings.volumeModulus
                  : networkModulus(network, settings.scale, stiffness, volume);
  v.pressure = settings.pressure;
  v.gradient.setZero(3, rest.cols());
  v.rowSums.assign(network.restPoints.size(), 0.0);
  return v;
}

kernel::Volumes<double> kernelVolumes(VolumeArrays& v) {
  kernel::Volumes<double> k;
  k.components = static_cast<kernel::Index>(v.restVolume.size());
  if (v.empty()) return k;
  k.firstTriangle = v.firstTriangle.data();
  k.corners = v.triangles.front().data();
  k.restVolume = v.restVolume.data();
  k.modulus = &v.modulus;
  k.pressure = &v.pressure;
  k.area = v.area.data();
  return k;
}

void addVolumeForces(VolumeArrays& volumes, PointState& state) {
  kernel::addVolumeForces(kernelVolumes(volumes), state.position.data(), state.force.data());
}

double volumeEnergy(VolumeArrays& v, const Points& position) {
  double energy = 0.0;
  for (std::size_t c = 0; c < v.restVolume.size(); ++c) {
    const double relative = volumeOf(v, c, position) / v.restVolume[c];
    energy +=
        v.restVolume[c] * (v.modulus * swellingEnergy(relative - 1.0) + v.pressure * gasEnergy(relative));
  }
  return energy;
}

double enclosedVolume(VolumeArrays& v, const Points& position) {
  double sum = 0.0;
  for (std::size_t c = 0; c < v.restVolume.size(); ++c) sum += volumeOf(v, c, position);
  return sum;
}

double volumeStiffness(const VolumeArrays& v, std::size_t component, double volume) {
  const double relative = volume / v.restVolume[component];
  const bool limited =
      relative - 1.0 > kernel::kLargestSwelling || relative - 1.0 < kernel::kLargestShrinking;
  const double gas = relative > kernel::kLeastGasVolume ? v.pressure / (relative * relative) : 0.0;
  return (limited ? 0.0 : v.modulus) + gas;
}

double volumeGradient(VolumeArrays& v, std::size_t component, const PointState& state, Points& gradient) {
  const double volume = volumeOf(v, component, state.position);  // leaves the area vectors
  gradient.setZero(3, state.position.cols());
  for (std::size_t t = v.firstTriangle[component]; t < v.firstTriangle[component + 1]; ++t) {
    const Eigen::Vector3d sixth = Eigen::Map<const Eigen::Vector3d>(&v.area[3 * t]) / 6.0;
    for (const std::uint32_t corner : v.triangles[t])
      if (!isHeld(state.inverseMass, corner)) gradient.col(corner) += sixth;
  }
  return volume;
}

double volumeFrequencyBoundSquared(VolumeArrays& v, const PointState& state) {
  double largest = 0.0;
  for (std::size_t c = 0; c < v.restVolume.size(); ++c)
    largest = std::max(largest, componentBound(v, c, state));
  return largest;
}

}  // namespace limber

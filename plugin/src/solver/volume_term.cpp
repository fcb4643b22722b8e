// SPDX-License-Identifier: Zlib
// The volume term of closed surfaces: forces, energy and upper bounds of the frequency of oscillation.
#include "solver/volumes.h"

#include "mesh/surface.h"

namespace limber {
namespace {

bool hasSurface(const SpringNetwork& network) {
  return network.kind == NetworkKind::Solid && !network.surface.empty();
}

bool mayHaveVolume(const SpringNetwork& network) { return hasSurface(network) && network.tetrahedra.empty(); }

std::string whyNoVolume(const SpringNetwork& network) {
  if (!hasSurface(network)) return "a rope or cloth encloses no volume";
  if (!network.tetrahedra.empty()) return "a body of tetrahedra has no room for gas";
  // those of the surface itself: the network's report may belong to another surface
  const EdgeDefects defects = findEdgeDefects(network.surface);
  if (defects.none()) return "the surface encloses nothing: it is flat";
  const auto edges = [](std::size_t count, const char* what) {
    return count == 0 ? std::string() : std::to_string(count) + " " + what + " edges, ";
  };
  const std::string found = edges(defects.open, "open") + edges(defects.nonManifold, "non-manifold") +
                            edges(defects.inconsistent, "inconsistent");
  return "the surface is not closed: it has " + found.substr(0, found.size() - 2);
}

/// Calls visit(triangle, b - a, c - a) for each triangle of a component, with its corners a, b, c.
template <class Visit>
void forEachTriangle(const VolumeConstants& v, std::size_t component, const Points& x, Visit visit) {
  for (std::size_t i = v.firstTriangle[component]; i < v.firstTriangle[component + 1]; ++i) {
    const Triangle& t = v.triangles[i];
    visit(t, Eigen::Vector3d(x.col(t[1]) - x.col(t[0])), Eigen::Vector3d(x.col(t[2]) - x.col(t[0])));
  }
}

double componentVolume(const VolumeConstants& v, std::size_t component, const Points& x) {
  const Eigen::Vector3d origin = x.col(v.triangles[v.firstTriangle[component]][0]);
  double six = 0.0;
  forEachTriangle(v, component, x,
                  [&](const Triangle& t, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
                    six += (x.col(t[0]) - origin).dot(b.cross(c));
                  });
  return six / 6.0;
}

/// Returns the integral of the limited c, the change of the volume relative to the rest volume.
double swellingEnergy(double c) {
  const double limited = std::clamp(c, kernel::kLargestShrinking, kernel::kLargestSwelling);
  return limited * (c - 0.5 * limited);
}

/// Returns the integral of -1 / v from 1 to v, the volume relative to the rest volume, with the lower limit
/// of the gas volume.
double gasEnergy(double v) {
  const double least = kernel::kMinGasVolume;
  return v > least ? -std::log(v) : -std::log(least) - (v - least) / least;
}

/// A surface that encloses less than this fraction of its bounding box is flat or not oriented. Its pressure
/// would have no bound.
constexpr double kMinEnclosed = 1e-6;

/// Returns the length (m) of the shortest edge; 0 if there are no triangles.
double shortestEdge(const std::vector<Triangle>& triangles, const Points& points) {
  double shortest = triangles.empty() ? 0.0 : HUGE_VAL;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k)
      shortest = std::min(shortest, (points.col(t[(k + 1) % 3]) - points.col(t[k])).norm());
  return shortest;
}

/// Returns the volume (m^3) of the bounding box of the triangles from `first` on.
double boxVolume(const std::vector<Triangle>& triangles, std::size_t first, const Points& points) {
  Eigen::AlignedBox3d box;
  for (std::size_t t = first; t < triangles.size(); ++t)
    for (const std::uint32_t corner : triangles[t]) box.extend(Eigen::Vector3d(points.col(corner)));
  return box.sizes().prod();
}

/// Adds a component, with its triangles oriented outwards. In the mesh they may be oriented inwards, because
/// of the mesh, the scale or a hollow. Leaves the component out if it encloses almost nothing.
void addComponent(VolumeConstants& v, const std::vector<Triangle>& component, const Points& rest) {
  const std::size_t first = v.triangles.size();
  v.triangles.insert(v.triangles.end(), component.begin(), component.end());
  v.firstTriangle.push_back(static_cast<std::uint32_t>(v.triangles.size()));
  const double volume = componentVolume(v, v.restVolume.size(), rest);
  if (std::abs(volume) <= kMinEnclosed * boxVolume(v.triangles, first, rest)) {
    v.triangles.resize(first);
    v.firstTriangle.pop_back();
    return;
  }
  for (std::size_t t = first; t < v.triangles.size(); ++t) {
    if (volume < 0.0) std::swap(v.triangles[t][1], v.triangles[t][2]);
    for (const std::uint32_t corner : v.triangles[t])
      v.componentOf[corner] = static_cast<std::uint32_t>(v.restVolume.size());
  }
  v.restVolume.push_back(std::abs(volume));
}

/// A change of the volume above this fraction of the rest volume is far from rest. The push then contributes
/// about as much to the second derivatives of the energy as the springs do.
constexpr double kFarFromRest = 0.2;

/// The squares (m^2) of the longest edge now, and during a tick in which the ends keep their velocities.
struct EdgeSquares {
  double now = 0.0, later = 0.0;
};

double squareOfSum(double squared, double more) {
  const double sum = std::sqrt(squared) + more;
  return sum * sum;
}

EdgeSquares longestEdge(const Triangle& t, const PointState& state, double tick, double slack) {
  EdgeSquares longest;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto a = t[k], b = t[(k + 1) % 3];
    const Eigen::Vector3d edge = state.position.col(b) - state.position.col(a);
    const Eigen::Vector3d moved = edge + tick * (state.velocity.col(b) - state.velocity.col(a));
    longest.now = std::max(longest.now, edge.squaredNorm());
    longest.later = std::max({longest.later, longest.now, moved.squaredNorm()});
  }
  if (slack > 0.0) longest.later = squareOfSum(longest.later, 2.0 * slack);
  return longest;
}

/// Adds a third of the longest edge of each triangle to the rowSums of its corners. Returns the square of the
/// largest factor by which a triangle's longest edge grows.
double sumEdges(VolumeArrays& v, std::size_t c, const PointState& state, double tick, double slack) {
  double growth = 1.0;
  for (std::size_t i = v->firstTriangle[c]; i < v->firstTriangle[c + 1]; ++i) {
    const EdgeSquares edge = longestEdge(v->triangles[i], state, tick, slack);
    if (edge.now > 0.0) growth = std::max(growth, edge.later / edge.now);
    const double third = std::sqrt(edge.later) / 3.0;
    for (const std::uint32_t corner : v->triangles[i]) v.rowSums[corner] += third;
  }
  return growth;
}

/// Returns an upper bound of  sum w |g|^2  (m^4/kg) of a component, with the gradient g of its volume. A
/// triangle contributes to g at a corner a sixth of the cross product of two edges e1, e2. It changes by at
/// most 2 slack (|e1| + |e2|) / 6. With the rowSums r, which contain thirds of the longest edges,
/// |change of g| <= 2 slack r.
double gradientSum(const VolumeArrays& v, const double* sums, const PointState& state, double slack) {
  const double now = (sums[1] + sums[2] + sums[3]) / 36.0;
  if (!(slack > 0.0)) return now;
  double change = 0.0;
  for (std::size_t i = 0; i < v.rowSums.size(); ++i)
    change += state.inverseMass.col(static_cast<Eigen::Index>(i)).maxCoeff() * v.rowSums[i] * v.rowSums[i];
  return squareOfSum(now, 2.0 * slack * std::sqrt(change));
}

/// Returns by how much (Pa) the push of gas falls below 0 at most, while the volume, v times the rest volume,
/// grows by the fraction `growth`: the gas's pressure stays above 0, so at most to minus the ambient
/// pressure.
double gasDrop(const VolumeConstants& constants, double v, double growth) {
  const double now = constants.gasPressure / std::max(v, kernel::kMinGasVolume);
  return std::min(constants.ambient, now * growth / (1.0 + growth));
}

/// Replaces the sums of a component by the two parts of its bound, see volumeFrequencyBoundSquared(): that of
/// all its points, and that of each per inverse mass and rowSum. Call sumUp() before.
void boundComponent(VolumeArrays& v, std::size_t c, const PointState& state, double tick, double slack) {
  double* sums = &v.sums[4 * c];
  const double volume = sums[0] / 6.0, rest = v->restVolume[c];
  const kernel::Push<double> now = kernel::pushOf(volume, rest, v->modulus, v->gasPressure, v->ambient);
  const double edges = sumEdges(v, c, state, tick, slack);
  const double growth = edges * std::sqrt(edges) - 1.0;
  const double push = std::abs(now.push) + v->modulus * std::min(growth, -kernel::kLargestShrinking) +
                      gasDrop(*v.constants, volume / rest, growth);
  const double change = sums[0] / (6.0 * v->restVolume[c]) - 1.0;
  v.farFromRest = v.farFromRest || std::abs(change) > kFarFromRest || growth > kFarFromRest;
  sums[0] = now.stiffness * gradientSum(v, sums, state, slack);
  sums[1] = push;
}

}  // namespace

Points scaledRest(const SpringNetwork& network, const Eigen::Vector3d& scale) {
  Points rest(3, static_cast<Eigen::Index>(network.restPoints.size()));
  for (Eigen::Index i = 0; i < rest.cols(); ++i)
    rest.col(i) = network.restPoints[static_cast<std::size_t>(i)].cwiseProduct(scale);
  return rest;
}

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
  const bool perTetrahedron = !network.tetrahedra.empty();  // see TetrahedronVolumes
  const char* const asked = settings.pressure > 0.0          ? "pressure"
                            : settings.ambientPressure > 0.0 ? "ambientPressure"
                            : settings.volumeModulus.value_or(0.0) > 0.0 && !perTetrahedron ? "volumeModulus"
                                                                                            : nullptr;
  if (!asked) return {};
  const bool closed = mayHaveVolume(network) && findEdgeDefects(network.surface).none();
  if (closed && !makeVolumes(network, settings).empty()) return {};
  return std::string(asked) + ": " + whyNoVolume(network);
}

VolumeConstants closedSurfaces(const SpringNetwork& network, const Points& rest) {
  VolumeConstants v;
  v.firstTriangle = {0};
  v.componentOf.assign(network.restPoints.size(), 0);
  if (!hasSurface(network)) return v;
  for (const std::vector<Triangle>& component : trianglesOfPieces(network.restPoints.size(), network.surface))
    if (findEdgeDefects(component).none()) addComponent(v, component, rest);
  return v;
}

VolumeArrays makeVolumes(const SpringNetwork& network, const SoftBodySettings& settings) {
  const double gasPressure = settings.pressure + settings.ambientPressure;
  if (!mayHaveVolume(network) || (settings.volumeModulus == 0.0 && gasPressure == 0.0)) return {};
  const Points rest = scaledRest(network, settings.scale);
  VolumeConstants v = closedSurfaces(network, rest);
  double volume = 0.0;
  for (const double one : v.restVolume) volume += one;
  const double stiffness = std::max(settings.extensionStiffness, settings.compressionStiffness);
  v.modulus = 0.0;
  if (!v.restVolume.empty())
    v.modulus = settings.volumeModulus ? *settings.volumeModulus
                                       : networkModulus(network, settings.scale, stiffness, volume);
  v.gasPressure = gasPressure;
  v.ambient = settings.ambientPressure;
  v.shortestEdge = shortestEdge(v.triangles, rest);
  VolumeArrays volumes;
  volumes.constants = SharedConstants<VolumeConstants>(std::move(v));
  return volumes;
}

kernel::Volumes<double> kernelVolumes(VolumeArrays& v) {
  kernel::Volumes<double> k;
  if (v.empty()) return k;
  v.gradient.resize(3, static_cast<Eigen::Index>(v->componentOf.size()));
  v.sums.resize(4 * v->restVolume.size());
  k.components = static_cast<kernel::Index>(v->restVolume.size());
  k.points = static_cast<kernel::Index>(v->componentOf.size());
  k.firstTriangle = v->firstTriangle.data();
  k.corners = v->triangles.front().data();
  k.componentOf = v->componentOf.data();
  k.restVolume = v->restVolume.data();
  k.modulus = &v->modulus;
  k.gasPressure = &v->gasPressure;
  k.ambient = &v->ambient;
  k.gradient = v.gradient.data();
  k.sums = v.sums.data();
  k.timeStep = v.timeStep;
  return k;
}

void addVolumeForces(VolumeArrays& volumes, PointState& state) {
  state.allocateForces();
  kernel::addVolumeForces(kernelVolumes(volumes), state.position.data(), state.inverseMass.data(),
                          state.force.data());
}

bool isHeldBack(VolumeArrays& v, const PointState& state, double dt) {
  if (v.empty()) return false;
  kernel::sumUp(kernelVolumes(v), state.position.data(), state.inverseMass.data());
  for (std::size_t c = 0; c < v->restVolume.size(); ++c) {
    const double* sums = &v.sums[4 * c];
    const auto push = [&](double timeStep) {
      return kernel::stablePush(sums[0], sums[1] + (sums[2] + sums[3]), v->restVolume[c], v->modulus,
                                v->gasPressure, v->ambient, timeStep);
    };
    if (push(dt) != push(0.0)) return true;
  }
  return false;
}

double volumeEnergy(const VolumeArrays& v, const Points& position) {
  double energy = 0.0;
  for (std::size_t c = 0; c < v->restVolume.size(); ++c) {
    const double relative = componentVolume(*v.constants, c, position) / v->restVolume[c];
    energy += v->restVolume[c] * (v->modulus * swellingEnergy(relative - 1.0) +
                                  v->gasPressure * gasEnergy(relative) + v->ambient * (relative - 1.0));
  }
  return energy;
}

double volumeFrequencyBoundSquared(VolumeArrays& v, const PointState& state, double tick, double slack) {
  if (v.empty()) return 0.0;
  kernel::sumUp(kernelVolumes(v), state.position.data(), state.inverseMass.data());
  v.rowSums.assign(v->componentOf.size(), 0.0);
  v.farFromRest = false;
  for (std::size_t c = 0; c < v->restVolume.size(); ++c) boundComponent(v, c, state, tick, slack);
  double largest = 0.0;  // rowSums of points of no component are 0
  for (std::size_t i = 0; i < v.rowSums.size(); ++i) {
    const double* sums = &v.sums[4 * v->componentOf[i]];
    const double mass = state.inverseMass.col(static_cast<Eigen::Index>(i)).maxCoeff();
    largest = std::max(largest, sums[0] + sums[1] * (mass * v.rowSums[i]));
  }
  return largest;
}

VolumeSlope volumeSlope(const VolumeArrays& v, std::size_t component, const PointState& state,
                        Points& gradient) {
  gradient.setZero(3, state.position.cols());
  forEachTriangle(*v.constants, component, state.position,
                  [&](const Triangle& t, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
                    for (const std::uint32_t corner : t)
                      if (!isHeld(state.inverseMass, corner)) gradient.col(corner) += b.cross(c) / 6.0;
                  });
  const double volume = componentVolume(*v.constants, component, state.position),
               rest = v->restVolume[component];
  const double change = (volume - rest) / rest;
  const bool limited = change > kernel::kLargestSwelling || change < kernel::kLargestShrinking;
  const double gas = volume > kernel::kMinGasVolume * rest ? v->gasPressure * rest / (volume * volume) : 0.0;
  return {volume, (limited ? 0.0 : v->modulus / rest) + gas};
}

bool isFarFromRest(const VolumeArrays& v, const Points& position) {
  for (std::size_t c = 0; c < v->restVolume.size(); ++c)
    if (std::abs(componentVolume(*v.constants, c, position) / v->restVolume[c] - 1.0) > kFarFromRest)
      return true;
  return false;
}

// --- a cached bound ----------------------------------------------------------------------------------------

namespace {

using Eigen::Vector3d;

/// Fraction of the shortest edge at rest. Smaller relative motions of points do not count as a change of
/// shape. It makes the bound of a cube half a per cent larger.
constexpr double kSlack = 2e-4;

/// Returns the largest displacement (m) of a point relative to the mean of all points: since the shape was
/// stored, plus during the tick.
double shapeChange(const Points& kept, const PointState& state, double tick) {
  Vector3d moved = Vector3d::Zero(), velocity = Vector3d::Zero();
  for (Eigen::Index i = 0; i < kept.cols(); ++i) {
    moved += state.position.col(i) - kept.col(i);
    velocity += state.velocity.col(i);
  }
  moved /= static_cast<double>(kept.cols());
  velocity /= static_cast<double>(kept.cols());
  double change = 0.0, speed = 0.0;
  for (Eigen::Index i = 0; i < kept.cols(); ++i) {
    change = std::max(change, (state.position.col(i) - kept.col(i) - moved).squaredNorm());
    speed = std::max(speed, (state.velocity.col(i) - velocity).squaredNorm());
  }
  return std::sqrt(change) + tick * std::sqrt(speed);
}

}  // namespace

double keptVolumeBoundSquared(VolumeArrays& v, const PointState& state, double tick) {
  if (v.empty()) return 0.0;
  const double slack = kSlack * v->shortestEdge;
  if (v.kept.value > 0.0 && shapeChange(v.kept.shape, state, tick) <= slack) return v.kept.value;
  const double bound = volumeFrequencyBoundSquared(v, state, tick, slack);
  v.kept.shape = state.position;
  v.kept.value = v.farFromRest ? 0.0 : bound;
  return bound;
}

}  // namespace limber

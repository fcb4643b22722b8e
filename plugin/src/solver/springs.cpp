// SPDX-License-Identifier: Zlib
// Makes the springs of a body, computes their forces and applies their dampers.
#include "solver/springs.h"

#include "mesh/random.h"

namespace limber {

// --- groups ------------------------------------------------------------------------------------------------

namespace {

const NamedGroup* findGroup(const SpringNetwork& network, const std::string& name) {
  const auto same = [&](const NamedGroup& group) { return group.name == name; };
  const auto it = std::find_if(network.groups.begin(), network.groups.end(), same);
  return it != network.groups.end() ? &*it : nullptr;
}

}  // namespace

GroupFactors::GroupFactors(const SpringNetwork& network, const std::vector<GroupSettings>& groups)
    : stiffness(network.springs.size(), 1.0),
      damping(stiffness),
      limitStrain(stiffness),
      restLength(stiffness),
      mass(network.restPoints.size(), 1.0) {
  for (const GroupSettings& settings : groups) {
    const NamedGroup* group = findGroup(network, settings.name);
    if (!group) continue;
    for (const std::uint32_t i : group->springs) {
      stiffness[i] *= settings.stiffness;
      damping[i] *= settings.damping;
      limitStrain[i] *= settings.limitStrain;
      restLength[i] *= settings.restLength;
    }
    for (const std::uint32_t i : group->points) mass[i] *= settings.mass;
  }
}

std::string checkGroups(const SpringNetwork& network, const std::vector<GroupSettings>& groups) {
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (findGroup(network, groups[i].name)) continue;
    std::string known;
    for (const NamedGroup& group : network.groups) known += (known.empty() ? "" : ", ") + group.name;
    return "groups[" + std::to_string(i) + "].name is " + groups[i].name +
           (known.empty() ? ", but the network has no groups" : ", must be one of the network's: " + known);
  }
  return {};
}

// --- springs -----------------------------------------------------------------------------------------------

SpringArrays makeSprings(const SpringNetwork& network, const SoftBodySettings& settings) {
  SpringConstants s;
  const GroupFactors factors(network, settings.groups);
  s.division = divideSprings(network);
  for (const std::uint32_t i : s.division.order) {
    const NetworkSpring& spring = network.springs[i];
    const Eigen::Vector3d d = network.restPoints[spring.b] - network.restPoints[spring.a];
    s.a.push_back(spring.a);
    s.b.push_back(spring.b);
    s.restLength.push_back(factors.restLength[i] * d.cwiseProduct(settings.scale).norm());
    const double scale = spring.stiffnessScale * factors.stiffness[i];
    s.extensionStiffness.push_back(settings.extensionStiffness * scale);
    s.compressionStiffness.push_back(settings.compressionStiffness * scale);
    s.damping.push_back(settings.damping * spring.stiffnessScale * factors.damping[i]);
    if (!settings.groups.empty()) s.limitFactor.push_back(factors.limitStrain[i]);
  }
  for (const double length : s.restLength)
    if (length > 0.0) s.shortest = s.shortest > 0.0 ? std::min(s.shortest, length) : length;
  const ElasticLimit& limit = settings.elasticLimit;
  s.limit = limit;
  // a body that tears breaks between ticks
  if (limit.tear) s.limit.breakStrain = 0.0;
  s.limited = limit.stiffenStrain > 0.0 || limit.yieldStrain > 0.0 || s.limit.breakStrain > 0.0;
  s.kinked = limit.stiffenStrain > 0.0 || s.extensionStiffness != s.compressionStiffness;
  s.damped = settings.damping > 0.0;
  SpringArrays springs;
  springs.original = SharedConstants<SpringConstants>(std::move(s));
  return springs;
}

// --- coincident ends ---------------------------------------------------------------------------------------

namespace {

/// Fractions of the rest length: ends nearer than the first coincide; the second is their new distance.
constexpr double kSamePlace = 1e-9;
constexpr double kApart = 1e-6;

/// Returns a pseudorandom number from -1 to 1. The same seed gives the same number on every machine.
double scatter(std::uint64_t seed) { return 2.0 * Random(seed * 0x9e3779b97f4a7c15u).uniform() - 1.0; }

Eigen::Vector3d directionOf(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t seed = (std::uint64_t{a} << 32 | b) * 3;
  const Eigen::Vector3d d(scatter(seed), scatter(seed + 1), scatter(seed + 2));
  return d.norm() > 0.0 ? Eigen::Vector3d(d.normalized()) : Eigen::Vector3d::UnitX();
}

}  // namespace

void separateCoincident(const SpringArrays& springs, PointState& state) {
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto a = springs->a[s], b = springs->b[s];
    const double length = springs->restLength[s];
    if ((state.position.col(b) - state.position.col(a)).norm() >= kSamePlace * length) continue;
    const Eigen::Vector3d wa = state.inverseMass.col(a), wb = state.inverseMass.col(b);
    const double sum = (wa + wb).maxCoeff();
    if (!(sum > 0.0)) continue;
    const Eigen::Vector3d apart = kApart * length / sum * directionOf(a, b);
    state.position.col(a) -= wa.cwiseProduct(apart);
    state.position.col(b) += wb.cwiseProduct(apart);
  }
}

// --- elastic limits ----------------------------------------------------------------------------------------

double limitLength(const SpringArrays& springs, std::size_t i) {
  const std::vector<double>& factor = springs->limitFactor;
  return factor.empty() ? springs.original->restLength[i] : factor[i] * springs.original->restLength[i];
}

namespace {

bool hasNoStiffness(const SpringConstants& springs, std::size_t i) {
  return springs.extensionStiffness[i] == 0.0 && springs.compressionStiffness[i] == 0.0;
}

}  // namespace

void breakSpring(SpringArrays& springs, std::size_t i) {
  SpringConstants& s = *springs.yielded;
  s.extensionStiffness[i] = s.compressionStiffness[i] = s.damping[i] = 0.0;
  if (!springs.dampHalf.empty()) springs.dampHalf[i] = springs.dampFull[i] = 0.0;
  ++springs.broken;
}

bool isBroken(const SpringArrays& springs, std::size_t i) {
  return springs.yielded && hasNoStiffness(*springs.yielded, i) && !hasNoStiffness(*springs.original, i);
}

namespace {

/// Returns the rest length of a spring of this length: a new one if the strain exceeds the yield strain.
double yieldedLength(const SpringArrays& springs, std::size_t i, double length) {
  const double original = springs.original->restLength[i], rest = springs->restLength[i];
  const double largest = springs->limit.yieldStrain * limitLength(springs, i), elongation = length - rest;
  if (std::abs(elongation) <= largest) return rest;
  const double wanted = length - std::copysign(largest, elongation);
  const double change = springs->limit.yieldMaximum * original;
  return std::clamp(wanted, original - change, original + change);
}

void updateLimits(SpringArrays& springs, std::size_t i, double length) {
  const ElasticLimit& limit = springs->limit;
  if (hasNoStiffness(*springs.yielded, i)) return;
  const double elongation = length - springs.original->restLength[i];
  if (limit.breakStrain > 0.0 && elongation > limit.breakStrain * limitLength(springs, i))
    breakSpring(springs, i);
  else if (limit.yieldStrain > 0.0)
    springs.yielded->restLength[i] = yieldedLength(springs, i, length);
}

/// Returns the energy (J) at elongation e (m) of a spring of stiffness k, which is `factor` times as stiff
/// beyond |e| = s.
double stiffenedEnergy(double k, double e, double s, double factor) {
  const double beyond = std::max(0.0, std::abs(e) - s), below = std::abs(e) - beyond;
  return 0.5 * k * below * below + beyond * (k * s + 0.5 * k * factor * beyond);
}

/// Returns kernel::crossingForce() of a spring with the offset `d` (m) of its ends: where its stretch passes
/// 0 or the limits beyond which it is stiffer.
Eigen::Vector3d limitedCrossing(const SpringArrays& springs, std::size_t i, const Eigen::Vector3d& d) {
  const double length = d.norm();
  if (!(length > 0.0)) return Eigen::Vector3d::Zero();
  const double limit = springs->limit.stiffenStrain * limitLength(springs, i);
  const double more = limit > 0.0 ? springs->limit.stiffenFactor - 1.0 : 0.0;
  const double extension = springs->extensionStiffness[i], compression = springs->compressionStiffness[i];
  const double earlier = springs.stretch[i], now = length - springs->restLength[i];
  const auto at = [&](double kink, double change) {
    return kernel::crossingForce(earlier - kink, now - kink, change, springs.crossingLoss[i]);
  };
  const double force =
      at(0.0, extension - compression) + at(limit, more * extension) + at(-limit, -more * compression);
  return force / length * d;
}

/// Applies the elastic limits to the springs and adds their forces. L0 is the original rest length, L the
/// present one, l the length and e = l - L. A spring
///
///     breaks    when l - L0 > breakStrain L0: it has no force and no damping from then on
///     yields    when |e| > yieldStrain L0: L changes until |e| = yieldStrain L0, but not beyond
///               L0 (1 +- yieldMaximum); rate-independent, so the result does not depend on the substep
///     stiffens  F = k e up to |e| = s = stiffenStrain L0, then k (s + stiffenFactor (|e| - s)), signed
void addLimitedForces(SpringArrays& springs, PointState& state, double crossing) {
  const ElasticLimit& limit = springs->limit;
  if (!springs.yielded) springs.yielded = std::make_shared<SpringConstants>(*springs.original);
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const Eigen::Vector3d d = state.position.col(springs->b[i]) - state.position.col(springs->a[i]);
    if (springs.original->restLength[i] > 0.0) updateLimits(springs, i, d.norm());
    SpringPull pull = springPull(d, springs->restLength[i], springs->extensionStiffness[i],
                                 springs->compressionStiffness[i]);
    if (limit.stiffenStrain > 0.0 && pull.force != 0.0) {
      const double e = d.norm() - springs->restLength[i];
      const double beyond = std::abs(e) - limit.stiffenStrain * limitLength(springs, i);
      if (beyond > 0.0) pull.force += pull.force / e * std::copysign((limit.stiffenFactor - 1.0) * beyond, e);
    }
    springs.direction.col(static_cast<Eigen::Index>(i)) = pull.direction;
    Eigen::Vector3d force = pull.force * pull.direction;
    if (springs->kinked && crossing > 0.0) force += crossing * limitedCrossing(springs, i, d);
    if (!springs.stretch.empty()) springs.stretch[i] = d.norm() - springs->restLength[i];
    state.force.col(springs->a[i]) += force;
    state.force.col(springs->b[i]) -= force;
  }
}

}  // namespace

// --- forces ------------------------------------------------------------------------------------------------

void computeSpringForces(SpringArrays& springs, PointState& state, double crossing) {
  state.allocateForces();
  springs.allocateDirections();
  if (!springs->limited) return kernel::computeForces(kernelSprings(springs), kernelPoints(state), crossing);
  state.force.setZero();
  addLimitedForces(springs, state, crossing);
}

double elasticEnergy(const SpringArrays& springs, const Points& position) {
  const auto stretchOf = [&](std::size_t i) {
    return (position.col(springs->b[i]) - position.col(springs->a[i])).norm() - springs->restLength[i];
  };
  const auto stiffnessOf = [&](std::size_t i, double stretch) {
    return kernel::select(stretch > 0.0, springs->extensionStiffness[i], springs->compressionStiffness[i]);
  };
  double energy = 0.0;
  if (springs->limit.stiffenStrain > 0.0) {
    for (std::size_t i = 0; i < springs.size(); ++i) {
      const double stretch = stretchOf(i), strain = springs->limit.stiffenStrain * limitLength(springs, i);
      energy += stiffenedEnergy(stiffnessOf(i, stretch), stretch, strain, springs->limit.stiffenFactor);
    }
    return energy;
  }
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double stretch = stretchOf(i);
    energy += 0.5 * stiffnessOf(i, stretch) * stretch * stretch;
  }
  return energy;
}

// --- dampers -----------------------------------------------------------------------------------------------

namespace {

/// Largest mean z of a sweep, see prepareDampers(), and largest number of sweeps in a substep.
constexpr double kLargestMean = 1.5;
constexpr int kMostSweeps = 16;

/// Returns the number of sweeps in a substep of dt seconds.
int sweepsFor(const SpringArrays& springs, const Points& inverseMass, double dt) {
  double sum = 0.0;
  std::size_t dampers = 0;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    if (springs->damping[i] == 0.0) continue;
    sum += springs->damping[i] * inverseMassesOf(springs, inverseMass, i) * dt;
    ++dampers;
  }
  const double mean = sum / static_cast<double>(std::max<std::size_t>(dampers, 1));
  return static_cast<int>(std::clamp(std::ceil(mean / kLargestMean), 1.0, double(kMostSweeps)));
}

void prepareCrossings(SpringArrays& springs, const Points& inverseMass, double dt) {
  springs.stretch.resize(springs.size());
  springs.crossingLoss.resize(springs.size());
  for (std::size_t i = 0; i < springs.size(); ++i)
    springs.crossingLoss[i] = kernel::kCrossingLoss * dt * dt * inverseMassesOf(springs, inverseMass, i);
}

void prepareDampers(SpringArrays& springs, const Points& inverseMass, double dt) {
  springs.dampHalf.resize(springs.size());
  springs.dampFull.resize(springs.size());
  springs.sweeps = springs.oneSweep ? 1 : sweepsFor(springs, inverseMass, dt);
  const double time = dt / springs.sweeps;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double w = inverseMassesOf(springs, inverseMass, i), damping = springs->damping[i];
    springs.dampHalf[i] = networkDampingImpulse(damping, w, 0.5 * time);
    springs.dampFull[i] = networkDampingImpulse(damping, w, time);
  }
}

}  // namespace

void prepareSprings(SpringArrays& springs, const Points& inverseMass, double dt) {
  if (!springs->damped) springs.sweeps = 0;
  if ((!springs->damped && !springs->kinked) || springs.preparedFor == dt) return;
  springs.preparedFor = dt;
  ++springs.revision;
  if (springs->kinked) prepareCrossings(springs, inverseMass, dt);
  if (springs->damped) prepareDampers(springs, inverseMass, dt);
}

void limitSweeps(SpringArrays& springs, bool oneSweep) {
  if (std::exchange(springs.oneSweep, oneSweep) != oneSweep) springs.preparedFor = 0.0;
}

}  // namespace limber

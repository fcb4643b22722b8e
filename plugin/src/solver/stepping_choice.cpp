// SPDX-License-Identifier: Zlib
// Computes the frequencies of a body's oscillations, and chooses its stepper and number of substeps.
#include "solver/stepping_choice.h"

#include "mesh/linear_algebra.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace limber {
namespace {

// --- the fastest oscillation -------------------------------------------------------------------------------

using Eigen::Index;
using Eigen::Vector3d;

/// A spring's part of the stiffness matrix is (along - across) n n^T + across I between its ends.
struct SpringSlopes {
  Points direction;                   ///< 3 x #springs, n
  std::vector<double> along, across;  ///< N/m
};

/// The force k (l - L) n of a spring changes by k n n^T along it, and by its force over its length across it.
/// In compression the second change is negative and lowers frequencies; it is left out.
SpringSlopes slopesOf(const SpringArrays& springs, const Points& x) {
  const std::size_t count = springs.size();
  SpringSlopes s{Points(3, static_cast<Index>(count)), std::vector<double>(count),
                 std::vector<double>(count)};
  const double stiffened = springs->limit.stiffenStrain > 0.0 ? springs->limit.stiffenFactor : 1.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d d = x.col(springs->b[i]) - x.col(springs->a[i]);
    const double length = d.norm();
    s.direction.col(static_cast<Index>(i)) = d.stableNormalized();
    s.along[i] = stiffened * std::max(springs->extensionStiffness[i], springs->compressionStiffness[i]);
    if (length > springs->restLength[i])
      s.across[i] = springs->extensionStiffness[i] * (length - springs->restLength[i]) / length;
  }
  return s;
}

void addSpringForces(const SpringArrays& springs, const SpringSlopes& s, const Points& u, Points& force) {
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const Vector3d n = s.direction.col(static_cast<Index>(i));
    const Vector3d displacement = u.col(springs->b[i]) - u.col(springs->a[i]);
    const Vector3d f = s.across[i] * displacement + ((s.along[i] - s.across[i]) * n.dot(displacement)) * n;
    force.col(springs->a[i]) -= f;
    force.col(springs->b[i]) += f;
  }
}

/// Returns sqrt(stiffness) times the gradient of each component's volume. The volume term's stiffness matrix
/// is the sum of their squares g g^T, since at rest it has no force.
std::vector<Points> volumeGradients(const VolumeArrays& volumes, const PointState& state) {
  std::vector<Points> gradients;
  Points gradient = Points::Zero(3, state.position.cols());
  for (std::size_t c = 0; c < volumes->restVolume.size(); ++c) {
    const VolumeSlope slope = volumeSlope(volumes, c, state, gradient);
    gradients.push_back(std::sqrt(slope.stiffness) * gradient);
  }
  return gradients;
}

std::vector<TetrahedronSlope> tetrahedronSlopes(const TetrahedronVolumes& volumes, const Points& x) {
  std::vector<TetrahedronSlope> slopes;
  for (std::size_t i = 0; i < volumes->tetrahedra.size(); ++i)
    slopes.push_back(tetrahedronSlope(volumes, i, x));
  return slopes;
}

void addTetrahedronForces(const TetrahedronVolumes& volumes, const std::vector<TetrahedronSlope>& slopes,
                          const Points& u, Points& force) {
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    double change = 0.0;
    for (Index k = 0; k < 4; ++k)
      change += slopes[i].gradient.col(k).dot(u.col(volumes->tetrahedra[i][static_cast<std::size_t>(k)]));
    for (Index k = 0; k < 4; ++k)
      force.col(volumes->tetrahedra[i][static_cast<std::size_t>(k)]) +=
          slopes[i].stiffness * change * slopes[i].gradient.col(k);
  }
}

}  // namespace

double fastestOscillationSquared(const SpringArrays& springs, const VolumeArrays& volumes,
                                 const TetrahedronVolumes& tetrahedra, const PointState& state,
                                 double tolerance) {
  const SpringSlopes slopes = slopesOf(springs, state.position);
  const std::vector<Points> gradients = volumeGradients(volumes, state);
  const std::vector<TetrahedronSlope> ofTetrahedra = tetrahedronSlopes(tetrahedra, state.position);
  const Points root = state.inverseMass.cwiseSqrt();
  Points force(3, root.cols());
  return largestEigenvalue(
      [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
        const Points u = root.cwiseProduct(v.reshaped(3, root.cols()));
        force.setZero();
        addSpringForces(springs, slopes, u, force);
        addTetrahedronForces(tetrahedra, ofTetrahedra, u, force);
        for (const Points& g : gradients) force += dot(g, u) * g;
        return root.cwiseProduct(force).reshaped();
      },
      root.size(), tolerance);
}

// --- the choice --------------------------------------------------------------------------------------------

namespace {

/// Largest omega dt of a Verlet substep: a share of the stability limit 2. The bound on omega is exact only
/// for a single spring; even there this share keeps the discrete oscillation away from the limit, where its
/// amplitude grows without bound.
constexpr double kLargestPhaseStep = 0.9 * 2.0;

/// Number of stable Verlet substeps that cost as much as one implicit substep (bench/run accuracy: spinning
/// cubes, block). The default period tolerance requires up to twice as many. Implicit steppers are much less
/// accurate.
constexpr double kVerletPerImplicit = 60.0;
constexpr int kImplicitSubsteps = 4;

/// With a smaller tolerance, accurate oscillations are required. The midpoint rule's error of a period,
/// (omega h)^2 / 12, is twice that of Verlet with as many substeps, each of which costs it a hundred times as
/// much: it cannot provide an accuracy that is too expensive for Verlet.
constexpr double kDefaultPeriodTolerance = Stepping{}.periodTolerance;

/// Damping rate times substep, above which dampers would remove all speed within a substep. Damping steps
/// split off from the motion then brake more than true dampers.
constexpr double kStrongDamping = 1.0;

/// rad, largest rotation of a spring per substep. A step is a straight line: it lengthens a spring that
/// rotates by t by t^2 / 2 of its length.
constexpr double kMaxRotation = 0.25;

/// Largest number of substeps per tick due to rotation. Faster rotation, as of a spring whose ends pass each
/// other, ends within a substep and cannot be resolved.
constexpr double kMaxForRotation = 1000.0;

/// Largest number of substeps that a tolerance asks for: a substep of an implicit stepper takes up to 1 ms.
constexpr int kMaxForTolerance = 1000;

/// Largest number of implicit substeps of a body that touches something. Each may take a millisecond there;
/// kMaxSubsteps of Verlet take less time than more of them.
constexpr int kMaxTouchingImplicit = 100;

/// Share of a tolerance that is used as target: the estimate of the error is accurate to about 10 %.
constexpr double kSafety = 0.7;

/// Returns the substeps that the tolerance requires. The error is proportional to the square of the substep.
int neededSubsteps(const SteppingProblem& p, const Stepping& s) {
  double tolerance = s.tolerance > 0.0 ? s.tolerance : std::numeric_limits<double>::infinity();
  if (s.relativeTolerance > 0.0) tolerance = std::min(tolerance, s.relativeTolerance * p.size);
  const double needed = std::ceil(p.tick * std::sqrt(p.errorCoefficient / (kSafety * tolerance)));
  return static_cast<int>(std::clamp(needed, 1.0, double(kMaxForTolerance)));
}

Stepper implicitFor(const SteppingProblem& p, bool strong) {
  return strong || p.narrow || p.cheapNewton ? Stepper::BandedNewton : Stepper::ImplicitMidpoint;
}

/// Substeps that Verlet needs: for stability, with the default period tolerance, and with the settings.
struct VerletNeed {
  int stable, atDefault, accurate;
};

VerletNeed verletNeed(const SteppingProblem& p, const Stepping& s) {
  const auto count = [&](int minSubsteps, double periodTolerance) {
    Stepping stepping;
    stepping.minSubsteps = minSubsteps;
    stepping.periodTolerance = periodTolerance;
    return substepCount(p.frequencies, p.tick, stepping);
  };
  return {count(1, 1.0), count(s.minSubsteps, kDefaultPeriodTolerance),
          count(s.minSubsteps, s.periodTolerance)};
}

/// A free body that needs many substeps of Verlet is stepped implicitly. A pinned one is not: where substeps
/// do not resolve the springs, the limit on energy also brakes the swing about the pin. A smaller tolerance
/// can only change the choice from an implicit stepper to Verlet, which is more accurate: a period tolerance
/// below the default excludes steppers that cannot meet it, and an error tolerance makes them more expensive.
/// So no error rises when a tolerance falls.
Stepper choose(const SteppingProblem& p, const Stepping& s, const VerletNeed& verlet, int implicit) {
  if (!p.implicitPossible || (p.touching && implicit > kMaxTouchingImplicit)) return Stepper::Verlet;
  if (s.stepper != Stepper::Auto) return s.stepper;
  const bool strong = p.cheapNewton && p.dampingRate * p.tick / verlet.atDefault > kStrongDamping;
  const bool many = verlet.stable > kVerletPerImplicit * implicit && !p.touching && !p.held &&
                    s.periodTolerance >= kDefaultPeriodTolerance;
  return strong || many ? implicitFor(p, strong) : Stepper::Verlet;
}

/// Errors of the midpoint rule are proportional to the square of the substep, as those of Verlet.
int implicitNeed(const Stepping& s) {
  const double finer =
      std::sqrt(kDefaultPeriodTolerance / std::min(s.periodTolerance, kDefaultPeriodTolerance));
  const double needed = std::min(std::ceil(kImplicitSubsteps * finer), double(kMaxForTolerance));
  return std::max(s.minSubsteps, static_cast<int>(needed));
}

}  // namespace

double frequencyBoundSquared(const SpringArrays& springs, const Points& inverseMass,
                             std::vector<double>& stiffnessSums) {
  stiffnessSums.assign(static_cast<std::size_t>(inverseMass.cols()), 0.0);
  const double stiffened = springs->limit.stiffenStrain > 0.0 ? springs->limit.stiffenFactor : 1.0;
  const auto stiffness = [&](std::size_t s) {
    return stiffened * std::max(springs->extensionStiffness[s], springs->compressionStiffness[s]);
  };
  for (std::size_t s = 0; s < springs.size(); ++s) {
    stiffnessSums[springs->a[s]] += stiffness(s);
    stiffnessSums[springs->b[s]] += stiffness(s);
  }
  double bound = 0.0;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto rowPart = [&](std::uint32_t i) { return inverseMass.col(i).maxCoeff() * stiffnessSums[i]; };
    bound = std::max(bound, rowPart(springs->a[s]) + rowPart(springs->b[s]));
  }
  return bound;
}

int substepCount(const Frequencies& frequencies, double tick, const Stepping& settings) {
  const double stable = std::sqrt(frequencies.boundSquared) * tick / kLargestPhaseStep;
  const double exact = std::sqrt(frequencies.fastestSquared / (24.0 * settings.periodTolerance)) * tick;
  const double needed = std::ceil(std::max(stable, exact));
  return std::max(settings.minSubsteps, static_cast<int>(std::min(needed, 1e9)));
}

double dampingRateBound(const SpringArrays& springs, const Points& inverseMass) {
  double rate = 0.0;
  for (std::size_t i = 0; i < springs.size(); ++i)
    rate = std::max(rate, springs->damping[i] * inverseMassesOf(springs, inverseMass, i));
  return rate;
}

double fastestTurn(const SpringArrays& springs, const PointState& state, double fastest, double negligible) {
  // two ends differ by at most twice the largest difference from a common velocity
  if (2.0 * fastest <= negligible * springs->shortest) return 0.0;
  double largest = 0.0;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    // a spring of rest length 0 pulls in proportion to its length, at any rotation
    if (springs->restLength[i] == 0.0) continue;
    const Eigen::Vector3d d = state.position.col(springs->b[i]) - state.position.col(springs->a[i]);
    const Eigen::Vector3d u = state.velocity.col(springs->b[i]) - state.velocity.col(springs->a[i]);
    // fast rotation of a spring that is nearly folded up does not matter
    const double squared = std::max(d.squaredNorm(), springs->restLength[i] * springs->restLength[i]);
    if (squared > 0.0) largest = std::max(largest, (u - u.dot(d) / squared * d).squaredNorm() / squared);
  }
  return std::sqrt(largest);
}

SteppingChoice chooseStepping(const SteppingProblem& p, const Stepping& s) {
  const int forRotation =
      static_cast<int>(std::min(std::ceil(p.turnRate * p.tick / kMaxRotation), kMaxForRotation));
  const int required = std::max(forRotation, neededSubsteps(p, s));
  const VerletNeed need = verletNeed(p, s);
  const int implicit = std::max(implicitNeed(s), required);
  SteppingChoice choice;
  choice.stepper = choose(p, s, need, implicit);
  const bool verlet = choice.stepper == Stepper::Verlet;
  choice.substeps = verlet ? std::max(need.accurate, required) : implicit;
  const int limit = s.maxSubsteps > 0 ? s.maxSubsteps : kMaxSubsteps;
  choice.cut = choice.substeps > limit;
  choice.substeps = std::min(choice.substeps, limit);
  return choice;
}

}  // namespace limber

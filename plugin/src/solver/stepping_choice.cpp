// SPDX-License-Identifier: Zlib
#include "solver/stepping_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace limber {
namespace {

/// Of Verlet's stability limit omega dt = 2. The bound on omega is exact only for a single spring; there this
/// share still keeps the discrete oscillation away from the limit, where its amplitude grows without bound.
constexpr double kLargestPhaseStep = 0.9 * 2.0;

/// Substeps of Verlet, as many as are stable, that cost what one of the implicit steppers does (bench/run accuracy:
/// spinning cubes, block): the usual period tolerance takes up to twice as many. Implicit ones are much less accurate.
constexpr double kVerletPerImplicit = 60.0;
constexpr int kImplicitSubsteps = 4;

/// Who asks for less than this wants oscillations to be true. The midpoint rule's error of a period,
/// (omega h)^2 / 12, is twice that of Verlet in as many substeps, each of which costs it a hundred times as
/// much: it cannot give what is too dear for Verlet.
constexpr double kUsualPeriodTolerance = Stepping{}.periodTolerance;

/// Dampers that take all speed away in less than a substep: the split-off damping then brakes more than the
/// true one.
constexpr double kStrongDamping = 1.0;

/// rad that a spring may turn per substep. A step is a straight line: it makes a spring that turns by t
/// longer by t^2 / 2 of its length.
constexpr double kLargestTurn = 0.25;

/// Substeps per tick for the sake of turning. Faster turning, as of a spring whose ends pass each other, is
/// over within a substep: there is nothing to be followed.
constexpr double kMostForTurning = 1000.0;

/// Share of a tolerance that is aimed at: the estimate is good to some ten per cent.
constexpr double kSafety = 0.7;

/// Substeps that the tolerance asks for, the error being proportional to the square of the substep.
int neededSubsteps(const SteppingProblem& p, const Stepping& s) {
  double tolerance = s.tolerance > 0.0 ? s.tolerance : std::numeric_limits<double>::infinity();
  if (s.relativeTolerance > 0.0) tolerance = std::min(tolerance, s.relativeTolerance * p.size);
  const double needed = std::ceil(p.tick * std::sqrt(p.errorPerSquare / (kSafety * tolerance)));
  return static_cast<int>(std::clamp(needed, 1.0, 1e6));
}

Stepper implicitFor(const SteppingProblem& p, bool strong) {
  return strong || p.narrow || p.cheapNewton ? Stepper::BandedNewton : Stepper::ImplicitMidpoint;
}

/// What Verlet needs: not to become unstable, with the usual settings, and with these.
struct VerletNeed {
  int stable, usual, wanted;
};

VerletNeed verletNeed(const SteppingProblem& p, const Stepping& s) {
  const auto count = [&](int atLeast, double periodTolerance) {
    Stepping asked;
    asked.atLeast = atLeast;
    asked.periodTolerance = periodTolerance;
    return substepCount(p.frequencies, p.tick, asked);
  };
  return {count(1, 1.0), count(s.atLeast, kUsualPeriodTolerance), count(s.atLeast, s.periodTolerance)};
}

/// A free body that needs many substeps of Verlet is stepped implicitly. A pinned one is not: where substeps do not
/// resolve the springs, the guard against a gain of energy also brakes what swings about the pin.
/// A smaller tolerance only ever takes the choice from an implicit stepper to Verlet, which is more exact: one of the
/// period below the usual rules out what cannot meet it, one of the error makes it dearer. So no error rises when a
/// tolerance falls.
Stepper choose(const SteppingProblem& p, const Stepping& s, const VerletNeed& verlet, int implicit) {
  if (!p.implicitPossible) return Stepper::Verlet;
  if (s.stepper != Stepper::Auto) return s.stepper;
  const bool strong = p.cheapNewton && p.dampingRate * p.tick / verlet.usual > kStrongDamping;
  const bool tooDear = s.budget > 0 && verlet.stable > s.budget;
  const bool many = verlet.stable > kVerletPerImplicit * implicit && !p.touching && !p.held &&
                    s.periodTolerance >= kUsualPeriodTolerance;
  return strong || tooDear || many ? implicitFor(p, strong) : Stepper::Verlet;
}

/// Errors of the midpoint rule fall with the square of the substep, as Verlet's do.
int implicitNeed(const Stepping& s) {
  const double finer = std::sqrt(kUsualPeriodTolerance / std::min(s.periodTolerance, kUsualPeriodTolerance));
  return std::max(s.atLeast, static_cast<int>(std::min(std::ceil(kImplicitSubsteps * finer), 1e6)));
}

}  // namespace

double frequencyBoundSquared(const SpringArrays& springs, const Points& inverseMass,
                             std::vector<double>& stiffnessSums) {
  stiffnessSums.assign(static_cast<std::size_t>(inverseMass.cols()), 0.0);
  const double stiffened = springs.limit.stiffenStrain > 0.0 ? springs.limit.stiffenFactor : 1.0;
  const auto stiffness = [&](std::size_t s) {
    return stiffened * std::max(springs.extensionStiffness[s], springs.compressionStiffness[s]);
  };
  for (std::size_t s = 0; s < springs.size(); ++s) {
    stiffnessSums[springs.a[s]] += stiffness(s);
    stiffnessSums[springs.b[s]] += stiffness(s);
  }
  double bound = 0.0;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto rowPart = [&](std::uint32_t i) { return inverseMass.col(i).maxCoeff() * stiffnessSums[i]; };
    bound = std::max(bound, rowPart(springs.a[s]) + rowPart(springs.b[s]));
  }
  return bound;
}

int substepCount(const Frequencies& frequencies, double tick, const Stepping& settings) {
  const double stable = std::sqrt(frequencies.boundSquared) * tick / kLargestPhaseStep;
  const double exact = std::sqrt(frequencies.fastestSquared / (24.0 * settings.periodTolerance)) * tick;
  const double needed = std::ceil(std::max(stable, exact));
  return std::max(settings.atLeast, static_cast<int>(std::min(needed, 1e9)));
}

double dampingRateBound(const SpringArrays& springs, const Points& inverseMass) {
  double rate = 0.0;
  for (std::size_t i = 0; i < springs.size(); ++i)
    rate = std::max(rate, springs.damping[i] * inverseMassesOf(springs, inverseMass, i));
  return rate;
}

double fastestTurn(const SpringArrays& springs, const PointState& state, double negligible) {
  // two ends differ by at most twice the largest difference from point 0
  const double largest =
      2.0 * std::sqrt((state.velocity.colwise() - state.velocity.col(0)).colwise().squaredNorm().maxCoeff());
  if (largest <= negligible * springs.shortest) return 0.0;
  double fastest = 0.0;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    // a spring without length at rest pulls in proportion to its length, however it turns
    if (springs.restLength[i] == 0.0) continue;
    const Eigen::Vector3d d = state.position.col(springs.b[i]) - state.position.col(springs.a[i]);
    const Eigen::Vector3d u = state.velocity.col(springs.b[i]) - state.velocity.col(springs.a[i]);
    // a spring that is nearly folded up turns as fast as it likes without mattering
    const double squared = std::max(d.squaredNorm(), springs.restLength[i] * springs.restLength[i]);
    if (squared > 0.0) fastest = std::max(fastest, (u - u.dot(d) / squared * d).squaredNorm() / squared);
  }
  return std::sqrt(fastest);
}

SteppingChoice chooseStepping(const SteppingProblem& p, const Stepping& s) {
  const int turning = static_cast<int>(std::min(std::ceil(p.turnRate * p.tick / kLargestTurn), kMostForTurning));
  const int followed = std::max(turning, neededSubsteps(p, s));
  const VerletNeed need = verletNeed(p, s);
  const int implicit = std::max(implicitNeed(s), followed);
  SteppingChoice choice;
  choice.stepper = choose(p, s, need, implicit);
  const bool verlet = choice.stepper == Stepper::Verlet;
  choice.substeps = verlet ? std::max(need.wanted, followed) : implicit;
  if (s.budget <= 0) return choice;
  const int most = std::max(s.budget, verlet ? need.stable : 1);
  choice.cut = choice.substeps > most;
  choice.substeps = std::min(choice.substeps, most);
  return choice;
}

}  // namespace limber

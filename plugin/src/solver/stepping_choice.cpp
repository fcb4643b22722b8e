// SPDX-License-Identifier: Zlib
// Computes the frequencies of a body's oscillations, chooses its stepper and number of substeps, and softens
// what these do not resolve.

#include "solver/stepping_choice.h"

#include "mesh/linear_algebra.h"

#include <limits>

namespace limber {
namespace {

// --- the fastest oscillation -------------------------------------------------------------------------------

using Eigen::Index;
using Eigen::Vector3d;

/// Returns the larger stiffness (N/m) of spring i, also beyond its stiffening strain.
double stiffest(const SpringConstants& s, std::size_t i) {
  const double stiffened = s.limit.stiffenStrain > 0.0 ? s.limit.stiffenFactor : 1.0;
  return stiffened * std::max(s.extensionStiffness[i], s.compressionStiffness[i]);
}

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
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d d = x.col(springs->b[i]) - x.col(springs->a[i]);
    const double length = d.norm();
    s.direction.col(static_cast<Index>(i)) = d.stableNormalized();
    s.along[i] = stiffest(*springs.operator->(), i);
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

/// The same of a body that touches something: up to there the sweeps of Verlet's dampers follow (springs.h),
/// and Newton's method, which must find which contacts hold, takes up to three hundred times as long.
constexpr double kStrongTouching = 16.0;

/// rad, largest rotation of a spring per substep. A step is a straight line: it lengthens a spring that
/// rotates by t by t^2 / 2 of its length.
constexpr double kMaxRotation = 0.25;

/// Largest number of substeps per tick due to rotation. Faster rotation, as of a spring whose ends pass each
/// other, ends within a substep and cannot be resolved.
constexpr double kMaxForRotation = 1000.0;

/// rad, a rotation per tick that the usual number of substeps resolves in any case.
constexpr double kNegligibleTurn = 0.5;

/// rad^2, largest product of the angles by which a body turns and by which its fastest oscillation of rate w
/// advances in an implicit substep. The midpoint rule keeps stiff springs at their length in the middle of a
/// substep. At its end, after turning by t, they are longer by t^2 / 8 of it: of a body of mass m and radius
/// r the energy is about  m r^2 w^2 (t^2 / 8)^2 / 2.  Where that comes near the kinetic energy, the limit of
/// the energy takes it from the rotation: with 36 a cube of 1e8 N/m loses two thirds of it in ten seconds,
/// with 3 a body of tetrahedra of 1e7 N/m all of it at once.
constexpr double kMaxSpin = 0.5;

/// Largest damping rate times substep in an impact, and the largest factor by which an impact raises Verlet's
/// number of substeps. Contacts stop the points that touch, and dampers set these in motion again: in each
/// substep a contact takes the momentum of the points that touch, not that of all points which a strong
/// damper has stopped by then. So an impact is braked too weakly, and the body compressed and thrown back too
/// much: a block of Material::foam() whose rate times substep is 7.6 rebounds at twice its speed.
constexpr double kImpactDamping = 2.0;
constexpr int kMostForImpact = 4;

/// Share of the body's size by which an impact may change its shape within a tick without more substeps.
constexpr double kNegligibleImpact = 2e-3;

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

/// Returns the substeps of Verlet that an impact on a strongly damped body requires, at least `otherwise`.
int forImpact(const SteppingProblem& p, int otherwise) {
  if (!(p.impactSpeed * p.tick > kNegligibleImpact * p.size)) return otherwise;
  const double wanted = std::ceil(p.dampingRate * p.tick / kImpactDamping);
  return static_cast<int>(std::clamp(wanted, 1.0 * otherwise, 1.0 * kMostForImpact * otherwise));
}

Stepper implicitFor(const SteppingProblem& p, bool strong) {
  return strong || p.narrow || p.cheapNewton ? Stepper::Newton : Stepper::ImplicitMidpoint;
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
  const double strength = p.dampingRate * p.tick / verlet.atDefault;
  const bool strong = p.cheapNewton && strength > (p.touching ? kStrongTouching : kStrongDamping);
  const bool many = verlet.stable > kVerletPerImplicit * implicit && !p.touching && !p.held &&
                    s.periodTolerance >= kDefaultPeriodTolerance;
  return strong || many ? implicitFor(p, strong) : Stepper::Verlet;
}

/// Errors of the midpoint rule are proportional to the square of the substep, as those of Verlet.
int implicitNeed(const SteppingProblem& p, const Stepping& s) {
  const double finer =
      std::sqrt(kDefaultPeriodTolerance / std::min(s.periodTolerance, kDefaultPeriodTolerance));
  const double spinning = p.tick * std::sqrt(p.turnRate * std::sqrt(p.frequencies.fastestSquared) / kMaxSpin);
  const double needed =
      std::min(std::ceil(std::max(kImplicitSubsteps * finer, spinning)), double(kMaxForTolerance));
  return std::max(s.minSubsteps, static_cast<int>(needed));
}

}  // namespace

double frequencyBoundSquared(const SpringArrays& springs, const Points& inverseMass,
                             std::vector<double>& stiffnessSums) {
  stiffnessSums.assign(static_cast<std::size_t>(inverseMass.cols()), 0.0);
  for (std::size_t s = 0; s < springs.size(); ++s)
    for (const std::uint32_t end : {springs->a[s], springs->b[s]})
      stiffnessSums[end] += stiffest(*springs.operator->(), s);
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

double negligibleTurn(double fastestSquared, double tick) {
  const double stiff = kMaxSpin * kImplicitSubsteps * kImplicitSubsteps / (std::sqrt(fastestSquared) * tick);
  return std::min(kNegligibleTurn, stiff) / tick;
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
  const int implicit = std::max(implicitNeed(p, s), required);
  SteppingChoice choice;
  choice.stepper = choose(p, s, need, implicit);
  const bool verlet = choice.stepper == Stepper::Verlet;
  choice.substeps = verlet ? std::max(forImpact(p, need.accurate), required) : implicit;
  const int limit = s.maxSubsteps > 0 ? s.maxSubsteps : kMaxSubsteps;
  choice.cut = choice.substeps > limit;
  choice.substeps = std::min(choice.substeps, limit);
  return choice;
}

// --- softer constants --------------------------------------------------------------------------------------

namespace {

/// The bounds after softening must not be above the limit by rounding.
constexpr double kRounding = 1.0 - 1e-9;

/// The parts of the bound of a body's oscillations, rad^2/s^2.
struct Bounds {
  double springs, volumes, tetrahedra;
};

Bounds boundsAtRest(const ElasticConstants& full, const Points& restShape, const Points& inverseMass) {
  PointState rest;
  rest.resize(restShape.cols());
  rest.position = restShape;
  rest.inverseMass = inverseMass;
  SpringArrays springs;
  springs.original = full.springs;
  VolumeArrays volumes;
  volumes.constants = full.volumes;
  TetrahedronVolumes tetrahedra;
  tetrahedra.constants = full.tetrahedra;
  std::vector<double> sums;
  return {frequencyBoundSquared(springs, inverseMass, sums), volumeFrequencyBoundSquared(volumes, rest, 0.0),
          tetrahedronFrequencyBoundSquared(tetrahedra, rest)};
}

/// Relative tolerance of the eigenvalue below, whose square is its error, and a margin above that error.
constexpr double kEigenvalueTolerance = 0.03, kMargin = 1.01;

/// Returns a bound (rad^2/s^2) of the oscillations of springs of the stiffness k (N/m) at any deformation:
/// the largest eigenvalue of  W L W  with the graph's Laplacian L = sum k (e_a - e_b) (e_a - e_b)^T  and the
/// roots W of the inverse masses, because no spring is stiffer than k in any direction. Gershgorin's bound of
/// it is up to twice as large.
double graphBoundSquared(const SpringConstants& springs, const Eigen::VectorXd& k,
                         const Eigen::VectorXd& inverseMass) {
  const Eigen::VectorXd root = inverseMass.cwiseSqrt();
  Eigen::VectorXd force(root.size());
  const auto multiply = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
    force.setZero();
    for (std::size_t i = 0; i < springs.a.size(); ++i) {
      const Eigen::Index a = springs.a[i], b = springs.b[i];
      const double pull = k[static_cast<Eigen::Index>(i)] * (root[b] * v[b] - root[a] * v[a]);
      force[a] -= pull;
      force[b] += pull;
    }
    return root.cwiseProduct(force);
  };
  return kMargin * largestEigenvalue(multiply, root.size(), kEigenvalueTolerance);
}

/// Returns the stiffness (N/m) of the springs at each point, the softest one first.
std::vector<std::vector<double>> springsOfPoints(const SpringConstants& springs, const Eigen::VectorXd& k,
                                                 Eigen::Index points) {
  std::vector<std::vector<double>> all(static_cast<std::size_t>(points));
  for (std::size_t i = 0; i < springs.a.size(); ++i)
    for (const std::uint32_t end : {springs.a[i], springs.b[i]})
      all[end].push_back(k[static_cast<Eigen::Index>(i)]);
  for (std::vector<double>& stiffness : all) std::sort(stiffness.begin(), stiffness.end());
  return all;
}

/// Returns the largest stiffness (N/m) c for which  sum min(k, c) <= largest  over the springs of a point.
double cap(const std::vector<double>& stiffness, double largest) {
  auto left = static_cast<double>(stiffness.size());
  for (const double k : stiffness) {
    if (left * k >= largest) return largest / left;
    largest -= k, left -= 1.0;
  }
  return std::numeric_limits<double>::infinity();
}

/// Softens springs to the bound `largest`. Returns the smallest share. First the stiffest springs of each
/// point get so soft that its row  w sum k  is at most half of `largest`, as Gershgorin's bound requires;
/// then these are made stiffer by what the graph's bound is below that.
double soften(SpringConstants& springs, const Points& inverseMass, double largest) {
  const Eigen::VectorXd w = inverseMass.colwise().maxCoeff();
  Eigen::VectorXd k(static_cast<Eigen::Index>(springs.a.size()));
  for (std::size_t i = 0; i < springs.a.size(); ++i) k[static_cast<Eigen::Index>(i)] = stiffest(springs, i);
  const std::vector<std::vector<double>> all = springsOfPoints(springs, k, w.size());
  Eigen::VectorXd caps(w.size()), share(k.size());
  for (Eigen::Index i = 0; i < w.size(); ++i)
    caps[i] = w[i] > 0.0 ? cap(all[static_cast<std::size_t>(i)], 0.5 * largest / w[i]) : HUGE_VAL;
  for (Eigen::Index i = 0; i < k.size(); ++i) {
    const auto s = static_cast<std::size_t>(i);
    const double most = std::min(caps[springs.a[s]], caps[springs.b[s]]);
    share[i] = k[i] > most ? most / k[i] : 1.0;
  }
  const double bound = graphBoundSquared(springs, share.cwiseProduct(k), w);
  if (bound < largest) share = (largest / bound * share).cwiseMin(1.0);
  for (Eigen::Index i = 0; i < k.size(); ++i) {
    springs.extensionStiffness[static_cast<std::size_t>(i)] *= share[i];
    springs.compressionStiffness[static_cast<std::size_t>(i)] *= share[i];
  }
  return share.size() ? share.minCoeff() : 1.0;
}

/// The shares of their stiffness that springs, closed surfaces and tetrahedra keep. A part that takes at most
/// a third of `largest` keeps all, and the others share the rest in proportion. With a pressure above the
/// ambient one no part does: it is in equilibrium with the springs.
struct Shares {
  double slow, others;

  Shares(const Bounds& bounds, double largest, bool underPressure)
      : slow(underPressure ? 0.0 : largest / 3.0) {
    double kept = 0.0, shared = 0.0;
    for (const double bound : {bounds.springs, bounds.volumes, bounds.tetrahedra})
      (bound <= slow ? kept : shared) += bound;
    others = shared > 0.0 ? std::min(1.0, kRounding * (largest - kept) / shared) : 1.0;
  }
  double of(double bound) const { return bound <= slow ? 1.0 : others; }
};

}  // namespace

SoftenedConstants softened(const ElasticConstants& full, const Points& restShape, const Points& inverseMass,
                           double largest) {
  SoftenedConstants result{full, 1.0, largest, inverseMass};
  const Bounds bounds = boundsAtRest(full, restShape, inverseMass);
  const Shares shares(bounds, largest, full.volumes->gasPressure > full.volumes->ambient);
  if (const double share = shares.of(bounds.springs); share < 1.0) {
    SpringConstants springs = *full.springs;
    result.share = soften(springs, inverseMass, share * bounds.springs);
    result.constants.springs = SharedConstants<SpringConstants>(std::move(springs));
  }
  if (const double share = shares.of(bounds.volumes); share < 1.0) {
    VolumeConstants volumes = *full.volumes;
    volumes.modulus *= share;
    volumes.gasPressure *= share;
    volumes.ambient *= share;
    result.share = std::min(result.share, share);
    result.constants.volumes = SharedConstants<VolumeConstants>(std::move(volumes));
  }
  if (const double share = shares.of(bounds.tetrahedra); share < 1.0) {
    TetrahedronConstants tetrahedra = *full.tetrahedra;
    tetrahedra.modulus *= share;
    tetrahedra.crushModulus *= share;
    result.share = std::min(result.share, share);
    result.constants.tetrahedra = SharedConstants<TetrahedronConstants>(std::move(tetrahedra));
  }
  return result;
}

std::shared_ptr<const SoftenedConstants> softened(SharedSoftening& shared, const ElasticConstants& full,
                                                  const Points& restShape, const Points& inverseMass,
                                                  double largest) {
  return shared.get(
      [&](const SoftenedConstants& known) {
        return known.largest == largest && known.inverseMass == inverseMass;
      },
      [&] { return softened(full, restShape, inverseMass, largest); });
}

}  // namespace limber

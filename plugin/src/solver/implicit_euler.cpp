// SPDX-License-Identifier: Zlib
// Solves the substeps of implicit Euler: the bodies as wholes, their springs and contacts, violent motion.
#include "solver/implicit_euler.h"

#include "mesh/linear_algebra.h"
#include "solver/implicit_system.h"

#include <Eigen/Geometry>

namespace limber {
namespace {

/// Of one body, and of bodies that push each other.
constexpr int kImplicitIterations = 8, kCoupledIterations = 24;

/// ImplicitSystem::bodyOf of a rigid body's columns.
constexpr std::uint32_t kNoBody = static_cast<std::uint32_t>(-1);

// --- the body as a whole ----------------------------------------------------------------------------------

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Returns the points that are not held. The mass is 0 if a point is held along some axes only.
WholeBody wholeBodyOf(const PointState& p) {
  WholeBody whole;
  for (Index i = 0; i < p.position.cols(); ++i)
    if (p.inverseMass.col(i).minCoeff() != p.inverseMass.col(i).maxCoeff()) return whole;
  for (Index i = 0; i < p.position.cols(); ++i) {
    whole.mass += massOf(p.inverseMass, i);
    whole.center += massOf(p.inverseMass, i) * p.position.col(i);
  }
  if (!(whole.mass > 0.0)) return whole;
  whole.center /= whole.mass;
  for (Index i = 0; i < p.position.cols(); ++i) {
    const Vector3d r = p.position.col(i) - whole.center;
    whole.inertia += massOf(p.inverseMass, i) * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose());
  }
  return whole;
}

/// Impulse and angular impulse of `share` at a point.
Vector6d momenta(const WholeBody& whole, const Vector3d& position, const Vector3d& share) {
  Vector6d all;
  all << share, (position - whole.center).cross(share);
  return all;
}

/// Adds what the external rows resist to the mass matrices of the bodies that they touch.
void addRowsToWholes(ImplicitSystem& s, const Part& part) {
  for (const StiffRow& row : s.rows) {
    if (!row.external) continue;
    for (std::size_t t = row.firstTerm; t < row.endTerm;) {
      const std::uint32_t body = s.bodyOf[s.terms[t].column];
      Vector6d sum = Vector6d::Zero();
      for (; t < row.endTerm && s.bodyOf[s.terms[t].column] == body; ++t) {
        if (body == kNoBody || s.free.col(s.terms[t].column).isZero(0.0f)) continue;
        const Index i = s.terms[t].column - s.firstColumn[body];
        sum += momenta(s.whole[body], part.points(part.begin + body).position.col(i), s.terms[t].share);
      }
      if (body != kNoBody) s.whole[body].matrix += sum * sum.transpose();
    }
  }
}

/// Sets the mass matrices to those of the bodies alone.
void clearWholes(ImplicitSystem& s) {
  for (WholeBody& whole : s.whole) {
    whole.matrix.setZero();
    whole.matrix.diagonal().head<3>().setConstant(whole.mass);
    whole.matrix.bottomRightCorner<3, 3>() = whole.inertia;
  }
}

/// Returns x with A x = b, for a symmetric A that may be singular.
Vector6d solveMasses(const Eigen::Matrix<double, 6, 6>& matrix, const Vector6d& b) {
  SmallMatrix a = matrix;
  a.diagonal().array() += 1e-12 * a.diagonal().maxCoeff();
  SmallVector x = b;
  solveSmall(a, x);
  return x;
}

bool isFree(const PointState& p) { return (p.inverseMass.array() > 0.0).all(); }

/// Adds the rigid motion to s.start that gives a body the linear and angular momentum that it has in
/// s.kicked, and that of the impulses s.total.
void matchMomentum(ImplicitSystem& s, const Part& part, std::size_t body) {
  const WholeBody& whole = s.whole[body];
  const PointState& p = part.points(part.begin + body);
  Vector3d momentum = Vector3d::Zero(), spin = Vector3d::Zero();
  const Index first = s.firstColumn[body];
  for (Index i = 0; i < p.position.cols(); ++i) {
    const double w = s.mobility[static_cast<std::size_t>(first + i)];
    if (w == 0.0) continue;
    const Vector3d missing = (s.kicked.col(first + i) - s.start.col(first + i)) / w + s.total.col(first + i);
    momentum += missing;
    spin += Vector3d(p.position.col(i) - whole.center).cross(missing);
  }
  Vector6d missing;
  missing << momentum, spin;
  const Vector6d motion = solveMasses(whole.matrix, missing);
  const Vector3d shift = motion.head<3>(), turn = motion.tail<3>();
  for (Index i = 0; i < p.position.cols(); ++i)
    if (s.mobility[static_cast<std::size_t>(first + i)] > 0.0)
      s.start.col(first + i) += shift + turn.cross(Vector3d(p.position.col(i) - whole.center));
}

/// Does so for all bodies, with the impulses between bodies.
void matchMomenta(ImplicitSystem& s, const Part& part) {
  s.total = s.push;
  for (const StiffRow& row : s.rows)
    if (row.external) apply(s, row, impulseOf(s, row, s.start), s.total);
  for (std::size_t body = 0; body < s.whole.size(); ++body)
    if (s.whole[body].mass > 0.0) matchMomentum(s, part, body);
}

// --- violent motion ---------------------------------------------------------------------------------------

/// J: energy of the springs of a body at the positions `x`, with the stiffness that the step gives them.
double springEnergy(const ImplicitSystem& s, const SpringArrays& springs, Index first, const Points& x,
                    double dt) {
  double energy = 0.0;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const std::uint32_t a = springs->a[i], b = springs->b[i];
    const double phase =
        dt * dt *
        (s.mobility[static_cast<std::size_t>(first + a)] + s.mobility[static_cast<std::size_t>(first + b)]);
    const double stretch = (x.col(b) - x.col(a)).norm() - springs->restLength[i];
    // a stiffened spring: the force rises along two straight lines
    const double limit = springs->limit.stiffenStrain > 0.0
                             ? springs->limit.stiffenStrain * springs.original->restLength[i]
                             : HUGE_VAL;
    const double below = std::copysign(std::min(std::abs(stretch), limit), stretch);
    energy += 0.5 * slopeOf(springs, i, below, phase).force * below;
    if (std::abs(stretch) > limit)
      energy += 0.5 * (slopeOf(springs, i, below, phase).force + slopeOf(springs, i, stretch, phase).force) *
                (stretch - below);
  }
  return energy;
}

double bodyEnergy(const ImplicitSystem& s, const SolverBody& body, Index first, const Points& x, double dt) {
  return springEnergy(s, *body.springs, first, x, dt) +
         (body.volumes ? volumeEnergy(*body.volumes, x) : 0.0) +
         (body.tetrahedra ? tetrahedronEnergy(*body.tetrahedra, x) : 0.0);
}

/// The rigid motion of a body with the momenta of `velocity` (m/s, 3 x #columns); none if it is not free.
struct RigidPart {
  Vector3d center, shift = Vector3d::Zero(), turn = Vector3d::Zero();

  RigidPart(const ImplicitSystem& s, std::size_t body, const PointState& p, const Points& velocity)
      : center(s.whole[body].center) {
    const WholeBody& whole = s.whole[body];
    if (!(whole.mass > 0.0) || (p.inverseMass.array() == 0.0).any()) return;
    Vector3d momentum = Vector3d::Zero(), spin = Vector3d::Zero();
    for (Index i = 0; i < p.position.cols(); ++i) {
      const Vector3d part = massOf(p.inverseMass, i) * velocity.col(s.firstColumn[body] + i);
      momentum += part;
      spin += Vector3d(p.position.col(i) - center).cross(part);
    }
    shift = momentum / whole.mass;
    turn = pseudoInverse(whole.inertia) * spin;
  }
  Vector3d at(const Vector3d& x) const { return shift + turn.cross(Vector3d(x - center)); }
};

/// J: kinetic energy of the motion relative to `rigid`.
double relativeEnergy(const PointState& p, const Points& velocity, Index first, const RigidPart& rigid) {
  double energy = 0.0;
  for (Index i = 0; i < p.position.cols(); ++i)
    energy += 0.5 * massOf(p.inverseMass, i) *
              (velocity.col(first + i) - rigid.at(p.position.col(i))).squaredNorm();
  return energy;
}

constexpr int kMaxHalvings = 8;

/// Halves the motion of a body relative to its rigid motion until the substep adds no energy to it. The
/// linear step is exact for small turns only.
void limitEnergy(ImplicitSystem& s, std::size_t number, SolverBody& body, Index first, double dt) {
  const PointState& p = *body.points;
  const RigidPart before(s, number, p, s.kicked), after(s, number, p, s.start);
  const double allowed =
      relativeEnergy(p, s.kicked, first, before) + bodyEnergy(s, body, first, p.position, dt);
  const Index count = p.position.cols();
  for (int halvings = 0; halvings < kMaxHalvings; ++halvings) {
    s.gradient = p.position + dt * s.start.middleCols(first, count);
    if (relativeEnergy(p, s.start, first, after) + bodyEnergy(s, body, first, s.gradient, dt) <= allowed)
      return;
    for (Index i = 0; i < count; ++i) {
      if (isHeld(p.inverseMass, i)) continue;
      const Vector3d rigid = after.at(p.position.col(i));
      s.start.col(first + i) = rigid + 0.5 * (s.start.col(first + i) - rigid);
    }
  }
}

// --- one part ---------------------------------------------------------------------------------------------

/// Copies the velocities of all columns of a part to `velocities` (m/s and rad/s, 3 x #columns).
void gather(const Part& part, Points& velocities) {
  const Index points = pointColumns(part);
  const std::vector<RigidState>& rigids = part.group.links.rigids;
  velocities.resize(3, points + (part.together ? 2 * static_cast<Index>(rigids.size()) : 0));
  forEachBody(part, [&](const SolverBody& body, Index first) {
    velocities.middleCols(first, body.points->velocity.cols()) = body.points->velocity;
  });
  for (Index column = points; column < velocities.cols(); ++column) {
    const RigidState& rigid = rigids[static_cast<std::size_t>((column - points) / 2)];
    velocities.col(column) = (column - points) % 2 == 0 ? rigid.velocity : rigid.angularVelocity;
  }
}

/// m/s: root mean square of the change of a body's velocities in the substep, apart from the mean change.
/// Half of it is the speed at which positions of backward Euler depart from the exact ones.
double internalChange(const Eigen::Ref<const Points>& change) {
  const Vector3d mean = change.rowwise().mean();
  return std::sqrt((change.colwise() - mean).squaredNorm() / static_cast<double>(change.cols()));
}

void writeVelocities(ImplicitSystem& s, const Part& part, const Points& before) {
  forEachBody(part, [&](SolverBody& body, Index first) {
    const Index count = body.points->velocity.cols();
    body.points->velocity = s.start.middleCols(first, count);
    s.kicked.middleCols(first, count) = body.points->velocity - before.middleCols(first, count);
    body.errorRate = std::max(body.errorRate, 0.5 * internalChange(s.kicked.middleCols(first, count)));
  });
  if (!part.together) return;
  for (std::uint32_t r = 0; r < part.group.links.rigids.size(); ++r) {
    RigidState& rigid = part.group.links.rigids[r];
    rigid.velocity += s.push.col(columnOfRigid(s, r)).cwiseProduct(rigid.inverseMass);
    rigid.angularVelocity += rigid.inverseInertia * s.push.col(columnOfRigid(s, r) + 1);
  }
}

/// Ends a solve whose linear step is far from the truth: without impulses of contacts and anchors, which are
/// then solved with the masses alone, and without a gain of energy.
void finishViolent(ImplicitSystem& s, const Part& part, double dt) {
  dropHolds(s);
  s.total.setZero();
  clearWholes(s);
  std::size_t number = 0;
  forEachBody(part, [&](SolverBody& body, Index first) {
    const std::size_t i = number++;
    if (isFree(*body.points) && s.whole[i].mass > 0.0) matchMomentum(s, part, i);
    limitEnergy(s, i, body, first, dt);
  });
}

void solvePart(ImplicitSystem& s, const Part& part, const Points& before, double time, double dt) {
  s.firstColumn.clear();
  s.bodyOf.clear();
  s.whole.clear();
  const Index points = forEachBody(part, [&](SolverBody& body, Index first) {
    s.firstColumn.push_back(first);
    s.bodyOf.resize(static_cast<std::size_t>(first + body.points->position.cols()),
                    static_cast<std::uint32_t>(s.whole.size()));
    s.whole.push_back(wholeBodyOf(*body.points));
  });
  s.firstColumn.push_back(points);
  s.bodyOf.resize(static_cast<std::size_t>(before.cols()), kNoBody);
  gather(part, s.kicked);
  s.start = before;
  assembleParts(s, part, dt);
  addHolds(s, part, time, dt);
  clearWholes(s);
  addRowsToWholes(s, part);
  matchMomenta(s, part);
  const int iterations = part.together ? kCoupledIterations : kImplicitIterations;
  solveSystem(s, iterations);
  const bool violent = stiffenTurning(s, dt);
  if (violent) {
    solveSystem(s, iterations);
  }
  for (Index i = 0; i < s.start.cols(); ++i) s.start.col(i) += unpadded(s.step.col(i));
  if (violent) {
    finishViolent(s, part, dt);
  } else {
    matchMomenta(s, part);
    finishHolds(s);
    clearWholes(s);
    matchMomenta(s, part);
  }
  writeVelocities(s, part, before);
}

/// Calls visit(part) for each part of the island.
template <class Visit>
void forEachPart(SolverIsland& group, Visit visit) {
  const std::size_t count = group.bodies.size();
  if (!group.links.springs.empty() || !group.links.anchors.empty() || !group.pairs.contacts.empty())
    return visit(Part{group, 0, count, true});
  for (std::size_t i = 0; i < count; ++i) visit(Part{group, i, i + 1, false});
}

}  // namespace

void prepareImplicit(SolverIsland& group, double dt) {
  for (SolverBody& body : group.bodies) prepareVolumes(body, dt / std::sqrt(kLargestImplicitPhaseSquared));
}

void storeVelocities(ImplicitSystem& system, SolverIsland& group) {
  std::size_t count = 0;
  forEachPart(group, [&](const Part& part) {
    if (system.before.size() <= count) system.before.emplace_back();
    gather(part, system.before[count++]);
  });
}

void solveImplicitly(ImplicitSystem& system, SolverIsland& group, double time, double dt) {
  std::size_t count = 0;
  forEachPart(group, [&](const Part& part) { solvePart(system, part, system.before[count++], time, dt); });
}

}  // namespace limber

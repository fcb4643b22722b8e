// SPDX-License-Identifier: Zlib
// Assembles the linear system of an implicit Euler substep, and solves it by conjugate gradients.
#include "solver/implicit_system.h"

#include "mesh/linear_algebra.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace limber {
namespace {

// --- masses -----------------------------------------------------------------------------------------------

void setMass(ImplicitSystem& s, Index column, const Vector3d& inverseMass) {
  s.block.col(column).setZero();
  s.mass.col(column).setZero();
  s.free.col(column).setZero();
  for (int k = 0; k < 3; ++k) {
    if (!(inverseMass[k] > 0.0)) continue;
    s.block(k, column) = 1.0 / inverseMass[k];
    s.mass(k, column) = static_cast<float>(s.block(k, column));
    s.free(k, column) = 1.0f;
  }
  s.mobility[static_cast<std::size_t>(column)] = inverseMass.maxCoeff();
}

void resize(ImplicitSystem& s, Index columns) {
  for (PaddedPoints* array :
       {&s.mass, &s.free, &s.residual, &s.step, &s.direction, &s.product, &s.preconditioned})
    array->resize(4, columns);
  s.force.setZero(3, columns);
  s.push.setZero(3, columns);
  s.block.resize(6, columns);
  s.mobility.resize(static_cast<std::size_t>(columns));
  s.inverse.resize(static_cast<std::size_t>(columns));
  s.a.clear(), s.b.clear(), s.across.clear(), s.rows.clear(), s.terms.clear(), s.inertia.clear();
  s.held.clear(), s.heldTerms.clear();
}

// --- springs ----------------------------------------------------------------------------------------------

/// Adds a spring's stiffness and damping, its impulse, and what both do against the velocities at which the
/// iterations begin. `along` and `across` are in kg.
void addSpring(ImplicitSystem& s, std::size_t index, const Vector3d& n, double along, double across,
               double impulse, double inverseLength) {
  const Index a = s.a[index], b = s.b[index];
  const Vector3d d = s.start.col(b) - s.start.col(a);
  const Vector3d sum = (impulse + (along - across) * n.dot(d)) * n + across * d;
  s.force.col(a) += sum;
  s.force.col(b) -= sum;
  const Vector3d q = std::sqrt(std::max(0.0, along - across)) * n;
  float* stored = s.along[index].data();
  for (int k = 0; k < 3; ++k) stored[k] = static_cast<float>(q[k]);
  stored[3] = 0.0f;
  s.across[index] = static_cast<float>(across);
  s.inverseLength[index] = static_cast<float>(inverseLength);
  addBlock(s, a, q, across);
  addBlock(s, b, q, across);
}

/// Adds a spring between a point and a held one, which is an outer force on the body as a whole. `n` points
/// from the held end to the other.
void addHeldSpring(ImplicitSystem& s, Index column, Index held, const Vector3d& n, double along,
                   double across, double impulse) {
  const Vector3d tangent = n.unitOrthogonal();
  const auto add = [&](const Vector3d& axis, double weight, double pull) {
    if (!(weight > 0.0)) return;
    const double root = std::sqrt(weight);
    beginRow(s, root * axis.dot(s.kicked.col(held)) - pull / root, true);
    addTerm(s, column, root * axis);
  };
  add(n, along, impulse);
  add(tangent, across, 0.0);
  add(n.cross(tangent), across, 0.0);
}

void addSprings(ImplicitSystem& s, SolverBody& body, Index first, double dt) {
  const SpringArrays& springs = *body.springs;
  const PointState& p = *body.points;
  if (springs->limited) computeSpringForces(*body.springs, *body.points);  // springs may yield or break
  const std::size_t begin = s.a.size();
  s.a.resize(begin + springs.size());
  s.b.resize(begin + springs.size());
  s.across.resize(begin + springs.size());
  s.inverseLength.resize(begin + springs.size());
  s.along.resize(begin + springs.size());
  const double perTime = 1.0 / dt;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const Index a = first + springs->a[i], b = first + springs->b[i];
    s.a[begin + i] = static_cast<std::uint32_t>(a);
    s.b[begin + i] = static_cast<std::uint32_t>(b);
    const double wa = s.mobility[static_cast<std::size_t>(a)], wb = s.mobility[static_cast<std::size_t>(b)];
    const double phase = (wa + wb) * dt * dt;
    const Vector3d d = p.position.col(springs->b[i]) - p.position.col(springs->a[i]);
    const double length = d.norm();
    const double inverse = length > 0.0 && wa + wb > 0.0 ? 1.0 / length : 0.0;
    const Vector3d n = inverse * d, u = dt * inverse * (s.start.col(b) - s.start.col(a));
    const double stretch = length - springs->restLength[i], later = stretch + length * n.dot(u);
    const SpringSlope slope = slopeOf(springs, i, stretch, phase);
    // a spring that becomes taut or stiff within the substep must be as stiff as it will be
    const double stiffness = std::max(slope.along, slopeOf(springs, i, later, phase).along);
    if (!(inverse > 0.0 && stiffness > 0.0)) {
      addSpring(s, begin + i, Vector3d::Zero(), 0.0, 0.0, 0.0, 0.0);
      continue;
    }
    const double damping = slope.along > 0.0 ? softened(springs->damping[i] * perTime, phase) : 0.0;
    const double along = dt * dt * (stiffness + damping);
    const double across = std::max(dt * dt * std::max(0.0, slope.force * inverse),
                                   along * std::min(1.0, u.squaredNorm() / (kLargeTurn * kLargeTurn)));
    const bool outer = (wa > 0.0) != (wb > 0.0);
    addSpring(s, begin + i, n, outer ? 0.0 : along, outer ? 0.0 : across, outer ? 0.0 : dt * slope.force,
              outer ? 0.0 : inverse);
    if (!outer) continue;
    const bool heldA = wb > 0.0;
    addHeldSpring(s, heldA ? b : a, heldA ? a : b, heldA ? n : Vector3d(-n), along, across, dt * slope.force);
  }
}

// --- volumes, tetrahedra, links ---------------------------------------------------------------------------

void addVolumes(ImplicitSystem& s, SolverBody& body, Index first, double dt) {
  PointState& p = *body.points;
  p.allocateForces();
  p.force.setZero();
  if (body.volumes) addVolumeForces(*body.volumes, p);
  if (body.tetrahedra) addTetrahedronForces(*body.tetrahedra, p);
  s.force.middleCols(first, p.force.cols()) += dt * p.force;
  for (std::size_t c = 0; body.volumes && c < (*body.volumes)->restVolume.size(); ++c) {
    const VolumeSlope slope = volumeSlope(*body.volumes, c, p, s.gradient);
    if (!(slope.stiffness > 0.0)) continue;
    beginRow(s);
    for (Index i = 0; i < p.position.cols(); ++i)
      if (!s.gradient.col(i).isZero(0.0))
        addTerm(s, first + i, dt * std::sqrt(slope.stiffness) * s.gradient.col(i));
  }
  for (std::size_t t = 0; body.tetrahedra && t < (*body.tetrahedra)->tetrahedra.size(); ++t) {
    const TetrahedronSlope slope = tetrahedronSlope(*body.tetrahedra, t, p.position);
    if (!(slope.stiffness > 0.0)) continue;
    beginRow(s);
    for (Index k = 0; k < 4; ++k)
      addTerm(s, first + Index{(*body.tetrahedra)->tetrahedra[t][static_cast<std::size_t>(k)]},
              dt * std::sqrt(slope.stiffness) * slope.gradient.col(k));
  }
}

/// Adds a row that resists the speed of end b relative to end a along `n`, with `weight` (kg), and an impulse
/// (N s) that pulls the ends together.
void addLinkRow(ImplicitSystem& s, const Part& part, const LinkSpring& link, const Vector3d& n, double weight,
                double impulse) {
  if (!(weight > 0.0)) return;
  const double root = std::sqrt(weight);
  beginRow(s, -impulse / root, true);
  for (const LinkEnd* end : {&link.a, &link.b}) {
    const Vector3d share = (end == &link.a ? -root : root) * n;
    if (end->kind == LinkEnd::Kind::Point) addTerm(s, columnOfPoint(s, part, end->body, end->point), share);
    if (end->kind != LinkEnd::Kind::Rigid) continue;
    const Index column = columnOfRigid(s, end->body);
    addTerm(s, column, share);
    const RigidState& rigid = part.group.links.rigids[end->body];
    addTerm(s, column + 1, Vector3d(rigid.rotation * end->pivot).cross(share));
  }
}

/// 1/kg: the velocity of the end along `n` per impulse along it.
double mobilityAlong(const LinkedBodies& links, const LinkEnd& end, const Vector3d& n) {
  if (end.kind == LinkEnd::Kind::World) return 0.0;
  if (end.kind == LinkEnd::Kind::Point)
    return n.dot(links.points[end.body]->inverseMass.col(end.point).cwiseProduct(n));
  const RigidState& rigid = links.rigids[end.body];
  return n.dot(rigid.mobilityAt(rigid.rotation * end.pivot) * n);
}

void addLinks(ImplicitSystem& s, const Part& part, double dt) {
  for (LinkSpring& link : part.group.links.springs) {
    const LinkedBodies& links = part.group.links;
    const Vector3d d = endPosition(links, link.b) - endPosition(links, link.a);
    const double length = d.norm(), stretch = length - link.restLength;
    const double full = stretch > 0.0 ? link.extensionStiffness : link.compressionStiffness;
    link.direction.setZero();
    link.force = 0.0;
    if (!(length > 0.0) || full == 0.0) continue;
    const Vector3d n = d / length, tangent = n.unitOrthogonal();
    const double w = mobilityAlong(links, link.a, n) + mobilityAlong(links, link.b, n);
    const double phase = w * dt * dt, k = softened(full, phase),
                 across = dt * dt * std::max(0.0, k * stretch / length);
    link.direction = n;
    link.force = k * stretch;
    addLinkRow(s, part, link, n, dt * dt * (k + softened(link.damping / dt, phase)), dt * link.force);
    addLinkRow(s, part, link, tangent, across, 0.0);
    addLinkRow(s, part, link, n.cross(tangent), across, 0.0);
  }
}

void addRigid(ImplicitSystem& s, const RigidState& rigid, Index column) {
  setMass(s, column, rigid.inverseMass);
  setMass(s, column + 1, Vector3d::Zero());
  for (int k = 0; k < 3; ++k)
    if (rigid.inverseInertia.row(k).cwiseAbs().maxCoeff() > 0.0) s.free(k, column + 1) = 1.0f;
  const Matrix3d inertia = pseudoInverse(rigid.inverseInertia);
  s.block.col(column + 1) << inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1), inertia(1, 2),
      inertia(2, 0);
  s.inertia.push_back(inertia.cast<float>());
}

}  // namespace

void assembleParts(ImplicitSystem& s, const Part& part, double dt) {
  resize(s, s.start.cols());
  forEachBody(part, [&](SolverBody& body, Index first) {
    for (Index i = 0; i < body.points->position.cols(); ++i)
      setMass(s, first + i, body.points->inverseMass.col(i));
    addSprings(s, body, first, dt);
    addVolumes(s, body, first, dt);
  });
  if (part.together) {
    for (std::uint32_t r = 0; r < part.group.links.rigids.size(); ++r)
      addRigid(s, part.group.links.rigids[r], columnOfRigid(s, r));
    addLinks(s, part, dt);
  }
}

// --- the iterations ---------------------------------------------------------------------------------------

Matrix3d freeInverse(const ImplicitSystem& s, Index column) {
  const double* b = s.block.col(column).data();
  const float* free = s.free.col(column).data();
  double m[3] = {b[0], b[1], b[2]}, xy = b[3], yz = b[4], zx = b[5];
  if (free[0] == 0.0f) m[0] = 1.0, xy = zx = 0.0;
  if (free[1] == 0.0f) m[1] = 1.0, xy = yz = 0.0;
  if (free[2] == 0.0f) m[2] = 1.0, yz = zx = 0.0;
  const double cxx = m[1] * m[2] - yz * yz, cxy = zx * yz - xy * m[2], czx = xy * yz - zx * m[1];
  const double scale = 1.0 / (m[0] * cxx + xy * cxy + zx * czx);
  Matrix3d inverse;
  inverse << cxx, cxy, czx, cxy, m[0] * m[2] - zx * zx, xy * zx - m[0] * yz, czx, xy * zx - m[0] * yz,
      m[0] * m[1] - xy * xy;
  inverse *= scale;
  for (int k = 0; k < 3; ++k)
    if (free[k] == 0.0f) inverse(k, k) = 0.0;
  return inverse;
}

namespace {

/// Iterations end where the energy of the remaining error is this share of that of the first.
constexpr double kImplicitConverged = 1e-8;

/// Replaces the diagonal blocks by their inverses, without the rows and columns of held axes.
void invertBlocks(ImplicitSystem& s) {
  for (std::size_t i = 0; i < s.inverse.size(); ++i) {
    s.inverse[i].setZero();
    s.inverse[i].topLeftCorner<3, 3>() = freeInverse(s, static_cast<Index>(i)).cast<float>();
  }
}

/// Sets s.product to the matrix times s.direction.
void multiply(ImplicitSystem& s) {
  s.product = s.mass.cwiseProduct(s.direction);
  for (std::size_t i = 0; i < s.a.size(); ++i) {
    const Vector4f d = s.direction.col(s.b[i]) - s.direction.col(s.a[i]);
    const Vector4f q = s.along[i];
    const Vector4f sum = s.across[i] * d + q.dot(d) * q;
    s.product.col(s.a[i]) -= sum;
    s.product.col(s.b[i]) += sum;
  }
  for (const StiffRow& row : s.rows) {
    float speed = 0.0f;
    for (std::size_t t = row.firstTerm; t < row.endTerm; ++t)
      speed += s.terms[t].padded.dot(s.direction.col(s.terms[t].column));
    for (std::size_t t = row.firstTerm; t < row.endTerm; ++t)
      s.product.col(s.terms[t].column) += speed * s.terms[t].padded;
  }
  const Index rigids = s.direction.cols() - 2 * static_cast<Index>(s.inertia.size());
  for (std::size_t r = 0; r < s.inertia.size(); ++r) {
    const Index column = rigids + 2 * static_cast<Index>(r) + 1;
    s.product.col(column).head<3>() += s.inertia[r] * s.direction.col(column).head<3>();
  }
  s.product = s.product.cwiseProduct(s.free);
}

double dotOf(const PaddedPoints& a, const PaddedPoints& b) {
  double sum = 0.0;
  for (Index i = 0; i < a.cols(); ++i) sum += static_cast<double>(a.col(i).dot(b.col(i)));
  return sum;
}

/// Sets s.preconditioned from s.residual; returns their product.
double precondition(ImplicitSystem& s) {
  double sum = 0.0;
  for (Index i = 0; i < s.residual.cols(); ++i) {
    const Vector4f r = s.residual.col(i), z = s.inverse[static_cast<std::size_t>(i)] * r;
    s.preconditioned.col(i) = z;
    sum += static_cast<double>(r.dot(z));
  }
  return sum;
}

/// Sets the residual: M (v* - u), and the impulses of springs and contacts if the velocities stay u =
/// s.start.
void setResidual(ImplicitSystem& s) {
  s.total = s.force + s.push;
  for (const StiffRow& row : s.rows) apply(s, row, impulseOf(s, row, s.start), s.total);
  for (Index i = 0; i < s.start.cols(); ++i) {
    const Vector4f change = padded(s.kicked.col(i) - s.start.col(i));
    Vector4f r = padded(s.total.col(i)) + s.mass.col(i).cwiseProduct(change);
    const Index rotation = i - s.firstColumn.back();
    if (rotation >= 0 && rotation % 2 == 1)
      r.head<3>() += s.inertia[static_cast<std::size_t>(rotation / 2)] * change.head<3>();
    s.residual.col(i) = r.cwiseProduct(s.free.col(i));
  }
}

}  // namespace

void solveSystem(ImplicitSystem& s, int iterations) {
  invertBlocks(s);
  setResidual(s);
  s.step.setZero();
  double squared = precondition(s);
  const double first = squared;
  s.direction = s.preconditioned;
  for (int i = 0; i < iterations && squared > kImplicitConverged * first; ++i) {
    multiply(s);
    const auto length = static_cast<float>(squared / dotOf(s.direction, s.product));
    s.step += length * s.direction;
    s.residual -= length * s.product;
    const double next = precondition(s);
    s.direction = s.preconditioned + static_cast<float>(next / squared) * s.direction;
    squared = next;
  }
}

bool stiffenTurning(ImplicitSystem& s, double dt) {
  bool any = false;
  for (std::size_t i = 0; i < s.a.size(); ++i) {
    const Index a = s.a[i], b = s.b[i];
    const Vector3d u = dt * double(s.inverseLength[i]) *
                       (s.start.col(b) - s.start.col(a) + unpadded(s.step.col(b) - s.step.col(a)));
    const double turn = u.squaredNorm() / (kLargeTurn * kLargeTurn);
    if (!(turn > 1.0)) continue;
    const Vector3d q = unpadded(s.along[i]);
    const double change = q.squaredNorm();  // from the stiffness across to that along
    if (!(change > double(s.across[i]))) continue;
    any = true;
    const Vector3d d = s.start.col(b) - s.start.col(a), sideways = change * d - q.dot(d) * q;
    s.force.col(a) += sideways;
    s.force.col(b) -= sideways;
    for (const Index end : {a, b}) {
      addBlock(s, end, Vector3d::Zero(), change);
      removeBlock(s, end, q);
    }
    s.across[i] += static_cast<float>(change);
    s.along[i].setZero();
  }
  return any;
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

// Linearly implicit Euler substeps: stable at any stiffness, with a cost that does not depend on it.

#include "solver/point_state.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace limber {

struct SolverIsland;

/// Vectors of single-precision numbers, one column per point mass. The fourth number is 0: it fills the
/// processor's registers.
using PaddedPoints = Eigen::Matrix<float, 4, Eigen::Dynamic>;

/// A row s of the stiffness matrix: it adds s s^T to the matrix, and  s constant  to the right-hand side. Its
/// impulse (N s along s) is  constant - s . velocities.  `terms` are the numbers of s that are not 0.
struct StiffRow {
  std::size_t firstTerm = 0, endTerm = 0;
  double constant = 0.0;
  bool external = false;  ///< between bodies: its impulse changes their momenta
};
struct StiffRowTerm {
  std::uint32_t column = 0;
  Eigen::Vector3d share = Eigen::Vector3d::Zero();
  Eigen::Vector4f padded = Eigen::Vector4f::Zero();
};

struct PlaneContact;
struct ContactConstraint;
struct LinkAnchor;

/// A contact or anchor that had an impulse in the last substep, in three directions. The first is a contact's
/// normal.
struct HeldRows {
  PlaneContact* plane = nullptr;      ///< one of these three
  ContactConstraint* pair = nullptr;  ///< of two bodies
  LinkAnchor* anchor = nullptr;
  double friction = 0.0;
  bool sticks = true;                                ///< has rows across the normal, too; otherwise it slides
  std::size_t firstRow = 0;                          ///< one for each direction with a root
  std::size_t firstTerm = 0, endTerm = 0;            ///< of heldTerms
  Eigen::Vector3d root = Eigen::Vector3d::Zero();    ///< kg^1/2, 0: no row
  Eigen::Vector3d load = Eigen::Vector3d::Zero();    ///< N s, of the last substep
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< m/s
};
struct HeldTerm {
  std::uint32_t column = 0;
  Eigen::Matrix3d rows = Eigen::Matrix3d::Zero();  ///< change of the speeds per velocity of the column
};

/// Mass, centre and inverse inertia of a free body.
struct WholeBody {
  double mass = 0.0;  ///< 0: not free
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();  ///< of rigid motions
};

/// The memory of solveImplicitly(), kept from substep to substep. A column is a point mass, or the velocity
/// or angular velocity of a rigid body that link springs join.
struct ImplicitSystem {
  // Springs: they add q q^T + across (1 - n n^T) between their ends.
  std::vector<std::uint32_t> a, b;     ///< #springs, columns
  std::vector<Eigen::Vector4f> along;  ///< #springs, kg^1/2, q
  std::vector<float> across;           ///< #springs, kg
  std::vector<float> inverseLength;    ///< #springs, 1/m; 0: slack

  std::vector<StiffRow> rows;  ///< volumes, tetrahedra, links, contacts, anchors
  std::vector<StiffRowTerm> terms;
  std::vector<HeldRows> held;
  std::vector<HeldTerm> heldTerms;

  std::vector<Eigen::Matrix3f> inertia;  ///< #rigid bodies, kg m^2

  PaddedPoints mass, free;                         ///< kg per axis; 1 where the axis is free, else 0
  PaddedPoints residual, step;                     ///< N s; m/s
  PaddedPoints direction, product;                 ///< m/s; N s
  PaddedPoints preconditioned;                     ///< m/s
  std::vector<Eigen::Matrix4f> inverse;            ///< #columns, 1/kg: of the diagonal blocks
  Eigen::Matrix<double, 6, Eigen::Dynamic> block;  ///< #columns, kg, diagonal blocks: xx yy zz xy yz zx
  std::vector<double> mobility;                    ///< #columns, 1/kg, largest inverse mass of a point
  Points start, kicked;                            ///< 3 x #columns, m/s: where the iterations begin; v*
  Points force, push, total;              ///< 3 x #columns, N s: on the points; between bodies; scratch
  std::vector<Eigen::Index> firstColumn;  ///< #bodies + 1; the rigid bodies begin at the last
  std::vector<WholeBody> whole;           ///< #bodies
  std::vector<std::uint32_t> bodyOf;      ///< #columns, index of the body
  std::vector<Eigen::Vector3d> loads;     ///< #contacts + #anchors, N s, between two solves
  Points gradient;                        ///< 3 x #points, scratch
  std::vector<Points> before;             ///< of each body, or of all that link springs join, m/s
};

/// Limits the volume terms to what substeps of dt seconds can follow.
void prepareImplicit(SolverIsland& group, double dt);

/// Stores the velocities of all bodies, before the kick of a substep.
void storeVelocities(ImplicitSystem& system, SolverIsland& group);

/// Replaces the velocities v* of all bodies of the island after a kick of dt seconds by gravity and other
/// forces, but not by springs and contacts, by the solution v' of
///
///     (M + dt D + dt^2 K) v' = M v* + dt f(x) + J,
///
/// a linearised step of backward Euler (Baraff, Witkin 1998, equation 16) with the springs' forces f,
/// stiffness K and damping D at the present positions. K leaves out the part of compressed springs that would
/// make it indefinite (Choi, Ko 2002, section 4). J are the impulses of contacts and anchors that had one in
/// the last substep: with the speed u at a contact, its wanted speed t and its last impulse l,
/// J = l - w (u - t), w being the mass that the springs put behind it. So J converges to the impulse that
/// keeps the speed (an augmented Lagrangian), and a body at rest has nothing left to solve.
///
/// It is solved by at most kImplicitIterations conjugate gradient steps in single precision from the stored
/// velocities, with the inverse 3 x 3 blocks of the diagonal as preconditioner. So the cost does not depend
/// on the stiffness. Before and after the iterations each free body as a whole gets the momenta that v* and J
/// give it: they are exact however few the iterations.
///
/// Springs whose phase in a substep would be above kLargestImplicitPhaseSquared are softened to that. They
/// stretch by less than a hundredth of a percent under the body's own weight. `time` is the time (s) since
/// the start of the tick.
void solveImplicitly(ImplicitSystem& system, SolverIsland& group, double time, double dt);

/// Before the contacts are solved with the masses alone: takes the impulses of solveImplicitly() out of
/// them, so that the solve only adds to these. putBackLoads() adds them again.
void takeOutLoads(ImplicitSystem& system, SolverIsland& group);
void putBackLoads(ImplicitSystem& system, SolverIsland& group);

}  // namespace limber

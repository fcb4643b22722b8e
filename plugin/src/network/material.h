// SPDX-License-Identifier: Zlib

// Declares the measurement of a network's elastic moduli, the responses of a homogeneous solid by finite
// elements, and the spring constants that give a network the elasticity of a material.

#pragma once

#include "mesh/linear_algebra.h"
#include "network/tetrahedra.h"

#include <limber/network_builder.h>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace limber {

// --- elements ----------------------------------------------------------------------------------------------

/// Shear modulus of a solid of Young's modulus 1 and Poisson's ratio 1/4. Its other constant of Lame is the
/// same.
constexpr double kShearModulus = 0.4;

/// Stiffness and mass, the lower triangles, 3 #points x 3 #points.
struct SolidMatrices {
  Eigen::SparseMatrix<double> stiffness;  ///< m, for a Young's modulus of 1 Pa and a Poisson ratio of 1/4
  Eigen::SparseMatrix<double> mass;       ///< m^3, for a density of 1 kg/m^3; consistent, not lumped
};

/// Linear elements. They are exact for uniform strains. They are too stiff in bending and torsion.
SolidMatrices linearElements(const TetrahedralMesh& mesh);

/// Tetrahedra with a node at each corner and in the middle of each edge. The order of a tetrahedron's nodes:
/// corners 0 1 2 3, edges 01 02 03 12 13 23.
struct QuadraticMesh {
  std::vector<Eigen::Vector3d> nodes;  ///< m; the points of the mesh, then the middles of the edges
  std::vector<std::array<std::uint32_t, 10>> tetrahedra;
};
QuadraticMesh withMiddles(const TetrahedralMesh& mesh);

/// Quadratic elements (10 nodes, straight edges; O. C. Zienkiewicz, R. L. Taylor, "The Finite Element
/// Method"). They are exact for displacements of second degree, such as pure bending.
SolidMatrices quadraticElements(const QuadraticMesh& mesh);

// --- vibrations --------------------------------------------------------------------------------------------

/// Vibrations of a free homogeneous solid with a Young's modulus of 1 Pa, a Poisson ratio of 1/4 and a
/// density of 1 kg/m^3, without the rigid motions. The slowest come first.
struct SolidModes {
  QuadraticMesh mesh;
  Eigen::VectorXd squaredFrequencies;  ///< #modes, 1/s^2, of the angular frequencies
  Eigen::MatrixXd displacements;       ///< 3 #nodes x #modes, of modal mass 1
};

/// Computes about `count` modes with quadratic elements by subspace iteration (K.-J. Bathe, "Finite Element
/// Procedures", 11.6) from displacements of first to third degree. A small mesh has fewer modes. Takes 1 s
/// for 400 points.
SolidModes slowestModes(const TetrahedralMesh& mesh, Eigen::Index count);

/// Returns the displacements of the modes, 3 #positions x #modes, at positions in the body or near it.
Eigen::MatrixXd displacementsAt(const SolidModes& modes, const std::vector<Eigen::Vector3d>& positions);

// --- responses to loads ------------------------------------------------------------------------------------

/// Self-equilibrated loads on the points of a mesh, and the compliance of the solid under them. A network
/// whose stiffness matrix is K should have  loads^T K^-1 loads = compliance.  The solid has a Young's modulus
/// of 1 Pa and a Poisson ratio of 1/4. The loads are scaled so that the compliances are near the unit matrix.
struct SolidResponses {
  Eigen::MatrixXd loads;       ///< 3 #points x #loads
  Eigen::MatrixXd compliance;  ///< #loads x #loads
  Eigen::MatrixXd weights;     ///< #loads x #loads: importance of an entry of the compliance; 0: not known
};

/// Returns the responses of the inside of the mesh to three groups of loads:
/// - the 6 uniform stresses;
/// - the 15 stresses that vary linearly and are in equilibrium without forces inside, such as those of
///   bending. Their displacements are of second degree. For these two groups the compliance of a solid of any
///   shape is known exactly: the integral of  s : C^-1 : s.
/// - the inertial forces of the slowest free vibrations, such as bending and torsion of the body and of its
///   limbs. Quadratic elements give their compliance. Above about 600 points, they are those of a coarser
///   filling; the compliance is that of linear elements on this mesh, plus what linear elements miss on the
///   coarser mesh times the squared ratio of the spacings (L. F. Richardson 1911). A body that cannot be
///   filled more coarsely goes without this group.
SolidResponses solidResponses(const TetrahedralMesh& mesh);

/// Smallest and largest constant (N/m) of each spring; above 0.
struct SpringLimits {
  std::vector<double> smallest, largest;
};

/// Changes the stiffnessScale of each spring, which is its constant (N/m) here, so that the network responds
/// to the loads like the solid. Minimises
///     sum over entries of the compliance |weight (measured - wanted)|^2
///     + kChangeWeight sum over springs share log(k / k0)^2
/// with the present constants k0 and the springs' shares of the sum of k L^2. Uses the method of Levenberg
/// and Marquardt for log k within the limits; each step is solved by conjugate gradients. The derivative of
/// the compliance of loads i, j is  -e_i e_j  for the constant of a spring with the extensions e. `goOn` is
/// called with the progress, 0 to 1; after it has returned false, no further steps are made. Returns the
/// largest stiffness that is left, relative to the wanted one, of all loads.
double fitResponses(SpringNetwork& network, const SolidResponses& wanted, const SpringLimits& limits,
                    const std::function<bool(double)>& goOn = {});

// --- networks with the elasticity of a material ------------------------------------------------------------

/// Error of builders that have no early result: half of its springs do not make a material.
constexpr char kEnded[] = "ended early: progress returned false";

/// Springs and volume term of a body.
struct ElasticBody {
  const SpringNetwork& network;
  double stiffness = 1.0;      ///< N/m of a spring of stiffnessScale 1
  double volumeModulus = 0.0;  ///< Pa, of each tetrahedron or, without tetrahedra, of the whole inside
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
};

/// Computes small displacements of a body under forces, about its rest shape.
class LinearResponse {
 public:
  explicit LinearResponse(const ElasticBody& body);

  /// Returns the displacements, 3 #points x #loads, m, for forces (N) in the same order: x, y, z of each
  /// point. For each load, the sum and the torque of the forces on every connected part of the body must be
  /// zero.
  Eigen::MatrixXd displacements(const Eigen::MatrixXd& forces) const;

  const std::vector<Eigen::Vector3d>& points() const { return points_; }  ///< m, at the body's scale

 private:
  std::vector<Eigen::Vector3d> points_;
  SparseFactor factor_;
  Eigen::MatrixXd volumeGradient_;  ///< 3 #points x 1, m^2, times the root of modulus over volume; or empty
  Eigen::MatrixXd volumeResponse_;  ///< displacements under volumeGradient_ as force, without the volume term
};

/// The bending of a body by a stress along one principal axis of the solid that grows across another. It is
/// in equilibrium without forces inside, so this is Young's modulus for a solid of any shape.
struct BendingModulus {
  double modulus = 0.0;      ///< Pa
  double slenderness = 0.0;  ///< length of the body along the one axis over that along the other
};

/// Response of a body to small uniform stresses. For a homogeneous isotropic solid of any shape these are the
/// constants of its material, in all directions.
struct ElasticModuli {
  std::vector<double> youngsModuli;       ///< Pa, for each of 40 directions
  double youngsModulus = 0.0;             ///< Pa, their mean
  double isotropy = 0.0;                  ///< the smallest over the largest
  double poissonRatio = 0.0;              ///< mean over the directions
  double bulkModulus = 0.0;               ///< Pa
  std::array<BendingModulus, 6> bending;  ///< of all pairs of axes
};

/// Applies uniform stresses to the surface, along and across the axes, and solves for the linear
/// displacements about the rest shape. The mean strain is that of the surface, (1/V) sum over triangles of
/// sym(u A^T), with the mean displacement u of a triangle's corners and its area vector A. A mirrored body
/// has the moduli of its mirror image. The network must have a closed surface. A body with mechanisms has
/// moduli near 0. Takes seconds for 5 000 points.
ElasticModuli measureModuli(const ElasticBody& body);

/// A totally symmetric tensor of fourth degree, such as the elasticity of springs
/// (Cauchy-Born: C = sum k L^2 n n n n / V). Holds the 15 entries xxxx yyyy zzzz xxxy xxxz yyyx yyyz zzzx
/// zzzy xxyy yyzz zzxx xxyz yyzx zzxy, each times the square root of its number of occurrences. The dot
/// product of two such vectors is then the product of the tensors.
using FourthDegree = Eigen::Matrix<double, 15, 1>;

/// Returns n n n n, of length 1 for a unit vector.
FourthDegree fourthPower(const Eigen::Vector3d& n);

/// Returns the elasticity of the isotropic solid of springs with E = 1 and Poisson ratio 1/4:
/// lambda = mu = 2/5, C_xxxx = 6/5, C_xxyy = 2/5.
FourthDegree isotropicElasticity();

/// Smallest share of the volume, relative to the mean, with which a point counts where the springs' growth is
/// limited for the time step: lighter points get more mass, see materialMasses().
constexpr double kMinMassShare = 0.2;

/// Makes springs of the edges of the tetrahedra, with constants that give the network the elasticity of a
/// material. The network must have points, tetrahedra and surface. Sets `springs`, with stiffness scales of
/// mean 1, and `stiffnessPerModulus`, so that the measured Young's modulus (measureModuli()) is the requested
/// one. Edges of the surface are Structural. Those inside are Brace, because they support the surface from
/// within.
///
/// The constants begin with those of A. Van Gelder, "Approximate simulation of elastic membranes by
/// triangulated spring meshes", 1998,  k = E sum V / L^2  over the tetrahedra around an edge. On a
/// body-centred lattice that body is stiffer along the space diagonals than along the axes by 1.27. So they
/// are changed, as little as possible, towards an isotropic elasticity around each point (Cauchy-Born).
///
/// Springs in the surface lie farther out than the material that they stand for. A bar with two cells across
/// is then too stiff by 1.3 in bending and 1.5 in torsion. At the surface, where all springs of a point lie
/// on one side, the body is too soft against uniform stress, by up to a quarter. So the constants are fitted,
/// again with as little change as possible, to what is known of the solid: its response to uniform stresses,
/// to linear ones and to its slowest vibrations (solidResponses(), fitResponses()). They stay between 0.2
/// and 1.8 times Van Gelder's. Those around the points that limit the time step grow to at most 1.15 times. A
/// body that is still too stiff in one of the responses by a fifth, as a bar of two cells in torsion, is
/// fitted once more with limits of 4 and 2 times: it needs 1.3 to 1.5 times as many substeps.
///
/// Returns the calibration: the Young's modulus of the fitted springs for a requested 1 Pa, before all
/// constants were divided by it. It is near 1. Networks of thin plates are too uneven to have one modulus:
/// they keep the fitted constants, and the calibration is 1. `goOn` is called with the progress, 0 to 1;
/// after it has returned false, the fit goes no further.
///
/// `minGrowth`: smallest constant as a fraction of Van Gelder's; a weaker spring would have no effect. With
/// larger ones thin limbs return from more of the large deformations, and torsion is less exact.
double setMaterialSprings(SpringNetwork& network, const std::function<bool(double)>& goOn = {},
                          double minGrowth = 0.2);

/// Gives the springs of a sheet, edges of its triangles and braces, constants that make it as stiff in all
/// its directions as its triangles allow, with stiffness scales whose mean over the edges is about 1. The
/// constants begin with Van Gelder's, k = E h A / L^2 with the sum A of the areas at an edge and the
/// thickness h, and for braces `bending` times twice the constant of the two edges in a row that they span.
/// They are changed as those of tetrahedra are, and limited at slivers, which would shorten the time step.
/// Poisson's ratio is 1/3.
void setSheetSprings(SpringNetwork& network, double bending);

/// Returns the mass fractions of the points of a network with tetrahedra and springs, sum 1. A quarter of
/// each tetrahedron's mass belongs to each of its corners, except that points that oscillate fastest against
/// their neighbours, which limit the time step, are heavier, by 7 % of the body's mass in all. This comes
/// from the other points. Centre of mass and inertia are those of the solid as far as no point has more
/// than 1.3 times its quarters. The quarters alone have too much inertia, by up to a tenth: so the slowest
/// vibrations of cubes, tori and bars are as true as with them; those of thin limbs are less so.
std::vector<double> materialMasses(const SpringNetwork& network);

/// Returns the network of a filling: springs by setMaterialSprings(), masses by materialMasses().
SpringNetwork materialNetwork(TetrahedralMesh filling, const std::function<bool(double)>& goOn = {},
                              double minGrowth = 0.2);

}  // namespace limber

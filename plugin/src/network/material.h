// SPDX-License-Identifier: Zlib
// Declares the moduli of elasticity that a network shows, and the spring constants that make it a material.
#pragma once

#include <limber/spring_network.h>

#include <Eigen/Core>

#include <array>
#include <functional>
#include <vector>

namespace limber {

/// What the springs and the volume term of a body are made of.
struct ElasticBody {
  const SpringNetwork& network;
  double stiffness = 1.0;      ///< N/m of a spring of stiffnessScale 1
  double volumeModulus = 0.0;  ///< Pa, of each tetrahedron, or without any of the whole inside of the surface
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
};

/// How a body answers to small uniform stresses, as a piece of material: for a homogeneous isotropic solid of
/// any shape these are the material's own constants, in all directions.
struct ElasticModuli {
  std::vector<double> youngsModuli;  ///< Pa, for each of 40 directions
  double youngsModulus = 0.0;        ///< Pa, their mean
  double isotropy = 0.0;             ///< the smallest over the largest
  double poissonRatio = 0.0;         ///< mean over the directions
  double bulkModulus = 0.0;          ///< Pa
  /// Pa, Voigt: xx yy zz yz zx xy, shear strains doubled
  Eigen::Matrix<double, 6, 6> elasticity = Eigen::Matrix<double, 6, 6>::Zero();
};

/// Pulls at the surface as a uniform stress would, along and across the axes, and solves for the linear
/// displacements about the rest shape. The mean strain is that of the surface,
/// (1/V) sum over triangles of sym(u A^T), with the mean displacement u of its corners and its area vector A.
/// A mirrored body has those of its mirror image. For networks with a closed surface; a body with mechanisms
/// has moduli near 0. Takes seconds for 5 000 points.
ElasticModuli measureModuli(const ElasticBody& body);

/// N/m: the force that draws apart two parts of the surface, those within `reach` (m) of two places, over
/// the change of their distance: how stiff an L or a horseshoe is against being opened. The force is spread
/// evenly over the surface there, along the line between the two parts' middles. 0 if either part is empty.
double openingStiffness(const ElasticBody& body, const Eigen::Vector3d& placeA, const Eigen::Vector3d& placeB,
                        double reach);

/// Pa: the Young's moduli that a body shows when bent, for the six stresses  s_aa = x_b - centre_b  of 1 Pa/m
/// along each axis a, varying along each other axis b. Such a stress is in equilibrium without forces inside
/// and does the work  1/E integral of (x_b - centre_b)^2  on a homogeneous isotropic solid of any shape, so
/// that all six are its Young's modulus. Networks are calibrated by uniform stresses; how far their answers
/// to these are off is what discretising leaves. The order is xy xz yz yx zx zy for ab. For networks with a
/// closed surface.
std::array<double, 6> measureBendingModuli(const ElasticBody& body);

/// A totally symmetric tensor of fourth degree, as the elasticity of springs is (Cauchy-Born:
/// C = sum k L^2 n n n n / V). Its 15 entries xxxx yyyy zzzz xxxy xxxz yyyx yyyz zzzx zzzy xxyy yyzz zzxx
/// xxyz yyzx zzxy, each times the root of how often it occurs, so that the product of two such vectors is the
/// tensors'.
using FourthDegree = Eigen::Matrix<double, 15, 1>;

/// n n n n, of length 1 for a unit vector.
FourthDegree fourthPower(const Eigen::Vector3d& n);

/// Of the isotropic solid of springs with E = 1 and Poisson ratio 1/4: lambda = mu = 2/5, C_xxxx = 6/5,
/// C_xxyy = 2/5.
FourthDegree isotropicElasticity();

/// The totally symmetric part of an elasticity in Voigt's notation (xx yy zz yz zx xy, shear strains
/// doubled).
FourthDegree symmetricPart(const Eigen::Matrix<double, 6, 6>& elasticity);

/// The edges of the tetrahedra as springs that together are a material, for a network that has its points,
/// tetrahedra and surface: sets `springs`, with stiffness scales of mean 1, and `stiffnessPerModulus`, so
/// that the measured Young's modulus (measureModuli()) is the one asked for. Edges of the surface are
/// Structural, those inside Brace, since they hold it up from within.
///
/// The constants stay near those of A. Van Gelder, "Approximate simulation of elastic membranes by
/// triangulated spring meshes", 1998,  k = E sum V / L^2  over the tetrahedra around an edge. On a
/// body-centred lattice those are stiffer along the space diagonals than along the axes by 1.27, and at the
/// surface, where all springs of a point lie on one side, they give way. So they are changed, as little as
/// will do, towards an elasticity around each point (Cauchy-Born) that makes the measured one of the whole
/// body isotropic.
///
/// Returns the calibration: the Young's modulus that the springs had, for 1 Pa asked, before all were divided
/// by it. Near 1, and for one shape nearly the same on all lattices. Once `goOn`, asked with the share done,
/// 0 to 1, says no, no further corrections are tried.
double setMaterialSprings(SpringNetwork& network, const std::function<bool(double)>& goOn = {});

}  // namespace limber

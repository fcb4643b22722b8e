// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <Eigen/Core>

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

}  // namespace limber

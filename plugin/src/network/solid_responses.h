// SPDX-License-Identifier: Zlib
// Declares what is known of the elasticity of a solid body: its response to several loads.
#pragma once

#include "network/tetrahedra.h"

#include <Eigen/Core>

namespace limber {

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

}  // namespace limber

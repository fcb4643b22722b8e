// SPDX-License-Identifier: Zlib
// Declares what is known of the elasticity of a solid body, its response to several loads, and the fit of
// spring constants to it.
#pragma once

#include "network/tetrahedra.h"

#include <limber/spring_network.h>

#include <Eigen/Core>

#include <functional>
#include <vector>

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

}  // namespace limber

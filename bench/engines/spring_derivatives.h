// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet_soft/body_start.h"

#include <vector>

namespace limber::bench {

/// Derivatives of the springs' energy with respect to the points' positions, ordered x y z of each point.
struct SpringDerivatives {
  Eigen::VectorXd gradient;  ///< N, 3 #points
  Eigen::MatrixXd hessian;   ///< N/m, 3 #points square
};

/// Written independently of Limber's code, so that no error is common to both. Springs whose ends coincide
/// have no direction and are left out.
SpringDerivatives springDerivatives(const std::vector<NetworkSpring>& springs, const BodyStart& start,
                                    const Eigen::Matrix3Xd& x);

}  // namespace limber::bench

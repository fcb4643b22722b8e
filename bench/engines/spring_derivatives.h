// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/body_start.h"

#include <vector>

namespace limber::bench {

/// Of the springs' energy by the points' positions, x y z of one point after the other.
struct SpringDerivatives {
  Eigen::VectorXd gradient;  ///< N, 3 #points
  Eigen::MatrixXd hessian;   ///< N/m, 3 #points square
};

/// Written without a line of Limber's, so that a common mistake cannot hide. Springs whose ends coincide have
/// no direction and are left out.
SpringDerivatives springDerivatives(const std::vector<NetworkSpring>& springs, const BodyStart& start,
                                    const Eigen::Matrix3Xd& x);

}  // namespace limber::bench

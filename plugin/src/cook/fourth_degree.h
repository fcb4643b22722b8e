// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

namespace limber {

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

}  // namespace limber

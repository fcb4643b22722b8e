// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <functional>

namespace limber {

/// The edges of the tetrahedra as springs that together are a material, for a network that has its points,
/// tetrahedra and surface: sets `springs`, with stiffness scales of mean 1, and `stiffnessPerModulus`, so
/// that the measured Young's modulus (elastic_moduli.h) is the one asked for. Edges of the surface are
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

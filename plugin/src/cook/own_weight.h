// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_builder.h>
#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <optional>

namespace limber {

/// The spring constant (N/m) below which a body collapses under its own weight. It is put down as it is
/// modelled, with its lowest point on a rough floor, gravity along -y and without speed, sinks until it
/// rests, and is then relieved of its weight. It carries itself if it stands half as high as it is and
/// springs back to its shape afterwards. To about 4 %; infinite for bodies that collapse however stiff they
/// are, 0 without gravity or springs.
///
/// In units of the size L, the mean mass m of a point and the stiffness k a body has nothing but the load
/// m g / (k L), and the smallest load that is too much is what is searched for. Of the settings counts what
/// shapes these units (total mass, scale, stiffness) and the volume modulus, whose ratio to the stiffness is
/// kept. `gravity` in m/s^2.
///
/// Pieces that no spring joins are put down one by one, and the one that needs most counts. Nothing when
/// `progress` (may be empty) asks for an early end, or when the body's fastest oscillation is so fast against
/// its slow ones that following it to rest would take too many steps.
std::optional<double> leastStiffness(const SpringNetwork& network, const SoftBodySettings& settings,
                                     double gravity, const Progress& progress = {});

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/image.h>
#include <limber/spring_network.h>

namespace limber::demo {

/// The network seen from the front and above, opened towards the viewer: of the surface its far walls, the
/// structural springs as thin lines, all others as rods coloured by kind, and a legend. Throws
/// std::runtime_error with the driver's reason.
render::Image drawNetwork(const SpringNetwork& network, int width, int height);

}  // namespace limber::demo

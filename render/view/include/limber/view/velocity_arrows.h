// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/legend.h>
#include <limber/render/overlay.h>
#include <limber/soft_body.h>

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {

struct VelocityArrows {
  double seconds = 0.05;     ///< An arrow is as long as the path of the point in this time, s.
  double fullSpeed = 5.0;    ///< Speed with the last colour of render::shareColour(), m/s.
  double leastSpeed = 0.05;  ///< Slower points have no arrow, m/s.
};

/// Returns the legend of the arrows' colours.
render::Legend speedLegend(const VelocityArrows& arrows);

/// Adds an arrow for each point mass: it starts at its position and is coloured by its speed.
void addVelocities(render::Overlay& overlay, const SoftBody& body, const VelocityArrows& arrows,
                   render::Vec3 eye);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view

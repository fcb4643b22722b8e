// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/legend.h>
#include <limber/render/overlay.h>
#include <limber/soft_body.h>

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {

struct VelocityArrows {
  double seconds = 0.05;     ///< An arrow is as long as the point goes in this time.
  double fullSpeed = 5.0;    ///< m/s that has the last colour of render::shareColour().
  double leastSpeed = 0.05;  ///< m/s; slower points have no arrow.
};

/// What the arrows' colours mean.
render::Legend speedLegend(const VelocityArrows& arrows);

/// An arrow for each point mass, from where it is now, coloured by its speed.
void addVelocities(render::Overlay& overlay, const SoftBody& body, const VelocityArrows& arrows,
                   render::Vec3 eye);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view

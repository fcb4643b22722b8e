// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/shape_desc.h>
#include <limber/soft_body.h>

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {

/// How a renderer sees a soft body: its surface, skinned if it has a skin, a tube for a rope, and its springs
/// but the bending ones as lines with their rest lengths. Its points are the point masses, in their order:
/// SoftBody::writePositions() writes them. Bodies with the same network, scale and point radius may share it.
/// Surfaces are two-sided, for an open one shows its inside, and so does a body that is turned inside out.
render::ShapeDesc shapeOf(const SoftBody& body, render::Shading shading);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view

// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/contact_candidates.h"

namespace limber {

/// Barycentric: a foot this far beside a triangle is in it.
constexpr double kBeside = 1e-4;

/// A vertex of a and a triangle of b, or (`ofB`) a vertex of b and a triangle of a. In front of it: a
/// candidate where it is above the triangle, now or when it lands. Behind one that is one-sided: goes to
/// `search.behind`.
void meetVertexTriangle(const SurfacePair& pair, bool ofB, std::uint32_t v, std::uint32_t triangle,
                        ContactSearch& search);

/// The candidate of a vertex that the triangle pushes along its unit `normal`.
void addVertexOnTriangle(const SurfacePair& pair, const VertexBehind& at, const Eigen::Vector3d& normal,
                         double time, ContactSearch& search);

}  // namespace limber

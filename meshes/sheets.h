// SPDX-License-Identifier: Zlib
#pragma once

#include "implicit_shapes.h"
#include "triangle_soup.h"

namespace shapes {

// Open sheets of triangles without thickness; all texture coordinates are 0.

/// A point for each u and v in 0..1. Outside is where the u direction turns to the v direction
/// counter-clockwise.
using Sheet = std::function<Eigen::Vector3d(double u, double v)>;

/// uCells x vCells quads. Triangles without area, at poles, are left out.
void addSheet(TriangleSoup& soup, int uCells, int vCells, const Sheet& sheet);

/// The sheet without the cells for which `isHole` is true.
void addSheet(TriangleSoup& soup, int uCells, int vCells, const Sheet& sheet,
              const std::function<bool(int uCell, int vCell)>& isHole);

/// A smooth line through the joints (Catmull and Rom); v from 0 to 1.
Joint onLine(const std::vector<Joint>& joints, double v);

/// A tube around the smooth line through the joints, which lies in a plane with the unit normal `side`:
/// v along the line, u around it from `side`. Its ends are open where the radius is not 0.
Sheet tube(const std::vector<Joint>& joints, const Eigen::Vector3d& side);

/// u around the ball, v from the lower to the upper pole.
Sheet ball(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii);

/// What lies in the region. Corners nearer to its edge than `snap`, metres along the surface, move onto the
/// edge; triangles across the edge are cut there.
TriangleSoup clip(const TriangleSoup& soup, const Field& surface, const Field& region, double snap);

void append(TriangleSoup& soup, const TriangleSoup& other);

/// The same triangles, wound the other way round.
TriangleSoup flipped(const TriangleSoup& soup);

/// The mirror image at x = 0, with the outside out.
TriangleSoup mirroredX(const TriangleSoup& soup);

/// Every position moved.
TriangleSoup moved(const TriangleSoup& soup,
                   const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& move);

}  // namespace shapes

// SPDX-License-Identifier: Zlib
#pragma once

#include "core/surface_contacts.h"

namespace limber {

/// Two surfaces whose contacts are looked for.
struct SurfacePair {
  const MovingSurface &a, &b;
  double margin;  ///< m
  bool self;      ///< both are the same

  double reach() const { return a.radius + b.radius; }
};

/// What the features in the care of two elements have to do with each other; adds to `search.candidates` and
/// `search.behind`.
void meetElements(const SurfacePair& pair, const SurfaceElement& a, const SurfaceElement& b,
                  ContactSearch& search);

/// A vertex of b, or of a, against a triangle of the other, pushed along the triangle's unit `normal`.
void addVertexOnTriangle(const SurfacePair& pair, const VertexBehind& at, const Eigen::Vector3d& normal,
                         double time, ContactSearch& search);

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/surface_contacts.h"

namespace limber {

/// Two surfaces whose contacts are looked for.
struct SurfacePair {
  const MovingSurface &a, &b;
  double margin;   ///< m
  bool self;       ///< both are the same
  double farther;  ///< m, by which the margin is larger than the one that tells what is close at rest

  double reach() const { return a.radius + b.radius; }
};

/// Of what touches: on a, then on b. Contacts of a lower rank are kept before those of a higher one.
enum ContactRank : std::uint8_t {
  kVertexTriangle,
  kTriangleVertex,
  kEdgeEdge,
  kVertexEdge,
  kEdgeVertex,
  kVertexVertex
};

/// Much thicker than the other and without triangles: a ball or a capsule.
bool isRound(const MovingSurface& surface, const MovingSurface& other);

SurfacePlace atVertex(std::uint32_t v);
SurfacePlace onEdge(const SurfaceTopology& t, std::uint32_t edge, const Eigen::Vector2d& weights);
SurfacePlace onTriangle(const SurfaceTopology& t, std::uint32_t triangle, const Eigen::Vector3d& weights);

/// ContactCandidate::vertex
std::uint64_t meetingVertex(const SurfacePair& pair, std::uint32_t v, bool ofB);

/// Completes a candidate that has places, normal, time, rank, scale and vertex; leaves it out if a surface
/// touches itself where it always does.
void addCandidate(const SurfacePair& pair, ContactCandidate& candidate, ContactSearch& search);

}  // namespace limber

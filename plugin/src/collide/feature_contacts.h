// SPDX-License-Identifier: Zlib
#pragma once

// What two surfaces' vertices, edges and triangles that are near each other have to do with each other: the
// candidates that surface_contacts.cpp reduces to contacts.

#include "collide/surface_contacts.h"
#include "solver/closest_points.h"

namespace limber {

// --- candidates --------------------------------------------------------------------------------------------

/// Two surfaces whose contacts are looked for.
struct SurfacePair {
  const MovingSurface &a, &b;
  double margin;   ///< m
  bool self;       ///< both are the same
  double farther;  ///< m, by which the margin is larger than the one that tells what is close at rest

  double radiusSum() const { return a.radius + b.radius; }
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

SurfacePoint atVertex(std::uint32_t v);
SurfacePoint onEdge(const SurfaceTopology& t, std::uint32_t edge, const Eigen::Vector2d& weights);
SurfacePoint onTriangle(const SurfaceTopology& t, std::uint32_t triangle, const Eigen::Vector3d& weights);

/// ContactCandidate::vertex
std::uint64_t contactVertex(const SurfacePair& pair, std::uint32_t v, bool ofB);

/// Completes a candidate that has places, normal, time, rank, scale and vertex; leaves it out if a surface
/// touches itself where it always does.
void addCandidate(const SurfacePair& pair, ContactCandidate& candidate, ContactSearch& search);

// --- nearest places on two features ------------------------------------------------------------------------

/// Nearest places on two features at one time.
template <int N, int M>
struct NearestPoints {
  Eigen::Matrix<double, N, 1> a;  ///< weights of the corners
  Eigen::Matrix<double, M, 1> b;
  Eigen::Vector3d away = Eigen::Vector3d::Zero();  ///< m, from b to a
  double distance = 0.0;                           ///< m
  double time = 0.0;                               ///< share of the tick
};

inline void nearestWeights(const MovingFeature<1>::Corners&, const MovingFeature<1>::Corners&,
                           NearestPoints<1, 1>& places) {
  places.a[0] = places.b[0] = 1.0;
}

inline void nearestWeights(const MovingFeature<1>::Corners& a, const MovingFeature<2>::Corners& b,
                           NearestPoints<1, 2>& places) {
  const double along = nearestOnSegment(b.col(0), b.col(1), a.col(0));
  places.a[0] = 1.0;
  places.b << 1.0 - along, along;
}

inline void nearestWeights(const MovingFeature<2>::Corners& a, const MovingFeature<2>::Corners& b,
                           NearestPoints<2, 2>& places) {
  const SegmentPair along = nearestOnSegments(a.col(0), a.col(1), b.col(0), b.col(1));
  places.a << 1.0 - along.a, along.a;
  places.b << 1.0 - along.b, along.b;
}

template <int N, int M>
NearestPoints<N, M> nearestPoints(const MovingFeature<N>& a, const MovingFeature<M>& b, double time) {
  const auto atA = a.at(time);
  const auto atB = b.at(time);
  NearestPoints<N, M> places;
  nearestWeights(atA, atB, places);
  places.away = atA * places.a - atB * places.b;
  places.distance = places.away.norm();
  places.time = time;
  return places;
}

// --- triangles ---------------------------------------------------------------------------------------------

/// A vertex of a and a triangle of b, or (`ofB`) a vertex of b and a triangle of a. In front of it: a
/// candidate where it is above the triangle, now or when it lands. Behind one that is one-sided: goes to
/// `search.behind`.
void collideVertexTriangle(const SurfacePair& pair, bool ofB, std::uint32_t v, std::uint32_t triangle,
                           ContactSearch& search);

/// Finds out which vertices of `search.behind` are inside the other surface, and adds a contact for each:
/// with the nearest triangle that the vertex faces.
void addInsideVertices(const SurfacePair& pair, ContactSearch& search);

/// Moves a foot that is slightly beside its triangle into it.
bool moveInto(Eigen::Vector3d& barycentric);

// --- edges and corners -------------------------------------------------------------------------------------

// Features of a and b that touch at edges and corners: a candidate is added where they are locally nearest,
// now or when they meet.

/// Vertices of a and b.
void collideVertices(const SurfacePair& pair, std::uint32_t va, std::uint32_t vb, ContactSearch& search);

/// A vertex of a and an edge of b, or (`ofB`) a vertex of b and an edge of a.
void collideVertexEdge(const SurfacePair& pair, bool ofB, std::uint32_t v, std::uint32_t edge,
                       ContactSearch& search);

/// Edges of a and b that cross. Those of solid bodies may have passed through each other by less than the
/// depth limit of their triangles.
void collideEdges(const SurfacePair& pair, std::uint32_t ea, std::uint32_t eb, ContactSearch& search);

}  // namespace limber

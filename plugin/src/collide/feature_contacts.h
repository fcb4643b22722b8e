// SPDX-License-Identifier: Zlib
#pragma once

// Tests pairs of vertices, edges and triangles of two surfaces for contact. The results are candidates, which
// surface_contacts.cpp reduces to contacts.

#include "collide/surface_contacts.h"

namespace limber {

/// Two surfaces that are tested for contact.
struct SurfacePair {
  const MovingSurface &a, &b;
  double margin;       ///< m, contacts have at most this gap or close it during the tick
  bool self;           ///< a and b are the same surface
  double extraMargin;  ///< m, part of `margin` that does not count in the test for closeness at rest
  Covered covered = {};

  double radiusSum() const { return a.radius + b.radius; }
};

/// The kinds of the two features: on a, then on b. Of equivalent contacts the one of lowest rank is kept.
enum ContactRank : std::uint8_t {
  kVertexTriangle,
  kTriangleVertex,
  kEdgeEdge,
  kVertexEdge,
  kEdgeVertex,
  kVertexVertex
};

/// Returns the key of a contact: the rank and the numbers of both features.
inline std::uint64_t keyOf(ContactRank rank, std::uint32_t onA, std::uint32_t onB) {
  return std::uint64_t{rank} << 60 | std::uint64_t{onA} << 30 | onB;
}

// --- nearest points of two features ------------------------------------------------------------------------

/// The nearest points of two features at one time.
template <int N, int M>
struct NearestPoints {
  Eigen::Matrix<double, N, 1> a;  ///< weights of the corners
  Eigen::Matrix<double, M, 1> b;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< m, from b to a
  double distance = 0.0;                             ///< m
  double time = 0.0;                                 ///< as a fraction of the tick
};

inline void nearestWeights(const MovingFeature<1>::Corners&, const MovingFeature<1>::Corners&,
                           NearestPoints<1, 1>& nearest) {
  nearest.a[0] = nearest.b[0] = 1.0;
}

inline void nearestWeights(const MovingFeature<1>::Corners& a, const MovingFeature<2>::Corners& b,
                           NearestPoints<1, 2>& nearest) {
  const double along = nearestOnSegment(b.col(0), b.col(1), a.col(0));
  nearest.a[0] = 1.0;
  nearest.b << 1.0 - along, along;
}

inline void nearestWeights(const MovingFeature<2>::Corners& a, const MovingFeature<2>::Corners& b,
                           NearestPoints<2, 2>& nearest) {
  const SegmentPair along = nearestOnSegments(a.col(0), a.col(1), b.col(0), b.col(1));
  nearest.a << 1.0 - along.a, along.a;
  nearest.b << 1.0 - along.b, along.b;
}

template <int N, int M>
NearestPoints<N, M> nearestPoints(const MovingFeature<N>& a, const MovingFeature<M>& b, double time) {
  const auto atA = a.at(time);
  const auto atB = b.at(time);
  NearestPoints<N, M> nearest;
  nearestWeights(atA, atB, nearest);
  nearest.offset = atA * nearest.a - atB * nearest.b;
  nearest.distance = nearest.offset.norm();
  nearest.time = time;
  return nearest;
}

// --- triangles ---------------------------------------------------------------------------------------------

/// Tests a vertex of a with a triangle of b, or (`ofB`) a vertex of b with a triangle of a. A vertex in front
/// becomes a candidate if its foot is in the triangle, now or at the time of impact. A vertex behind a
/// one-sided triangle is added to `search.penetrating`.
void collideVertexTriangle(const SurfacePair& pair, bool ofB, const NearVertex& vertex,
                           const NearTriangle& triangle, ContactSearch& search);

/// Adds the candidate of a vertex that the triangle pushes along the unit `normal`.
void addVertexOnTriangle(const SurfacePair& pair, const PenetratingVertex& vertex,
                         const Eigen::Vector3d& normal, double time, ContactSearch& search);

/// Adds a candidate for each vertex of `search.penetrating` that is inside the other surface: with the
/// nearest triangle that the vertex faces. Sorts `search.penetrating`.
void addInsideVertices(const SurfacePair& pair, ContactSearch& search);

/// Sets the barycentric coordinates of the projection of `p` onto the plane of the triangle. Returns false if
/// it is outside the triangle by more than rounding, or if the triangle has no area.
bool projectOnTriangle(const MovingFeature<3>::Corners& triangle, const Eigen::Vector3d& p,
                       Eigen::Vector3d& barycentric);

// --- edges and vertices ------------------------------------------------------------------------------------

// Each function tests one pair of features. It adds a candidate if the surfaces are locally nearest to each
// other at the nearest points of the features, now or at the time of impact.

void collideVertices(const SurfacePair& pair, const NearVertex& a, const NearVertex& b,
                     ContactSearch& search);

/// Tests a vertex of a with an edge of b, or (`ofB`) a vertex of b with an edge of a.
void collideVertexEdge(const SurfacePair& pair, bool ofB, const NearVertex& vertex, const NearEdge& edge,
                       ContactSearch& search);

/// Whether a and b are flat around their edges, which cross with this normal: then the vertices of both keep
/// the edges apart.
inline bool areFlatEdges(const MovingSurface& a, std::uint32_t edgeA, const MovingSurface& b,
                         std::uint32_t edgeB, const Eigen::Vector3d& normal) {
  return isFlatAlong(a, edgeA, normal) && isFlatAlong(b, edgeB, normal);
}

/// Tests an edge of a with an edge of b that crosses it. Edges of solid bodies may have passed through each
/// other by less than the depth limit of their triangles. `bears`: they have borne a load in the last tick.
void collideEdges(const SurfacePair& pair, const NearEdge& a, const NearEdge& b, bool bears,
                  ContactSearch& search);

}  // namespace limber

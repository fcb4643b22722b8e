// SPDX-License-Identifier: Zlib
#pragma once

// Contacts of two surfaces, or of one with itself: places that touch or will touch in a tick; and those of
// the last search, as long as they hold.

#include "collide/surface.h"

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

enum class FeatureKind : std::uint8_t { OnVertex, OnEdge, OnTriangle };

/// A place on a surface that moves with it.
struct SurfacePoint {
  FeatureKind kind = FeatureKind::OnVertex;
  std::uint32_t feature = 0;                          ///< point, edge or triangle
  std::array<std::uint32_t, 3> points = {};           ///< the feature's corners, the last repeated
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< of the points, 0 or more, sum 1
};

/// Two surfaces must not come nearer to each other here:
///     gap(t) = normal . (place on a - place on b) - both radii >= 0
struct SurfaceContact {
  SurfacePoint a, b;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, from b to a
  double gap = 0.0;       ///< m, at the start of the tick; below 0 where they overlap
  double time = 0.0;      ///< share of the tick after which they are expected to touch; 0: near already
  std::uint64_t key = 0;  ///< of the two features; no two contacts of two surfaces share one
};

constexpr std::uint64_t kNoVertex = 0xffffffffffffffffu;

/// A contact before those that say the same are removed.
struct ContactCandidate {
  SurfaceContact contact;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< m, when they touch
  double scale = 0.0;                               ///< m, of the features
  std::uint64_t vertex = kNoVertex;                 ///< that meets a surface: its point and side
  std::uint8_t rank = 0;                            ///< kinds of the features; the lower one stays
  bool dropped = false;
};

/// A vertex of one surface that may be inside the other, behind this triangle.
struct PenetratingVertex {
  bool ofB = false;  ///< the vertex
  std::uint32_t vertex = 0, triangle = 0;
  double depth = 0.0;                                     ///< m, to the triangle
  bool beneath = false;                                   ///< its foot is in the triangle
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();  ///< of the triangle's nearest place
};

/// Scratch of a search, kept for its capacity.
struct ContactSearch {
  LeafPairs waiting, near;
  std::vector<ContactCandidate> candidates;
  std::vector<PenetratingVertex> behind;
};

/// All places where the two surfaces touch, are within `margin` (m) of it, or will touch if they move on as
/// expected: vertices against triangles, edges crossing edges, and vertices against edges and vertices where
/// these are nearest. Boxes of both must be fitted. Sorted by key.
///
/// One-sided triangles push outward whatever is behind them by less than their depth limit and inside. Others
/// push to the side where things are at the start of the tick. A vertex has one contact for each direction it
/// is pushed in (within 6 degrees), and places that coincide have one.
///
/// A surface without triangles that is more than twice as thick as the other is round: a ball or a capsule
/// meets all vertices that come to it, not only the nearest, where these are closer together than its radius.
void findSurfaceContacts(const MovingSurface& a, const MovingSurface& b, double margin, ContactSearch& search,
                         std::vector<SurfaceContact>& found);

/// Contacts of a surface with itself, but not between features that share a vertex or are no farther than
/// both radii and the margin from each other at rest; and what is apart by up to `farther` (m) more.
void findSelfContacts(const MovingSurface& surface, double margin, ContactSearch& search,
                      std::vector<SurfaceContact>& found, double farther = 0.0);

// --- contacts that are kept --------------------------------------------------------------------------------

/// The contacts of two surfaces as a search has found them, and where the surfaces were then.
struct ContactCache {
  std::vector<SurfaceContact> contacts;
  Points a, b;                                                       ///< m, positions at the search
  const SurfaceTopology *topologyA = nullptr, *topologyB = nullptr;  ///< nullptr: nothing is kept
};

/// Whether a search with the same margin would find the same places again: no point has moved by more than a
/// small share of the margin since, and what was farther apart than the margin does not meet in this tick,
/// common motion apart. Then their weights, normals and gaps are made those of now; else the contacts are to
/// be searched for. Boxes need not be fitted.
bool refreshContacts(const MovingSurface& a, const MovingSurface& b, double margin, ContactCache& cache);

/// Keeps what a search has just found.
void storeContacts(const MovingSurface& a, const MovingSurface& b, const std::vector<SurfaceContact>& found,
                   ContactCache& cache);

}  // namespace limber

// SPDX-License-Identifier: Zlib

// Contacts of two surfaces, or of one with itself, that exist or will arise during a tick; the features that
// may touch, and a cache of the contacts of the last search.

#pragma once

#include "collide/surface.h"

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

struct NearVertex {
  std::uint32_t vertex, element;  ///< the element that owns it
  MovingFeature<1> feature;
};

struct NearEdge {
  std::uint32_t edge;
  MovingFeature<2> feature;
  Eigen::Vector3d along;  ///< m, at the start
};

struct NearTriangle {
  std::uint32_t triangle, element, leaf;  ///< the element that owns it, and its node
  MovingFeature<3> feature;
  Eigen::Vector3d normal;  ///< at the start, unit; 0 if it has no area
};

NearVertex nearVertex(const MovingSurface& surface, std::uint32_t vertex, std::uint32_t element = kNoFeature);
NearEdge nearEdge(const MovingSurface& surface, std::uint32_t edge);
NearTriangle nearTriangle(const MovingSurface& surface, std::uint32_t triangle,
                          std::uint32_t element = kNoFeature, std::uint32_t leaf = 0);

/// Boxes in single precision, of which several are compared at a time. They are rounded outward: those that
/// overlap in double precision overlap here, too.
class BoxList {
 public:
  void clear();
  void add(const SweptBox& box);

  const SweptBox& bounds() const { return bounds_; }

  /// Writes to `near` the pairs of boxes that overlap, of this list and of another.
  void findNear(const BoxList& other, LeafPairs& near) const;

 private:
  static constexpr std::size_t kChunk = 8;  // a multiple of 4

  struct Chunk {
    std::array<std::array<float, kChunk>, 3> low, high;
    std::array<float, 4> allLow, allHigh;  ///< around all; the fourth coordinate fills a SIMD register
  };

  static bool areNear(const Chunk& a, const Chunk& b);
  static std::uint32_t findNear(const Chunk& a, std::size_t i, const Chunk& b);

  std::vector<Chunk> chunks_;
  std::size_t size_ = 0;
  SweptBox bounds_;
};

/// The features of a surface that may touch another one.
struct NearFeatures {
  std::vector<NearVertex> vertices;
  std::vector<NearEdge> edges;
  std::vector<NearTriangle> triangles;
  BoxList vertexBoxes, edgeBoxes, triangleBoxes;  ///< of each of these
};

/// The region in which a surface may touch features of another one.
struct NearRegion {
  SweptBox features;    ///< around vertices and edges
  SweptBox all;         ///< also around what is behind triangles
  double margin = 0.0;  ///< m, largest distance of boxes that are near
};

/// Which features of a surface are listed.
struct ListedFeatures {
  bool vertices = true, triangles = true;
  const std::vector<std::uint8_t>* leftOut = nullptr;  ///< #edges, not 0: not listed; nullptr: all are
};

/// Lists the features of a surface that may touch those in the region. Their boxes are enlarged by half the
/// margin, so that those of two lists overlap where they are near.
void listNearFeatures(const MovingSurface& surface, const ListedFeatures& listed, const NearRegion& region,
                      NearFeatures& near);

// --- contacts ----------------------------------------------------------------------------------------------

enum class FeatureKind : std::uint8_t { OnVertex, OnEdge, OnTriangle };

/// A point that is fixed on a surface and moves with it.
struct SurfacePoint {
  FeatureKind kind = FeatureKind::OnVertex;
  std::uint32_t feature = 0;                 ///< index of the point, edge or triangle
  std::array<std::uint32_t, 3> points = {};  ///< the corners of the feature; the last one is repeated
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< of the corners, 0 or more, sum 1
};

/// Returns the position (m) of a point of a surface at a time of the tick.
Eigen::Vector3d positionOf(const MovingSurface& surface, const SurfacePoint& point, double time = 0.0);

/// A contact of two surfaces. It must satisfy
///     gap(t) = normal . (point on a - point on b) - both radii >= 0
struct SurfaceContact {
  SurfacePoint a, b;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, from b to a
  double gap = 0.0;                                  ///< m, at the start of the tick; below 0 if they overlap
  double time = 0.0;       ///< expected time of impact as a fraction of the tick; 0: near already
  std::uint64_t key = 0;   ///< of the two features; unique among the contacts of two surfaces
  bool separates = false;  ///< made by findOverlapContacts()
};

constexpr std::uint64_t kNoVertex = 0xffffffffffffffffu;

/// A contact before duplicates are removed.
struct FeatureCandidate {
  SurfaceContact contact;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< m, contact point at the time of impact
  double featureSize = 0.0;                         ///< m
  std::uint64_t vertex = kNoVertex;                 ///< identifies the touching vertex and its side
  std::uint8_t rank = 0;                            ///< ContactRank
  double sameDirection = 0.0;                       ///< cosine of the largest angle between equal directions
  bool dropped = false;
};

/// A vertex of one surface that may be inside the other, behind this triangle.
struct PenetratingVertex {
  bool ofB = false;  ///< the vertex is of surface b
  std::uint32_t vertex = 0, triangle = 0;
  double depth = 0.0;                                     ///< m, distance to the triangle
  bool isFootInside = false;                              ///< its foot in the plane is in the triangle
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();  ///< of the nearest point of the triangle
};

/// Where an element is, and its expected motion in the tick.
struct ElementMotion {
  const SurfaceElement* element = nullptr;
  Eigen::AlignedBox3d box;                          ///< m, at the start
  Eigen::Vector3d start = Eigen::Vector3d::Zero(),  ///< m, the middle of its corners
      rest = Eigen::Vector3d::Zero(),               ///< m, at rest
      motion = Eigen::Vector3d::Zero();             ///< m
  Eigen::Vector3d startNormal, endNormal;           ///< 0 unless it is a triangle
  double spread = 0.0;                              ///< m, limit of the corners' motion relative to `motion`
  double size = 0.0;  ///< m, at rest, largest distance of a corner from the middle
};

/// Scratch of a search. It is reused so that its memory is not allocated again.
struct ContactSearch {
  LeafPairs waiting, near;               ///< see findNearLeaves()
  NearFeatures nearA, nearB;             ///< of two surfaces
  std::vector<ElementMotion> elements;   ///< of a surface with itself
  std::vector<Extent> pointsA, pointsB;  ///< #points, along the line between the surfaces
  std::vector<FeatureCandidate> candidates;
  std::vector<PenetratingVertex> penetrating;
  std::vector<std::uint64_t> bearing;  ///< input, sorted: keys of the contacts of edges that had an impulse
                                       ///< in the last tick
};

/// Features whose contacts are found elsewhere.
struct Covered {
  bool vertices = false;                             ///< those of a
  const std::vector<std::uint8_t>* edges = nullptr;  ///< #edges of b, not 0: covered; nullptr: none
};

/// Finds all contacts of two surfaces: where they touch, are within `margin` (m) of it, or will touch after
/// their expected motion. Tests vertices with triangles, edges with crossing edges, and vertices with edges
/// and vertices where these are nearest. Boxes of both must be fitted. The contacts are sorted by key.
///
/// One-sided triangles push outward the features that are inside and behind them by less than the depth
/// limit. Other triangles push to the side on which the other feature is at the start of the tick. A vertex
/// has one contact for each direction of its contact normals (within 6 degrees). Contacts at the same point
/// with the same direction are merged into one.
///
/// Edges in a nearly flat surface do not count, except in contacts of `search.bearing`: those have flattened
/// it, and would else give way and be pushed back in turn. Where both surfaces are flat at rest and lie flat
/// on each other, their vertices are enough: of two cloths that have fallen on each other, most contacts
/// would be of edges.
///
/// A surface without triangles that is more than twice as thick as the other is round: a ball or a capsule.
/// Where vertices are closer together than its radius, it collides with all of them that approach it, not
/// only with the nearest.
///
/// `covered`: what is left out.
void findSurfaceContacts(const MovingSurface& a, const MovingSurface& b, double margin, ContactSearch& search,
                         std::vector<SurfaceContact>& found, const Covered& covered = {});

/// Finds contacts that separate two closed surfaces which have been placed into each other, however deep,
/// along one direction: one for each vertex that is deeper inside than both radii. Returns false, and finds
/// none, if there is no such vertex, or if one surface is inside the other as a whole. Boxes of both must be
/// fitted.
bool findOverlapContacts(const MovingSurface& a, const MovingSurface& b, ContactSearch& search,
                         std::vector<SurfaceContact>& found);

/// Finds the contacts of a surface with itself up to a gap of `margin` (m). Leaves out features that share a
/// vertex, features whose distance at rest is at most both radii and `margin`, and triangles between which
/// the surface is about flat.
void findSelfContacts(const MovingSurface& surface, double margin, ContactSearch& search,
                      std::vector<SurfaceContact>& found);

/// Whether a surface may touch itself within the tick: parts of it move relative to each other by up to
/// `displacement` (m) as expected, by a quarter of it beyond that, and by `others` (m) where something stops
/// them. `found` is scratch.
bool mayTouchItself(const MovingSurface& surface, double margin, double displacement, double others,
                    ContactSearch& search, std::vector<SurfaceContact>& found);

// --- contact cache -----------------------------------------------------------------------------------------

/// The contacts of two surfaces from the last search, and the positions at that time.
struct ContactCache {
  std::vector<SurfaceContact> contacts;
  Points a, b;                                                       ///< m, positions at the search
  const SurfaceTopology *topologyA = nullptr, *topologyB = nullptr;  ///< nullptr: the cache is empty
};

/// Updates weights, normals and gaps of the cached contacts to the present positions. Returns false if a new
/// search is needed. None is needed if it would find the same contacts: relative to the common motion, no
/// point has moved by more than a small share of the margin since the search, and features that were farther
/// apart than the margin cannot touch during this tick. Boxes need not be fitted.
bool refreshContacts(const MovingSurface& a, const MovingSurface& b, double margin, ContactCache& cache);

/// Moves a contact of near features to where they are expected to be nearest in the middle of the tick. It
/// keeps normal and points for a tick: with those of the start, its force would lag behind by half a tick,
/// and would drive oscillations for ever, as of a cloth's corner that lies on the edge of another cloth.
void moveToMiddle(const MovingSurface& a, const MovingSurface& b, SurfaceContact& c);

/// Stores the contacts of a search in the cache.
void storeContacts(const MovingSurface& a, const MovingSurface& b, const std::vector<SurfaceContact>& found,
                   ContactCache& cache);

}  // namespace limber

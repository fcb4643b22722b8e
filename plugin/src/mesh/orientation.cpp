// SPDX-License-Identifier: Zlib
// Orients surfaces outward: closed components by their volume, and the patches of open or broken meshes by
// their shape.

#include "mesh/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace limber {

using Eigen::Vector3d;

// --- closed components -------------------------------------------------------------------------------------

namespace {

struct Component {
  std::vector<Triangle> triangles;
  Eigen::AlignedBox3d box;
  double volume = 0.0;  ///< m^3, signed; 0 unless closed
};

std::vector<Component> split(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles,
                             const SurfaceComponents& components) {
  std::vector<Component> parts(components.count);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Component& part = parts[components.ofTriangle[t]];
    part.triangles.push_back(triangles[t]);
    for (const std::uint32_t corner : triangles[t]) part.box.extend(points[corner]);
  }
  for (Component& part : parts) {
    if (findEdgeDefects(part.triangles).none()) part.volume = signedVolume(points, part.triangles);
  }
  return parts;
}

/// Returns whether a corner of `inner` is inside `outer`. Components that pass through each other are not
/// within each other.
bool isWithin(const std::vector<Vector3d>& points, const Component& inner, const Component& outer) {
  if (!outer.box.contains(inner.box)) return false;
  const Vector3d& corner = points[inner.triangles.front().front()];
  double angle = 0.0;
  for (const Triangle& t : outer.triangles)
    angle += solidAngle({points[t[0]], points[t[1]], points[t[2]]}, corner);
  return std::abs(angle) > 2.0 * kPi;
}

const Component& outermostAround(const std::vector<Vector3d>& points, const Component& part,
                                 const std::vector<Component>& parts) {
  const Component* outermost = &part;
  for (const Component& other : parts)
    if (std::abs(other.volume) > std::abs(outermost->volume) && isWithin(points, part, other))
      outermost = &other;
  return *outermost;
}

}  // namespace

std::vector<bool> facingInward(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles) {
  const SurfaceComponents components = findComponents(points.size(), triangles);
  const std::vector<Component> parts = split(points, triangles, components);
  if (std::none_of(parts.begin(), parts.end(), [](const Component& c) { return c.volume < 0.0; }))
    return std::vector<bool>(triangles.size(), false);
  std::vector<bool> flipped;
  flipped.reserve(parts.size());
  for (const Component& part : parts)
    flipped.push_back(part.volume != 0.0 && outermostAround(points, part, parts).volume < 0.0);
  std::vector<bool> marked;
  for (const std::uint32_t component : components.ofTriangle) marked.push_back(flipped[component]);
  return marked;
}

void flip(std::vector<Triangle>& triangles, const std::vector<bool>& marked) {
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (marked[t]) std::swap(triangles[t][1], triangles[t][2]);
}

std::vector<Triangle> facingOutward(const std::vector<Vector3d>& points, std::vector<Triangle> triangles) {
  flip(triangles, facingInward(points, triangles));
  return triangles;
}

// --- patches -----------------------------------------------------------------------------------------------

namespace {

/// A patch is a set of triangles that are joined by edges of two triangles. It can be oriented consistently,
/// except for surfaces with one side (Moebius strips).
struct Patches {
  std::vector<std::uint32_t> ofTriangle;  ///< #triangles
  std::vector<char> flipped;  ///< #triangles: against the first triangle of its patch in the orientation
  std::uint32_t count = 0;
};

/// Returns for each triangle the neighbours across its three edges, or kNoPoint where the edge is open or of
/// more than two triangles.
std::vector<std::array<std::uint32_t, 3>> neighboursOf(const std::vector<Triangle>& triangles) {
  struct Side {
    Edge edge;
    std::uint32_t triangle, corner;
  };
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t c = 0; c < 3; ++c)
      sides.push_back({edgeBetween(triangles[t][c], triangles[t][(c + 1) % 3]), t, c});
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge < b.edge; });
  std::vector<std::array<std::uint32_t, 3>> neighbours(triangles.size(), {kNoPoint, kNoPoint, kNoPoint});
  for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
    while (last < sides.size() && sides[last].edge == sides[first].edge) ++last;
    if (last - first != 2) continue;
    neighbours[sides[first].triangle][sides[first].corner] = sides[first + 1].triangle;
    neighbours[sides[first + 1].triangle][sides[first + 1].corner] = sides[first].triangle;
  }
  return neighbours;
}

/// Returns whether the triangle runs from `a` to `b` along one of its sides.
bool runsAlong(const Triangle& t, std::uint32_t a, std::uint32_t b) {
  return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
}

Patches findPatches(const std::vector<Triangle>& triangles) {
  const auto neighbours = neighboursOf(triangles);
  Patches patches{std::vector<std::uint32_t>(triangles.size(), kNoPoint),
                  std::vector<char>(triangles.size(), 0), 0};
  std::vector<std::uint32_t> front;
  for (std::uint32_t seed = 0; seed < triangles.size(); ++seed) {
    if (patches.ofTriangle[seed] != kNoPoint) continue;
    patches.ofTriangle[seed] = patches.count;
    front.assign(1, seed);
    while (!front.empty()) {
      const std::uint32_t t = front.back();
      front.pop_back();
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t other = neighbours[t][c];
        if (other == kNoPoint || patches.ofTriangle[other] != kNoPoint) continue;
        const bool against = runsAlong(triangles[other], triangles[t][c], triangles[t][(c + 1) % 3]);
        patches.ofTriangle[other] = patches.count;
        patches.flipped[other] = static_cast<char>(patches.flipped[t] != static_cast<char>(against));
        front.push_back(other);
      }
    }
    ++patches.count;
  }
  return patches;
}

/// A patch in the orientation of its first triangle.
struct PatchShape {
  double area = 0.0, agreeing = 0.0;  ///< m^2; of triangles that the mesh orients like this
  Vector3d moment = Vector3d::Zero(), vector = Vector3d::Zero();  ///< sums of area x centroid, area vectors
  double flux = 0.0;  ///< m^3, a third of the sum of centroid . area vector, about the origin

  Vector3d centre() const { return area > 0.0 ? Vector3d(moment / area) : Vector3d::Zero(); }
  double volumeAbout(const Vector3d& p) const { return flux - p.dot(vector) / 3.0; }
};

/// A patch with more than this sphericity, 36 pi V^2 / A^3, is curved enough that its own volume shows its
/// outside: a ball has 1, half a ball without its base 0.25, a shallow dish less.
constexpr double kCurved = 0.02;

/// Returns whether a patch must be turned against the orientation of its first triangle: curved patches
/// enclose a positive volume with their middle, the others keep the orientation of most of their area if the
/// mesh gives them one, and else face away from the middle of the mesh.
bool facesInward(const PatchShape& patch, const Vector3d& middle) {
  const double own = patch.volumeAbout(patch.centre());
  if (36.0 * kPi * own * own > kCurved * patch.area * patch.area * patch.area) return own < 0.0;
  const bool isConsistent = patch.agreeing <= 0.0 || patch.agreeing >= patch.area;
  return isConsistent ? patch.agreeing <= 0.0 : patch.volumeAbout(middle) < 0.0;
}

/// Returns the patches in the orientation of their first triangles, and the middle of the mesh, by area.
std::vector<PatchShape> measurePatches(const std::vector<Vector3d>& points,
                                       const std::vector<Triangle>& triangles, const Patches& patches,
                                       Vector3d& middle) {
  std::vector<PatchShape> shapes(patches.count);
  double area = 0.0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vector3d &a = points[triangles[t][0]], &b = points[triangles[t][1]], &c = points[triangles[t][2]];
    const double sign = patches.flipped[t] ? -1.0 : 1.0;
    const Vector3d vector = sign * areaVector(a, b, c), centroid = (a + b + c) / 3.0;
    PatchShape& shape = shapes[patches.ofTriangle[t]];
    shape.area += vector.norm();
    shape.agreeing += patches.flipped[t] ? 0.0 : vector.norm();
    shape.moment += vector.norm() * centroid;
    shape.vector += vector;
    shape.flux += centroid.dot(vector) / 3.0;
    middle += vector.norm() * centroid;
    area += vector.norm();
  }
  if (area > 0.0) middle /= area;
  return shapes;
}

}  // namespace

std::vector<bool> patchesFacingInward(const std::vector<Vector3d>& points,
                                      const std::vector<Triangle>& triangles) {
  const Patches patches = findPatches(triangles);
  Vector3d middle = Vector3d::Zero();
  const std::vector<PatchShape> shapes = measurePatches(points, triangles, patches, middle);
  std::vector<bool> marked;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    marked.push_back((patches.flipped[t] != 0) != facesInward(shapes[patches.ofTriangle[t]], middle));
  return marked;
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "collide/surface_contacts.h"

#include <cmath>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace limber {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// More than the relative error of rounding to single precision, and than its least number.
constexpr double kRounding = 1.2e-7, kLeast = 1e-37;

float roundedDown(double x) { return static_cast<float>(x - std::abs(x) * kRounding - kLeast); }
float roundedUp(double x) { return static_cast<float>(x + std::abs(x) * kRounding + kLeast); }

}  // namespace

NearVertex nearVertex(const MovingSurface& surface, std::uint32_t vertex, std::uint32_t element) {
  return {vertex, element, {surface.position->col(vertex), surface.motion->col(vertex)}};
}

NearEdge nearEdge(const MovingSurface& surface, std::uint32_t edge) {
  const auto feature = featureOf<2>(surface, surface.topology->edges[edge]);
  return {edge, feature, feature.start.col(1) - feature.start.col(0)};
}

NearTriangle nearTriangle(const MovingSurface& surface, std::uint32_t triangle, std::uint32_t element,
                          std::uint32_t leaf) {
  const auto feature = featureOf<3>(surface, surface.topology->triangles[triangle]);
  return {triangle, element, leaf, feature, normalOf<3>(feature.start)};
}

void BoxList::clear() {
  chunks_.clear();
  size_ = 0;
  bounds_ = SweptBox();
}

void BoxList::add(const SweptBox& box) {
  const std::size_t lane = size_ % kChunk;
  if (lane == 0) {
    Chunk& empty = chunks_.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) empty.low[k].fill(kInfinity), empty.high[k].fill(-kInfinity);
    empty.allLow = {kInfinity, kInfinity, kInfinity, 0.0f};
    empty.allHigh = {-kInfinity, -kInfinity, -kInfinity, 0.0f};
  }
  Chunk& chunk = chunks_.back();
  for (std::size_t k = 0; k < 3; ++k) {
    chunk.low[k][lane] = roundedDown(box.low[static_cast<Eigen::Index>(k)]);
    chunk.high[k][lane] = roundedUp(box.high[static_cast<Eigen::Index>(k)]);
    chunk.allLow[k] = std::min(chunk.allLow[k], chunk.low[k][lane]);
    chunk.allHigh[k] = std::max(chunk.allHigh[k], chunk.high[k][lane]);
  }
  bounds_ = merged(bounds_, box);
  ++size_;
}

// GCC 12 compares the boxes one by one where it inlines plain loops.
#if defined(__SSE2__)

inline bool BoxList::areNear(const Chunk& a, const Chunk& b) {
  const auto all = [](const std::array<float, 4>& x) { return _mm_loadu_ps(x.data()); };
  const __m128 near = _mm_and_ps(_mm_cmple_ps(all(a.allLow), all(b.allHigh)),  //
                                 _mm_cmple_ps(all(b.allLow), all(a.allHigh)));
  return _mm_movemask_ps(near) == 0xf;
}

/// Returns which boxes of b overlap box i of a, one bit for each.
inline std::uint32_t BoxList::findNear(const Chunk& a, std::size_t i, const Chunk& b) {
  std::uint32_t bits = 0;
  for (std::size_t first = 0; first < kChunk; first += 4) {
    __m128 near = _mm_castsi128_ps(_mm_set1_epi32(-1));
    for (std::size_t k = 0; k < 3; ++k) {
      const __m128 low = _mm_loadu_ps(b.low[k].data() + first), high = _mm_loadu_ps(b.high[k].data() + first);
      near = _mm_and_ps(near, _mm_cmple_ps(_mm_set1_ps(a.low[k][i]), high));
      near = _mm_and_ps(near, _mm_cmple_ps(low, _mm_set1_ps(a.high[k][i])));
    }
    bits |= static_cast<std::uint32_t>(_mm_movemask_ps(near)) << first;
  }
  return bits;
}

#else

inline bool BoxList::areNear(const Chunk& a, const Chunk& b) {
  bool near = true;
  for (std::size_t k = 0; k < 3; ++k)
    near = near && a.allLow[k] <= b.allHigh[k] && b.allLow[k] <= a.allHigh[k];
  return near;
}

/// Returns which boxes of b overlap box i of a, one bit for each.
inline std::uint32_t BoxList::findNear(const Chunk& a, std::size_t i, const Chunk& b) {
  std::uint32_t bits = 0;
  for (std::size_t j = 0; j < kChunk; ++j) {
    bool near = true;
    for (std::size_t k = 0; k < 3; ++k)
      near = near & (a.low[k][i] <= b.high[k][j]) & (b.low[k][j] <= a.high[k][i]);
    bits |= std::uint32_t{near} << j;
  }
  return bits;
}

#endif

void BoxList::findNear(const BoxList& other, LeafPairs& near) const {
  std::size_t found = 0;
  for (std::size_t first = 0; first < size_; first += kChunk)
    for (std::size_t begin = 0; begin < other.size_; begin += kChunk) {
      const Chunk &a = chunks_[first / kChunk], &b = other.chunks_[begin / kChunk];
      if (!areNear(a, b)) continue;
      if (near.size() < found + kChunk * kChunk) near.resize(2 * near.size() + kChunk * kChunk);
      for (std::size_t i = 0; i < std::min(kChunk, size_ - first); ++i) {
        const std::uint32_t bits = findNear(a, i, b);
        if (bits == 0) continue;
        // writes all, and keeps those that are near: no branch to mispredict
        for (std::size_t j = 0; j < kChunk; ++j) {
          near[found] = {static_cast<std::uint32_t>(first + i), static_cast<std::uint32_t>(begin + j)};
          found += bits >> j & 1u;
        }
      }
    }
  near.resize(found);
}

namespace {

/// Lists the features that elements of a surface own.
struct Lister {
  const MovingSurface& surface;
  const ListedFeatures& listed;
  const NearRegion& region;
  NearFeatures& near;

  /// Adds what is near of the element of a leaf.
  void add(std::uint32_t leaf) {
    const std::uint32_t number = surface.topology->nodes[leaf].element;
    const SweptBox& box = surface.boxes->nodes[leaf];
    const SurfaceElement& element = surface.topology->elements[number];
    if (listed.vertices)
      for (const std::uint32_t v : element.vertices)
        if (v != kNoFeature) addVertex(v, number);
    for (const std::uint32_t e : element.edges)
      if (e != kNoFeature && !(listed.leftOut && (*listed.leftOut)[e])) addEdge(e);
    if (!listed.triangles || element.triangle == kNoFeature || !isNear(box, region.features)) return;
    near.triangles.push_back(nearTriangle(surface, element.triangle, number, leaf));
    add(near.triangleBoxes, box);
  }

 private:
  void addVertex(std::uint32_t v, std::uint32_t element) {
    const SweptBox& box = surface.boxes->points[v];
    if (!isNear(box, region.all)) return;
    near.vertices.push_back(nearVertex(surface, v, element));
    add(near.vertexBoxes, box);
  }

  void addEdge(std::uint32_t e) {
    const auto [first, second] = surface.topology->edges[e];
    const SweptBox box = merged(surface.boxes->points[first], surface.boxes->points[second]);
    if (!isNear(box, region.features)) return;
    near.edges.push_back(nearEdge(surface, e));
    add(near.edgeBoxes, box);
  }

  void add(BoxList& boxes, const SweptBox& box) const {
    boxes.add({box.low - 0.5 * region.margin, box.high + 0.5 * region.margin});
  }

  bool isNear(const SweptBox& box, const SweptBox& other) const {
    return separation(box, other) <= region.margin;
  }
};

}  // namespace

void listNearFeatures(const MovingSurface& surface, const ListedFeatures& listed, const NearRegion& region,
                      NearFeatures& near) {
  near.vertices.clear(), near.edges.clear(), near.triangles.clear();
  near.vertexBoxes.clear(), near.edgeBoxes.clear(), near.triangleBoxes.clear();
  Lister lister{surface, listed, region, near};
  const std::vector<SurfaceNode>& nodes = surface.topology->nodes;
  std::array<std::uint32_t, kNodeStack> stack{};
  std::size_t waiting = nodes.empty() ? 0 : 1;
  while (waiting > 0) {
    const std::uint32_t i = stack[--waiting];
    if (separation(surface.boxes->nodes[i], region.all) > region.margin) continue;
    if (nodes[i].element != kNoFeature) {
      lister.add(i);
    } else {
      stack[waiting++] = nodes[i].child + 1;
      stack[waiting++] = nodes[i].child;
    }
  }
}

}  // namespace limber

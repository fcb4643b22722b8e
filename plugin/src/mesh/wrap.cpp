// SPDX-License-Identifier: Zlib
// Wraps any mesh by a closed surface: samples on a grid which places are inside, thickens sheets and fills
// gaps there, joins far pieces by rods, and extracts the boundary by marching tetrahedra.

#include "mesh/surface.h"

#include "mesh/triangle_bvh.h"

#include <cmath>
#include <unordered_map>

namespace limber {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using Points = std::vector<Vector3d>;
using Triangles = std::vector<Triangle>;

// --- samples on a grid -------------------------------------------------------------------------------------

/// Samples at the nodes of cubic cells, which are numbered x first, then y, then z: negative inside the body.
struct Grid {
  Vector3d origin = Vector3d::Zero();  ///< m, of node 0
  double width = 0.0;                  ///< m, of a cell
  Vector3i nodes = Vector3i::Zero();   ///< along each axis
  std::vector<double> values{};        ///< #nodes

  std::size_t index(const Vector3i& n) const {
    return static_cast<std::size_t>(n[0]) +
           static_cast<std::size_t>(nodes[0]) *
               (static_cast<std::size_t>(n[1]) +
                static_cast<std::size_t>(nodes[1]) * static_cast<std::size_t>(n[2]));
  }
  double& operator[](const Vector3i& n) { return values[index(n)]; }
  double operator[](const Vector3i& n) const { return values[index(n)]; }
  Vector3d position(const Vector3i& n) const { return origin + width * n.cast<double>(); }
};

template <class Visit>
void forEachNode(const Vector3i& low, const Vector3i& high, Visit visit) {
  for (int z = low[2]; z <= high[2]; ++z)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x) visit(Vector3i(x, y, z));
}

/// Nodes along the side of a block that is sampled at its corners alone where no surface is near.
constexpr int kBlock = 6;

/// Calls visit(lowest node, highest node) for each block.
template <class Visit>
void forEachBlock(const Grid& grid, Visit visit) {
  const Vector3i blocks = (grid.nodes.array() + kBlock - 1) / kBlock;
  forEachNode(Vector3i::Zero(), blocks.array() - 1, [&](const Vector3i& block) {
    const Vector3i low = kBlock * block;
    visit(low, Vector3i((low.array() + kBlock - 1).min(grid.nodes.array() - 1)));
  });
}

/// Returns the place of one of the eight corners of a cell, in cells from the lowest one.
Vector3i cornerOffset(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2 & 1}; }

/// Triangles that need not share corners.
struct Soup {
  Points points;
  Triangles triangles;

  void add(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const auto first = static_cast<std::uint32_t>(points.size());
    triangles.push_back({first, first + 1, first + 2});
    points.insert(points.end(), {a, b, c});
  }
};

/// The oriented mesh, and the sizes in use.
struct Source {
  Points points;
  Triangles triangles;
  TriangleBvh bvh;
  WrapSettings sizes;  ///< with defaults
  bool isClosed;       ///< winding numbers change at its triangles only
};

/// At caps over holes there is no surface whose distance could place the boundary; there the winding number
/// does. A difference of 1/2 from the border counts as this many cells.
constexpr double kCellsPerHalf = 2.0;

/// Returns the value of a place that is not near a sheet: negative inside, its size (m) the distance from the
/// surface or from a cap. `excess`: by how much its winding number is below 1/2.
double solidValue(const Source& source, const Vector3d& p, double excess) {
  const double most = 2.0 * kCellsPerHalf * source.sizes.resolution * std::abs(excess);
  const TriangleHit surface = source.bvh.nearestWithin(p, most);
  const double size = surface ? surface.distance : most;
  return excess < 0.0 ? -size : size;
}

/// A winding number whose difference from 1/2 is larger than this at all corners of a block that no triangle
/// comes near does not cross 1/2 within it.
constexpr double kClearlyOff = 0.15;

/// Returns whether the block from `low` to `high` has no surface in it and one side at all corners; then sets
/// `value` to it.
bool isUniform(const Source& source, const Grid& grid, const Vector3i& low, const Vector3i& high,
               double& value) {
  const Vector3d a = grid.position(low), b = grid.position(high);
  const double radius = 0.5 * (b - a).norm(), distance = source.bvh.nearest(0.5 * (a + b)).distance;
  if (distance < radius + grid.width) return false;
  int inside = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d p(corner & 1 ? b[0] : a[0], corner & 2 ? b[1] : a[1], corner & 4 ? b[2] : a[2]);
    const double excess = source.bvh.windingNumber(p) - 0.5;
    if (std::abs(excess) < kClearlyOff) return false;
    inside += excess > 0.0 ? 1 : 0;
  }
  value = (inside > 0 ? -1.0 : 1.0) * (distance - radius);
  return inside == 0 || inside == 8;
}

/// Sets the value of each node. Values of blocks far from the surface are bounds.
void sampleOpen(const Source& source, Grid& grid) {
  forEachBlock(grid, [&](const Vector3i& low, const Vector3i& high) {
    double value = 0.0;
    const bool isSame = isUniform(source, grid, low, high, value);
    forEachNode(low, high, [&](const Vector3i& n) {
      const Vector3d p = grid.position(n);
      grid[n] = isSame ? value : solidValue(source, p, 0.5 - source.bvh.windingNumber(p));
    });
  });
}

/// Sets the value of each node to its distance from the surface, m, or a lower bound of more than a cell.
void sampleDistances(const Source& source, Grid& grid) {
  forEachBlock(grid, [&](const Vector3i& low, const Vector3i& high) {
    const Vector3d a = grid.position(low), b = grid.position(high);
    const double ofBlock = source.bvh.nearest(0.5 * (a + b)).distance - 0.5 * (b - a).norm();
    forEachNode(low, high, [&](const Vector3i& n) {
      grid[n] = ofBlock < grid.width ? std::abs(solidValue(source, grid.position(n), 0.5)) : ofBlock;
    });
  });
}

/// Neighbours whose distances from a closed surface add up to more than this many cells are linked: it does
/// not pass between them, or by rounding only.
constexpr double kLinked = 1.001;

/// Makes the value of the node and of all nodes that are linked to it negative if it is inside.
void spreadSide(const Source& source, const Vector3i& from, std::vector<char>& known, Grid& grid) {
  const double sign = source.bvh.inside(grid.position(from)) ? -1.0 : 1.0;
  std::vector<Vector3i> waiting{from};
  known[grid.index(from)] = 1;
  while (!waiting.empty()) {
    const Vector3i n = waiting.back();
    waiting.pop_back();
    double& value = grid[n];
    for (int side = 0; side < 6; ++side) {
      const Vector3i next = n + (side % 2 == 0 ? 1 : -1) * Vector3i::Unit(side / 2);
      if ((next.array() < 0).any() || (next.array() >= grid.nodes.array()).any()) continue;
      if (known[grid.index(next)] || !(value + grid[next] > kLinked * grid.width)) continue;
      known[grid.index(next)] = 1;
      waiting.push_back(next);
    }
    value *= sign;
  }
}

/// The same as sampleOpen() for a closed surface: few winding numbers tell the sides of all nodes.
void sampleClosed(const Source& source, Grid& grid) {
  sampleDistances(source, grid);
  std::vector<char> known(grid.values.size(), 0);
  forEachNode(Vector3i::Zero(), grid.nodes.array() - 1, [&](const Vector3i& n) {
    if (!known[grid.index(n)]) spreadSide(source, n, known, grid);
  });
}

/// Where triangles of several sheets meet, patches can be oriented against each other, and places far outside
/// then seem inside. No orientation is right in this case: all triangles count as sheets.
void distrustInsides(Grid& grid) {
  bool reachesBorder = false;
  forEachNode(Vector3i::Zero(), grid.nodes.array() - 1, [&](const Vector3i& n) {
    const bool isBorder = (n.array() == 0).any() || (n.array() == grid.nodes.array() - 1).any();
    reachesBorder = reachesBorder || (isBorder && grid[n] < 0.0);
  });
  if (!reachesBorder) return;
  for (double& value : grid.values) value = std::abs(value);
}

/// Unites the inside with all places within half the thickness of the triangles.
void thicken(const Soup& soup, double thickness, Grid& grid) {
  if (soup.triangles.empty()) return;
  const TriangleBvh bvh(soup.points, soup.triangles);
  const double radius = 0.5 * thickness, far = radius + 2.0 * grid.width;
  forEachBlock(grid, [&](const Vector3i& low, const Vector3i& high) {
    const Vector3d a = grid.position(low), b = grid.position(high);
    if (bvh.nearest(0.5 * (a + b)).distance > 0.5 * (b - a).norm() + far) return;
    forEachNode(low, high, [&](const Vector3i& n) {
      double& value = grid[n];
      if (!(value > -radius)) return;
      if (const TriangleHit near = bvh.nearestWithin(grid.position(n), value + radius))
        value = std::min(value, near.distance - radius);
    });
  });
}

// --- gaps --------------------------------------------------------------------------------------------------

/// Replaces f by the lower envelope of the parabolas (i - j)^2 + f_j (P. Felzenszwalb, D. Huttenlocher,
/// "Distance transforms of sampled functions", 2012).
void transformRow(std::vector<double>& f, std::vector<double>& out, std::vector<int>& hull,
                  std::vector<double>& border) {
  const int n = static_cast<int>(f.size());
  // no int: the square of 46341 is too large
  const auto lifted = [&](double distance, int v) {
    return f[static_cast<std::size_t>(v)] + distance * distance;
  };
  hull.assign(f.size(), 0);
  border.assign(f.size() + 1, 0.0);
  std::size_t k = 0;
  border[0] = -HUGE_VAL;
  border[1] = HUGE_VAL;
  for (int q = 1; q < n; ++q) {
    const auto meeting = [&](int v) { return (lifted(q, q) - lifted(v, v)) / (2.0 * (q - v)); };
    while (meeting(hull[k]) <= border[k]) --k;
    const double from = meeting(hull[k]);
    hull[++k] = q;
    border[k] = from;
    border[k + 1] = HUGE_VAL;
  }
  k = 0;
  for (int q = 0; q < n; ++q) {
    while (border[k + 1] < q) ++k;
    out[static_cast<std::size_t>(q)] = lifted(q - hull[k], hull[k]);
  }
}

/// Stands for an infinite square of a distance, in cells.
constexpr double kFar = 1e12;

/// Returns for each node the distance to the nearest marked node, m.
std::vector<double> distanceTo(const Grid& grid, const std::vector<char>& marked) {
  std::vector<double> squares(marked.size()), border;
  for (std::size_t i = 0; i < marked.size(); ++i) squares[i] = marked[i] ? 0.0 : kFar;
  std::vector<int> hull;
  std::size_t stride = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto length = static_cast<std::size_t>(grid.nodes[axis]);
    std::vector<double> row(length), out(length);
    for (std::size_t i = 0; i < squares.size(); ++i) {
      if (i / stride % length != 0) continue;
      for (std::size_t j = 0; j < length; ++j) row[j] = squares[i + j * stride];
      transformRow(row, out, hull, border);
      for (std::size_t j = 0; j < length; ++j) squares[i + j * stride] = out[j];
    }
    stride *= length;
  }
  for (double& square : squares) square = grid.width * std::sqrt(square);
  return squares;
}

/// Fills gaps narrower than `join`, by a morphological closing: what is nearer than join / 2 to the inside is
/// kept where nothing else is near. The nearest marked node is up to a cell farther than the nearest place,
/// so a flat surface only stays where it is with a cell of tolerance.
void fillGaps(double join, Grid& grid) {
  std::vector<double>& values = grid.values;
  std::vector<char> inside(values.size()), clear(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) inside[i] = values[i] < 0.0;
  const std::vector<double> toInside = distanceTo(grid, inside);
  for (std::size_t i = 0; i < values.size(); ++i) clear[i] = toInside[i] > 0.5 * join;
  const std::vector<double> toClear = distanceTo(grid, clear);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!inside[i] && !clear[i] && toClear[i] > 0.5 * join + grid.width) values[i] = -0.5 * grid.width;
}

// --- the boundary ------------------------------------------------------------------------------------------

/// Cuts nearer than this fraction of an edge to its end are moved, so that no two cuts coincide.
constexpr double kMinFraction = 0.02;

/// Extracts the boundary between nodes with values below 0 and the others. Each cell is divided into six
/// tetrahedra around its diagonal (H. Kuhn), so the surface is closed and a manifold.
class Boundary {
 public:
  explicit Boundary(const Grid& grid) : grid_(grid) {}

  TriangleMesh extract() {
    static constexpr std::array<std::array<int, 2>, 6> kPaths{
        {{1, 3}, {2, 6}, {4, 5}, {2, 3}, {4, 6}, {1, 5}}};  // corners between 0 and 7; three even, three odd
    forEachNode(Vector3i::Zero(), grid_.nodes.array() - 2, [&](const Vector3i& cell) {
      if (!isCrossed(cell)) return;
      for (std::size_t i = 0; i < 6; ++i) {
        const int a = i < 3 ? kPaths[i][0] : kPaths[i][1], b = i < 3 ? kPaths[i][1] : kPaths[i][0];
        cut(cell, {0, a, b, 7});
      }
    });
    return std::move(mesh_);
  }

 private:
  double value(const Vector3i& cell, int corner) const { return grid_[cell + cornerOffset(corner)]; }

  bool isCrossed(const Vector3i& cell) const {
    int inside = 0;
    for (int corner = 0; corner < 8; ++corner) inside += value(cell, corner) < 0.0 ? 1 : 0;
    return inside > 0 && inside < 8;
  }

  /// Adds the part of the boundary in a positively oriented tetrahedron.
  void cut(const Vector3i& cell, std::array<int, 4> t) {
    const auto isInside = [&](int corner) { return value(cell, corner) < 0.0; };
    const auto inside = std::count_if(t.begin(), t.end(), isInside);
    if (inside == 0 || inside == 4) return;
    bool odd = false;  // sort: inside first
    for (std::size_t pass = 0; pass < 3; ++pass)
      for (std::size_t i = 0; i < 3; ++i)
        if (!isInside(t[i]) && isInside(t[i + 1])) {
          std::swap(t[i], t[i + 1]);
          odd = !odd;
        }
    if (odd) inside == 1 ? std::swap(t[2], t[3]) : std::swap(t[0], t[1]);
    const auto vertex = [&](std::size_t i, std::size_t j) { return vertexBetween(cell, t[i], t[j]); };
    if (inside == 1) mesh_.triangles.push_back({vertex(0, 1), vertex(0, 2), vertex(0, 3)});
    if (inside == 3) mesh_.triangles.push_back({vertex(0, 3), vertex(1, 3), vertex(2, 3)});
    if (inside != 2) return;
    const std::uint32_t a = vertex(0, 2), b = vertex(0, 3), c = vertex(1, 3), d = vertex(1, 2);
    mesh_.triangles.push_back({a, b, c});
    mesh_.triangles.push_back({a, c, d});
  }

  /// Returns the vertex on the edge from an inside to an outside corner, which all its tetrahedra share.
  std::uint32_t vertexBetween(const Vector3i& cell, int in, int out) {
    const std::size_t low = grid_.index(cell + cornerOffset(in & out));
    const auto [entry, isNew] = vertexOfEdge_.try_emplace(8 * low + static_cast<std::size_t>(in ^ out), 0u);
    if (isNew) {
      entry->second = static_cast<std::uint32_t>(mesh_.positions.size());
      const double a = value(cell, in), b = value(cell, out);
      const double fraction = std::clamp(a / (a - b), kMinFraction, 1.0 - kMinFraction);
      const Vector3d from = grid_.position(cell + cornerOffset(in)),
                     to = grid_.position(cell + cornerOffset(out));
      mesh_.positions.push_back(from + fraction * (to - from));
    }
    return entry->second;
  }

  const Grid& grid_;
  TriangleMesh mesh_;
  std::unordered_map<std::size_t, std::uint32_t> vertexOfEdge_;
};

/// Extracts the surface without pieces of less than the fraction `crumb` of the volume, counts them and
/// measures their volume.
void extractPieces(const Grid& grid, double crumb, WrappedMesh& wrapped) {
  const TriangleMesh mesh = Boundary(grid).extract();
  wrapped.pieces = wrapped.crumbs = 0;
  wrapped.volume = 0.0;
  const double all = signedVolume(mesh.positions, mesh.triangles);
  Triangles kept;
  for (const Triangles& part : trianglesOfPieces(mesh.positions.size(), mesh.triangles)) {
    const double volume = signedVolume(mesh.positions, part);
    if (std::abs(volume) < crumb * all) {
      ++wrapped.crumbs;
      continue;
    }
    ++wrapped.pieces;
    wrapped.volume += volume;
    kept.insert(kept.end(), part.begin(), part.end());
  }
  wrapped.mesh = partOf(mesh, std::move(kept));
}

// --- thin parts --------------------------------------------------------------------------------------------

/// Returns the trilinear interpolation of the values at a place inside the grid.
double interpolate(const Grid& grid, const Vector3d& p) {
  const Vector3d cells = (p - grid.origin) / grid.width;
  const Vector3i low = cells.array().floor().cast<int>().max(0).min(grid.nodes.array() - 2);
  const Vector3d upper = cells - low.cast<double>();
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3i offset = cornerOffset(corner);
    double weight = 1.0;
    for (int i = 0; i < 3; ++i) weight *= offset[i] ? upper[i] : 1.0 - upper[i];
    sum += weight * grid[low + offset];
  }
  return sum;
}

bool isInside(const Grid& grid, const Vector3d& p) { return interpolate(grid, p) < 0.0; }

/// Returns how many of four samples of the triangle have an outside place below them, as deep as the
/// thickness.
int thinSamples(const Grid& grid, double thickness, const TriangleCorners& t, const Vector3d& normal) {
  const Vector3d middle = centroid(t), below = -thickness * normal;
  int thin = 0;
  for (const Vector3d& p : {middle, Vector3d(0.5 * (middle + t[0])), Vector3d(0.5 * (middle + t[1])),
                            Vector3d(0.5 * (middle + t[2]))})
    thin += isInside(grid, p + below) ? 0 : 1;
  return thin;
}

/// Returns the distance (m) of the middle of the part from its triangle: half of that to the opposite side.
/// A single sheet has no other side.
double halfDepth(const Source& source, const TriangleCorners& t, const Vector3d& normal) {
  const double start = 1e-3 * source.sizes.resolution;
  const TriangleHit hit = source.bvh.firstHit(centroid(t), -normal, start, source.sizes.thickness);
  return hit ? 0.5 * hit.distance : 0.0;
}

/// Returns the middle surfaces of the parts that are thinner than the thickness. Sets the fraction of
/// the area that they have.
Soup findThinParts(const Source& source, const Grid& grid, double& fraction) {
  Soup thin;
  double area = 0.0, thinArea = 0.0;
  for (const Triangle& corners : source.triangles) {
    const TriangleCorners t = cornersOf(source.points, corners);
    const Vector3d vector = areaVector(t), normal = vector.normalized();
    area += vector.norm();
    if (thinSamples(grid, source.sizes.thickness, t, normal) < 2) continue;
    const Vector3d inward = -halfDepth(source, t, normal) * normal;
    thin.add(t[0] + inward, t[1] + inward, t[2] + inward);
    thinArea += vector.norm();
  }
  fraction = thinArea / area;
  return thin;
}

/// Returns whether the inside has gaps between its parts around an edge, at this distance (m) from it.
bool isPinched(const Grid& grid, const Vector3d& a, const Vector3d& b, double radius) {
  constexpr int kDirections = 16;
  const Vector3d u = (b - a).normalized().unitOrthogonal(), v = (b - a).normalized().cross(u);
  const auto inside = [&](int i) {
    const double angle = 2.0 * kPi * i / kDirections;
    return isInside(grid, 0.5 * (a + b) + radius * (std::cos(angle) * u + std::sin(angle) * v));
  };
  int entries = 0;
  for (int i = 0; i < kDirections; ++i) entries += inside(i) && !inside(i + 1) ? 1 : 0;
  return entries > 1;
}

/// Adds the edges in which solids touch, as triangles without area: there the solid has no thickness.
void addPinches(const Source& source, const Grid& grid, Soup& thin) {
  forEachEdge(source.triangles, [&](const Side* sides, std::size_t uses) {
    const Vector3d &a = source.points[sides->edge[0]], &b = source.points[sides->edge[1]];
    if (uses > 2 && isPinched(grid, a, b, 0.5 * source.sizes.thickness)) thin.add(a, b, b);
  });
}

// --- rods --------------------------------------------------------------------------------------------------

/// Largest number of places of a piece between which rods are looked for.
constexpr std::size_t kRodEnds = 64;

/// Returns places spread over each piece but the surfaces of hollows, which need no rod: it would end
/// outside.
std::vector<Points> rodEnds(const TriangleMesh& mesh) {
  std::vector<Points> ends;
  for (const Triangles& piece : trianglesOfPieces(mesh.positions.size(), mesh.triangles)) {
    if (signedVolume(mesh.positions, piece) <= 0.0) continue;
    ends.emplace_back();
    for (std::size_t t = 0; t < piece.size(); t += 1 + piece.size() / kRodEnds)
      ends.back().push_back(mesh.positions[piece[t][0]]);
  }
  return ends;
}

/// Two places (m), and their distance.
struct Gap {
  Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
  double distance = HUGE_VAL;
};

void shorten(Gap& gap, const Points& from, const Points& to) {
  for (const Vector3d& p : from)
    for (const Vector3d& q : to)
      if (const double distance = (p - q).norm(); distance < gap.distance) gap = {p, q, distance};
}

/// Returns rods along the shortest tree that joins the pieces (R. C. Prim, 1957), as triangles without area.
/// Their ends are inside the pieces.
Soup findRods(const TriangleMesh& mesh, double thickness) {
  const std::vector<Points> ends = rodEnds(mesh);
  std::vector<Gap> gaps(ends.size());  // from the pieces reached so far to each other one
  std::vector<char> reached(ends.size(), 0);
  Soup rods;
  std::size_t last = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    reached[last] = 1;
    std::size_t next = last;
    for (std::size_t piece = 0; piece < ends.size(); ++piece) {
      if (reached[piece]) continue;
      shorten(gaps[piece], ends[last], ends[piece]);
      if (next == last || gaps[piece].distance < gaps[next].distance) next = piece;
    }
    const Gap& gap = gaps[next];
    const Vector3d further = 0.5 * thickness * (gap.to - gap.from).normalized();
    rods.add(gap.from - further, gap.to + further, gap.to + further);
    last = next;
  }
  return rods;
}

// --- the whole ---------------------------------------------------------------------------------------------

/// Largest number of cells of the grid.
constexpr double kMaxCells = 1e7;

/// Meshes of more triangles are welded to a fraction of a cell first: finer details have no effect.
constexpr std::size_t kManyTriangles = 20000;
constexpr double kDetail = 0.25;  // cells

/// Returns the mesh as samples need it, or the reason why not.
Result<Source> makeSource(const TriangleMesh& mesh, WrapSettings settings) {
  Result<WeldedMesh> welded = weld(mesh);
  if (!welded) return Error{welded.error()};
  settings = withDefaults(settings, extent(welded->points));
  if (welded->triangles.size() > kManyTriangles)
    if (Result<WeldedMesh> coarser = weld(mesh, kDetail * settings.resolution)) welded = std::move(coarser);
  flip(welded->triangles, patchesFacingInward(welded->points, welded->triangles));
  TriangleBvh bvh(welded->points, welded->triangles);
  const bool isClosed = findEdgeDefects(welded->triangles).none();
  return Source{std::move(welded->points), std::move(welded->triangles), std::move(bvh), settings, isClosed};
}

/// Returns a grid with room for all changes around the mesh, or the reason why it is too large.
Result<Grid> makeGrid(const Source& source, const std::string& prefix) {
  const double margin = 0.5 * (source.sizes.thickness + source.sizes.join) + 2.0 * source.sizes.resolution;
  const Eigen::AlignedBox3d box = boxOf(source.points);
  const double cells = ((box.sizes().array() + 2.0 * margin) / source.sizes.resolution + 1.0).prod();
  if (!(cells <= kMaxCells))
    return Error{prefix + "resolution is " + inThreeDigits(source.sizes.resolution) +
                 " m, must be larger: it needs " + inThreeDigits(cells) + " cells, of " +
                 inThreeDigits(kMaxCells) + " at most"};
  Grid grid;
  grid.width = source.sizes.resolution;
  grid.nodes = ((box.sizes().array() + 2.0 * margin) / grid.width).ceil().cast<int>() + 1;
  grid.origin = box.center() - 0.5 * grid.width * (grid.nodes.array() - 1).matrix().cast<double>();
  grid.values.resize(grid.index(grid.nodes.array() - 1) + 1);
  return grid;
}

}  // namespace

WrapSettings withDefaults(WrapSettings settings, double extent) {
  constexpr double kCells = 64.0, kWidths = 2.0;  // along the longest side; of the other sizes
  if (!(settings.resolution > 0.0)) settings.resolution = extent / kCells;
  if (!(settings.thickness > 0.0)) settings.thickness = kWidths * settings.resolution;
  if (!(settings.join > 0.0)) settings.join = kWidths * settings.resolution;
  return settings;
}

std::string checkWrapSettings(const WrapSettings& s, const std::string& prefix) {
  const std::array<std::pair<const char*, double>, 3> all{
      {{"resolution", s.resolution}, {"thickness", s.thickness}, {"join", s.join}}};
  for (const auto& [name, value] : all)
    if (!std::isfinite(value) || value < 0.0)
      return prefix + name + " is " + inThreeDigits(value) + ", must be 0 or more";
  return {};
}

Result<WrappedMesh> wrap(const TriangleMesh& mesh, const WrapSettings& settings) {
  return wrapOfField(mesh, settings, "");
}

Result<WrappedMesh> wrapOfField(const TriangleMesh& mesh, const WrapSettings& settings,
                                const std::string& prefix, double crumb) {
  if (std::string reason = checkWrapSettings(settings, prefix); !reason.empty())
    return Error{std::move(reason)};
  const Result<Source> source = makeSource(mesh, settings);
  if (!source) return Error{source.error()};
  Result<Grid> grid = makeGrid(*source, prefix);
  if (!grid) return Error{grid.error()};
  WrappedMesh wrapped;
  wrapped.resolution = source->sizes.resolution;
  wrapped.thickness = source->sizes.thickness;
  wrapped.join = source->sizes.join;
  source->isClosed ? sampleClosed(*source, *grid) : sampleOpen(*source, *grid);
  distrustInsides(*grid);
  Soup thin = findThinParts(*source, *grid, wrapped.thinFraction);
  addPinches(*source, *grid, thin);
  thicken(thin, source->sizes.thickness, *grid);
  fillGaps(source->sizes.join, *grid);
  extractPieces(*grid, crumb, wrapped);
  if (settings.connect && wrapped.pieces > 1) {
    const Soup rods = findRods(wrapped.mesh, source->sizes.thickness);
    if (rods.triangles.empty()) return wrapped;
    thicken(rods, source->sizes.thickness, *grid);
    wrapped.rods = rods.triangles.size();
    extractPieces(*grid, crumb, wrapped);
  }
  if (wrapped.mesh.triangles.empty()) return Error{"the mesh has no extent that could be wrapped"};
  return wrapped;
}

}  // namespace limber

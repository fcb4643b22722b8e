// SPDX-License-Identifier: Zlib
#include "surface_net.h"

#include <cmath>
#include <cstddef>

namespace shapes {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr std::uint32_t kNone = 0xffffffffu;

struct Samples {
  CellGrid grid;
  std::vector<double> values;  ///< at the corners of the cells, x fastest

  Vector3d position(const Vector3i& node) const { return grid.low + grid.width * node.cast<double>(); }
  std::size_t index(const Vector3i& node) const {
    return static_cast<std::size_t>((node.z() * (grid.cells.y() + 1) + node.y()) * (grid.cells.x() + 1) +
                                    node.x());
  }
  double value(const Vector3i& node) const { return values[index(node)]; }
  bool isInside(const Vector3i& node) const { return value(node) < 0.0; }
};

template <class Visit>
void visitBox(const Vector3i& low, const Vector3i& high, Visit visit) {
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) visit(Vector3i(x, y, z));
    }
  }
}

Samples sample(const Field& field, const CellGrid& grid) {
  Samples samples{grid, {}};
  visitBox(Vector3i::Zero(), grid.cells,
           [&](const Vector3i& node) { samples.values.push_back(field(samples.position(node))); });
  return samples;
}

/// Where the surface crosses the grid edge, by linear interpolation.
Vector3d crossing(const Samples& samples, const Vector3i& from, const Vector3i& to) {
  const double a = samples.value(from), b = samples.value(to);
  return samples.position(from) + a / (a - b) * (samples.position(to) - samples.position(from));
}

/// A vertex in the middle of the crossings on the 12 edges of a cell, if there are any.
std::uint32_t addVertex(const Samples& samples, const Vector3i& cell, std::vector<Vector3d>& vertices) {
  Vector3d sum = Vector3d::Zero();
  int crossings = 0;
  visitBox(cell, cell + Vector3i::Ones(), [&](const Vector3i& node) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3i next = node + Vector3i::Unit(axis);
      if (next[axis] > cell[axis] + 1 || samples.isInside(node) == samples.isInside(next)) continue;
      sum += crossing(samples, node, next);
      ++crossings;
    }
  });
  if (crossings == 0) return kNone;
  vertices.push_back(sum / crossings);
  return static_cast<std::uint32_t>(vertices.size() - 1);
}

/// The quad through the four cells around the grid edge from `node` along `axis`.
void addQuadAround(const Samples& samples, const std::vector<std::uint32_t>& vertexOfCell,
                   const Vector3i& node, int axis, QuadMesh& mesh) {
  const bool inside = samples.isInside(node);
  if (inside == samples.isInside(node + Vector3i::Unit(axis))) return;
  const Vector3i u = Vector3i::Unit((axis + 1) % 3), v = Vector3i::Unit((axis + 2) % 3);
  const auto vertex = [&](const Vector3i& cell) { return vertexOfCell[samples.index(cell)]; };
  const std::uint32_t a = vertex(node - u - v), b = vertex(node - v), c = vertex(node), d = vertex(node - u);
  if (inside) {
    mesh.quads.push_back({a, b, c, d});
  } else {
    mesh.quads.push_back({d, c, b, a});
  }
}

/// The middle of each vertex's neighbours; every neighbour counts once for each quad it shares.
std::vector<Vector3d> neighbourMiddles(const QuadMesh& mesh) {
  std::vector<Vector3d> sums(mesh.vertices.size(), Vector3d::Zero());
  std::vector<int> counts(mesh.vertices.size(), 0);
  for (const auto& quad : mesh.quads) {
    for (std::size_t i = 0; i < 4; ++i) {
      sums[quad[i]] += mesh.vertices[quad[(i + 1) % 4]] + mesh.vertices[quad[(i + 3) % 4]];
      counts[quad[i]] += 2;
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] /= counts[i];
  return sums;
}

void addBestSplit(TriangleSoup& soup, const std::array<Corner, 4>& c, double equal) {
  const double ac = (c[0].position - c[2].position).norm(), bd = (c[1].position - c[3].position).norm();
  if (ac <= bd * (1.0 + equal)) {
    addQuad(soup, c[0], c[1], c[2], c[3]);
  } else {
    addQuad(soup, c[1], c[2], c[3], c[0]);
  }
}

}  // namespace

CellGrid gridAround(const Vector3d& low, const Vector3d& high, double width) {
  CellGrid grid{low, width, {}};
  for (int axis = 0; axis < 3; ++axis) {
    const int first = static_cast<int>(std::floor(low[axis] / width)) - 1;
    grid.low[axis] = first * width;
    grid.cells[axis] = static_cast<int>(std::ceil(high[axis] / width)) + 1 - first;
  }
  return grid;
}

QuadMesh buildSurfaceNet(const Field& field, const CellGrid& grid) {
  const Samples samples = sample(field, grid);
  QuadMesh mesh;
  std::vector<std::uint32_t> vertexOfCell(samples.values.size(), kNone);  // by the lowest corner of the cell
  visitBox(Vector3i::Zero(), grid.cells - Vector3i::Ones(), [&](const Vector3i& cell) {
    vertexOfCell[samples.index(cell)] = addVertex(samples, cell, mesh.vertices);
  });
  visitBox(Vector3i::Ones(), grid.cells - Vector3i::Ones(), [&](const Vector3i& node) {
    for (int axis = 0; axis < 3; ++axis) addQuadAround(samples, vertexOfCell, node, axis, mesh);
  });
  return mesh;
}

void relaxOnSurface(QuadMesh& mesh, const Field& field, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    const std::vector<Vector3d> middles = neighbourMiddles(mesh);
    for (std::size_t i = 0; i < middles.size(); ++i) {
      const Vector3d moved = (mesh.vertices[i] + middles[i]) / 2.0;
      mesh.vertices[i] = towardsSurface(field, towardsSurface(field, moved));
    }
  }
}

TriangleSoup makeBody(const Field& field, const Vector3d& low, const Vector3d& high, double width) {
  QuadMesh mesh = buildSurfaceNet(field, gridAround(low, high, width));
  relaxOnSurface(mesh, field, 3);
  return toSoup(mesh);
}

TriangleSoup toSoup(const QuadMesh& mesh, double equal) {
  TriangleSoup soup;
  for (const auto& quad : mesh.quads) {
    std::array<Corner, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = {mesh.vertices[quad[i]], {0.0, 0.0}};
    addBestSplit(soup, corners, equal);
  }
  return soup;
}

}  // namespace shapes

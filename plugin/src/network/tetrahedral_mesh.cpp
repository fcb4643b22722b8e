// SPDX-License-Identifier: Zlib
// Finds faces, neighbours, volumes and angles of tetrahedra, and makes the surface of a tetrahedral mesh a
// manifold.

#include "network/tetrahedra.h"

#include <tuple>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Returns the face opposite to a corner, counter-clockwise seen from outside.
Triangle faceOf(const Tetrahedron& t, std::size_t corner) {
  switch (corner) {
    case 0:
      return {t[1], t[2], t[3]};
    case 1:
      return {t[0], t[3], t[2]};
    case 2:
      return {t[0], t[1], t[3]};
    default:
      return {t[0], t[2], t[1]};
  }
}

/// A face by its corners in ascending order, and 4 x its tetrahedron + the opposite corner.
using Face = std::pair<Triangle, std::uint32_t>;

/// Returns all faces in ascending order: first by counts of the lowest corner, then a few at a time.
std::vector<Face> sortedFaces(const std::vector<Tetrahedron>& tetrahedra) {
  std::uint32_t points = 0;
  for (const Tetrahedron& t : tetrahedra)
    points = std::max(points, *std::max_element(t.begin(), t.end()) + 1);
  std::vector<std::uint32_t> end(points + 1, 0);  // of the faces of each lowest corner
  std::vector<Face> unsorted, faces;
  unsorted.reserve(4 * tetrahedra.size());
  for (std::uint32_t t = 0; t < tetrahedra.size(); ++t)
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      Triangle face = faceOf(tetrahedra[t], corner);
      std::sort(face.begin(), face.end());
      unsorted.emplace_back(face, 4 * t + corner);
      ++end[face[0] + 1];
    }
  std::partial_sum(end.begin(), end.end(), end.begin());
  faces.resize(unsorted.size());
  for (const Face& face : unsorted) faces[end[face.first[0]]++] = face;
  for (std::uint32_t i = 0, first = 0; i < points; first = end[i++])
    std::sort(faces.begin() + first, faces.begin() + end[i]);
  return faces;
}

}  // namespace

FaceNeighbours findFaceNeighbours(const std::vector<Tetrahedron>& tetrahedra) {
  const std::vector<Face> faces = sortedFaces(tetrahedra);
  FaceNeighbours neighbours(tetrahedra.size(), {kOutside, kOutside, kOutside, kOutside});
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (faces[i].first != faces[i - 1].first) continue;
    const std::uint32_t a = faces[i - 1].second, b = faces[i].second;
    neighbours[a / 4][a % 4] = b / 4;
    neighbours[b / 4][b % 4] = a / 4;
  }
  return neighbours;
}

std::vector<Triangle> surfaceOf(const std::vector<Tetrahedron>& tetrahedra,
                                const FaceNeighbours& neighbours) {
  std::vector<Triangle> surface;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t)
    for (std::size_t corner = 0; corner < 4; ++corner)
      if (neighbours[t][corner] == kOutside) surface.push_back(faceOf(tetrahedra[t], corner));
  return surface;
}

std::vector<Edge> uniqueEdges(const std::vector<Tetrahedron>& tetrahedra) {
  std::vector<Edge> edges;
  for (const Tetrahedron& t : tetrahedra)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) edges.push_back(edgeBetween(t[i], t[j]));
  sortUnique(edges);
  return edges;
}

double volumeOf(const std::vector<Vector3d>& points, const Tetrahedron& t) {
  const Vector3d& a = points[t[0]];
  return (points[t[1]] - a).dot((points[t[2]] - a).cross(points[t[3]] - a)) / 6.0;
}

double volumeOf(const std::vector<Vector3d>& points, const std::vector<Tetrahedron>& tetrahedra) {
  double volume = 0.0;
  for (const Tetrahedron& t : tetrahedra) volume += volumeOf(points, t);
  return volume;
}

DihedralAngles dihedralAngles(const std::vector<Vector3d>& points, const Tetrahedron& t) {
  std::array<Vector3d, 4> normals;
  for (std::size_t i = 0; i < 4; ++i) normals[i] = areaVector(points, faceOf(t, i)).normalized();
  DihedralAngles angles{3.2, 0.0};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double angle = std::acos(std::clamp(-normals[i].dot(normals[j]), -1.0, 1.0));
      angles.smallest = std::min(angles.smallest, angle);
      angles.largest = std::max(angles.largest, angle);
    }
  return angles;
}

namespace {

using Indices = std::vector<std::uint32_t>;

bool hasPoint(const Tetrahedron& t, std::uint32_t point) {
  return std::find(t.begin(), t.end(), point) != t.end();
}

/// Groups the `subset` (ascending) of tetrahedra: faces that contain all points of `hub` join them. Returns
/// for each one the first member of its group, as an index into `subset`.
Indices groupAround(const std::vector<Tetrahedron>& tetrahedra, const FaceNeighbours& neighbours,
                    const Indices& subset, const Indices& hub) {
  DisjointSets groups(subset.size());
  for (std::uint32_t i = 0; i < subset.size(); ++i)
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const std::uint32_t t = subset[i], other = neighbours[t][corner];
      const bool containsHub = std::find(hub.begin(), hub.end(), tetrahedra[t][corner]) == hub.end();
      const auto found = std::lower_bound(subset.begin(), subset.end(), other);
      if (containsHub && found != subset.end() && *found == other)
        groups.join(i, static_cast<std::uint32_t>(found - subset.begin()));
    }
  Indices firsts;
  for (std::uint32_t i = 0; i < subset.size(); ++i) firsts.push_back(groups.root(i));
  return firsts;
}

/// Returns the edges of more than two triangles of the surface.
std::vector<Edge> nonManifoldEdges(const std::vector<Triangle>& surface) {
  std::vector<Edge> nonManifold;
  forEachEdge(surface, [&](const Side* sides, std::size_t uses) {
    if (uses > 2) nonManifold.push_back(sides->edge);
  });
  return nonManifold;
}

void removeMarked(std::vector<Tetrahedron>& tetrahedra, const std::vector<char>& marked) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t)
    if (!marked[t]) tetrahedra[kept++] = tetrahedra[t];
  tetrahedra.resize(kept);
}

/// Marks all groups except the one of the largest volume.
void markSmaller(const TetrahedralMesh& mesh, const Indices& subset, const Indices& group,
                 std::vector<char>& marked) {
  std::vector<double> volume(subset.size(), 0.0);
  for (std::size_t i = 0; i < subset.size(); ++i)
    volume[group[i]] += volumeOf(mesh.points, mesh.tetrahedra[subset[i]]);
  const auto largest = std::max_element(volume.begin(), volume.end()) - volume.begin();
  for (std::size_t i = 0; i < subset.size(); ++i)
    if (group[i] != largest) marked[subset[i]] = 1;
}

/// Returns true if there was nothing to remove.
bool removeAtNonManifoldEdges(TetrahedralMesh& mesh) {
  const FaceNeighbours neighbours = findFaceNeighbours(mesh.tetrahedra);
  const std::vector<Edge> nonManifold = nonManifoldEdges(surfaceOf(mesh.tetrahedra, neighbours));
  if (nonManifold.empty()) return true;
  const std::vector<Indices> at = elementsOfPoints(mesh.points.size(), mesh.tetrahedra);
  std::vector<char> marked(mesh.tetrahedra.size(), 0);
  for (const Edge& edge : nonManifold) {
    Indices subset;
    for (const std::uint32_t t : at[edge[0]])
      if (hasPoint(mesh.tetrahedra[t], edge[1])) subset.push_back(t);
    markSmaller(mesh, subset, groupAround(mesh.tetrahedra, neighbours, subset, {edge[0], edge[1]}), marked);
  }
  removeMarked(mesh.tetrahedra, marked);
  return false;
}

void splitPoints(TetrahedralMesh& mesh) {
  const FaceNeighbours neighbours = findFaceNeighbours(mesh.tetrahedra);
  const std::vector<Indices> at = elementsOfPoints(mesh.points.size(), mesh.tetrahedra);
  for (std::uint32_t point = 0; point < at.size(); ++point) {
    const Indices group = groupAround(mesh.tetrahedra, neighbours, at[point], {point});
    for (std::uint32_t first = 1; first < group.size(); ++first) {
      if (group[first] != first) continue;
      for (std::size_t i = first; i < group.size(); ++i) {
        Tetrahedron& t = mesh.tetrahedra[at[point][i]];
        if (group[i] == first)
          std::replace(t.begin(), t.end(), point, static_cast<std::uint32_t>(mesh.points.size()));
      }
      mesh.points.push_back(mesh.points[point]);
    }
  }
}

void removeSmallPieces(TetrahedralMesh& mesh, double minVolume) {
  const Indices piece = findPieces(mesh.tetrahedra);
  std::vector<double> volume(piece.size(), 0.0);
  for (std::size_t t = 0; t < piece.size(); ++t)
    volume[piece[t]] += volumeOf(mesh.points, mesh.tetrahedra[t]);
  std::vector<char> marked(piece.size(), 0);
  for (std::size_t t = 0; t < piece.size(); ++t) marked[t] = volume[piece[t]] < minVolume;
  removeMarked(mesh.tetrahedra, marked);
}

void dropUnusedPoints(TetrahedralMesh& mesh) {
  Renumbering numbers(mesh.points.size());
  for (const std::uint32_t point : usedPoints(mesh.points.size(), mesh.tetrahedra)) numbers(point);
  mesh.points = chosen(mesh.points, numbers.kept());
  for (Tetrahedron& t : mesh.tetrahedra) t = numbers(t);
}

}  // namespace

std::vector<std::uint32_t> findPieces(const std::vector<Tetrahedron>& tetrahedra) {
  const FaceNeighbours neighbours = findFaceNeighbours(tetrahedra);
  DisjointSets sets(tetrahedra.size());
  for (std::uint32_t t = 0; t < tetrahedra.size(); ++t)
    for (const std::uint32_t other : neighbours[t])
      if (other != kOutside) sets.join(t, other);
  Renumbering numbers(tetrahedra.size());
  Indices piece;
  for (std::uint32_t t = 0; t < tetrahedra.size(); ++t) piece.push_back(numbers(sets.root(t)));
  return piece;
}

void separatePoints(TetrahedralMesh& mesh) {
  constexpr double kMoved = 0.05;  // of the way to the middle of the tetrahedra
  const std::vector<Vector3d> places = mesh.points;
  const std::vector<Indices> at = elementsOfPoints(places.size(), mesh.tetrahedra);
  Indices order(places.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t i) {
    return std::make_tuple(places[i].x(), places[i].y(), places[i].z());
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  const auto isSame = [&](std::size_t i, std::size_t j) { return places[order[i]] == places[order[j]]; };
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (!(i + 1 < order.size() && isSame(i, i + 1)) && !(i > 0 && isSame(i, i - 1))) continue;
    const std::uint32_t point = order[i];
    Vector3d sum = Vector3d::Zero();
    for (const std::uint32_t t : at[point])
      for (const std::uint32_t corner : mesh.tetrahedra[t]) sum += 0.25 * (places[corner] - places[point]);
    mesh.points[point] += kMoved / static_cast<double>(at[point].size()) * sum;
  }
}

void makeManifold(TetrahedralMesh& mesh, double minVolume) {
  while (!removeAtNonManifoldEdges(mesh)) {
  }
  removeSmallPieces(mesh, minVolume);
  splitPoints(mesh);
  dropUnusedPoints(mesh);
  mesh.surface = surfaceOf(mesh.tetrahedra, findFaceNeighbours(mesh.tetrahedra));
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "cook/tetrahedra.h"

#include "cook/lattice_cut.h"
#include "cook/lattice_fill.h"
#include "cook/solid_surface.h"
#include "cook/surface_fit.h"
#include "cook/tetrahedra_repair.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Sites at most: their arrays take about 60 bytes each.
constexpr double kMostSites = 4e6;

/// A part of the body with less than this share of a piece's volume is a crumb that may go.
constexpr double kCrumb = 0.01;

/// The least stretching of the lattice along an axis: flat lattices have sharp angles.
constexpr double kLeastStretch = 0.8;

/// Whole cells across the box wherever that stretches them little, so that flat sides of boxes lie in the
/// lattice.
BccLattice placeLattice(const Eigen::AlignedBox3d& box, double spacing) {
  BccLattice lattice;
  for (int i = 0; i < 3; ++i) {
    const double extent = box.sizes()[i], across = std::max(1.0, std::round(extent / spacing));
    lattice.spacing[i] = std::max(extent / across, kLeastStretch * spacing);
    lattice.cells[i] = static_cast<int>(across) + 5;
    lattice.origin[i] = box.center()[i] - (0.5 * across + 2.0) * lattice.spacing[i];
  }
  return lattice;
}

double sitesNeeded(const Eigen::AlignedBox3d& box, double spacing) {
  return 2.0 * (box.sizes().array() / spacing + 6.0).prod();
}

TetrahedralMesh stuff(const SolidSurface& surface, double spacing) {
  TetrahedralMesh mesh = fillLattice(cutLattice(placeLattice(surface.box, spacing), surface.bvh));
  makeManifold(mesh, kCrumb * surface.volume / static_cast<double>(surface.pieces));
  return mesh;
}

/// How many points of the surface of each part of the body lie next to each piece of the given surface,
/// #parts x #pieces.
Eigen::MatrixXi countEncounters(const TetrahedralMesh& mesh, const SolidSurface& surface) {
  const std::vector<std::uint32_t> partOfTetrahedron = findPieces(mesh.tetrahedra);
  std::vector<std::uint32_t> partOfPoint(mesh.points.size());
  std::uint32_t parts = 0;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    parts = std::max(parts, partOfTetrahedron[t] + 1);
    for (const std::uint32_t point : mesh.tetrahedra[t]) partOfPoint[point] = partOfTetrahedron[t];
  }
  Eigen::MatrixXi count = Eigen::MatrixXi::Zero(parts, static_cast<Eigen::Index>(surface.pieces));
  for (const Triangle& t : mesh.surface)
    for (const std::uint32_t point : t)
      ++count(partOfPoint[point], surface.pieceOfTriangle[surface.bvh.nearest(mesh.points[point]).triangle]);
  return count;
}

/// Whether the inside is on both sides of the piece, so that it is no part of the body's surface.
bool isBuried(const SolidSurface& surface, std::uint32_t piece) {
  const double step = 1e-4 * surface.box.diagonal().norm();
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (surface.pieceOfTriangle[t] == piece &&
        !surface.bvh.inside(surface.centroids[t] + step * surface.normals[t]))
      return false;
  return true;
}

/// What of the mesh the tetrahedra fail to stand for, or an empty string.
std::string findLoss(const TetrahedralMesh& mesh, const SolidSurface& surface) {
  if (mesh.tetrahedra.empty()) return "the whole mesh is missed";
  const Eigen::MatrixXi count = countEncounters(mesh, surface);
  for (std::uint32_t piece = 0; piece < surface.pieces; ++piece)
    if (count.col(piece).maxCoeff() == 0 && !isBuried(surface, piece))
      return "piece " + std::to_string(piece) + " of the mesh is missed";
  std::vector<Eigen::Index> mainPart(surface.pieces, -1);
  for (Eigen::Index part = 0; part < count.rows(); ++part) {
    Eigen::Index piece = 0;
    count.row(part).maxCoeff(&piece);
    Eigen::Index& known = mainPart[static_cast<std::size_t>(piece)];
    if (known >= 0) return "piece " + std::to_string(piece) + " of the mesh falls apart";
    known = part;
  }
  return {};
}

std::string say(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

Result<TetrahedralMesh> finish(TetrahedralMesh mesh, const SolidSurface& surface, double spacing) {
  if (const std::string loss = findLoss(mesh, surface); !loss.empty())
    return Error{loss + ": it is thinner than a lattice of " + say(spacing) +
                 " m can follow, or oriented inward; take a smaller spacing or more points"};
  fitSurface(mesh, surface);
  return mesh;
}

}  // namespace

Result<TetrahedralMesh> fillWithTetrahedra(const WeldedMesh& mesh, double spacing) {
  if (std::string reason = whyNotSolid(mesh.report); !reason.empty()) return Error{std::move(reason)};
  if (!std::isfinite(spacing) || spacing <= 0.0)
    return Error{"the spacing is " + say(spacing) + ", it must be above 0"};
  const SolidSurface surface = makeSolidSurface(mesh);
  if (const double sites = sitesNeeded(surface.box, spacing); sites > kMostSites)
    return Error{"the spacing of " + say(spacing) + " m needs a lattice of " + say(sites) +
                 " sites, it may have " + say(kMostSites)};
  return finish(stuff(surface, spacing), surface, spacing);
}

Result<TetrahedralMesh> fillWithPoints(const WeldedMesh& mesh, std::size_t points) {
  if (std::string reason = whyNotSolid(mesh.report); !reason.empty()) return Error{std::move(reason)};
  if (points < 8) return Error{std::to_string(points) + " points are too few, there must be 8 or more"};
  const SolidSurface surface = makeSolidSurface(mesh);
  const auto wanted = static_cast<double>(points);
  // two sites per cube of the lattice; the surface adds to them, by a power between 2 and 3 of the spacing
  double spacing = std::cbrt(3.0 * surface.volume / wanted), bestSpacing = 0.0, bestMiss = 0.0;
  TetrahedralMesh best;
  for (int trial = 0; trial < 10; ++trial) {
    if (sitesNeeded(surface.box, spacing) > kMostSites) break;
    TetrahedralMesh mesh_ = stuff(surface, spacing);
    const double got = std::max<double>(1.0, static_cast<double>(mesh_.points.size()));
    const double miss = std::abs(std::log(got / wanted));
    if (best.points.empty() || miss < bestMiss) {
      best = std::move(mesh_);
      bestMiss = miss;
      bestSpacing = spacing;
    }
    if (miss < 0.03) break;
    spacing *= std::pow(got / wanted, 1.0 / 2.6);
  }
  return finish(std::move(best), surface, bestSpacing);
}

}  // namespace limber

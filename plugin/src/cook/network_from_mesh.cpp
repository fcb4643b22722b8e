// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>

#include "cook/bracing.h"
#include "cook/equal_length_braces.h"
#include "cook/mass_shares.h"
#include "cook/two_ring_braces.h"
#include "mesh/edges.h"
#include "mesh/surface.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

namespace limber {
namespace {

constexpr std::uint32_t kInNoPiece = 0xffffffffu;

std::string checkSettings(const NetworkSettings& s) {
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!finite(s.braceWeight) || s.braceWeight < 0.0)
    return "braceWeight is " + std::to_string(s.braceWeight) + ", must be above 0, or 0 for the rule's own";
  if (!finite(s.mostBraces) || s.mostBraces <= 0.0)
    return "mostBraces is " + std::to_string(s.mostBraces) + ", must be above 0";
  if (!finite(s.mostSeconds) || s.mostSeconds < 0.0)
    return "mostSeconds is " + std::to_string(s.mostSeconds) + ", must be 0 or more";
  if (s.braces > BraceRule::Pipeline) return "braces is none of the rules";
  if (s.masses > MassRule::Moments) return "masses is none of the rules";
  return {};
}

double weightOf(const NetworkSettings& settings) {
  if (settings.braceWeight > 0.0) return settings.braceWeight;
  return settings.braces == BraceRule::Pipeline ? kPipelineWeight : 1.0;
}

/// A component, and which point of the mesh each of its points is, ascending.
struct Piece {
  PieceToBrace shape;
  std::vector<std::uint32_t> points;
};

std::vector<Piece> splitIntoPieces(const WeldedMesh& welded) {
  const SurfaceComponents components = findComponents(welded.points.size(), welded.triangles);
  std::vector<std::uint32_t> pieceOf(welded.points.size(), kInNoPiece), index(welded.points.size());
  for (std::size_t t = 0; t < welded.triangles.size(); ++t)
    for (const std::uint32_t corner : welded.triangles[t]) pieceOf[corner] = components.ofTriangle[t];
  std::vector<Piece> pieces(components.count);
  for (std::uint32_t i = 0; i < welded.points.size(); ++i) {
    if (pieceOf[i] == kInNoPiece) continue;
    Piece& piece = pieces[pieceOf[i]];
    index[i] = static_cast<std::uint32_t>(piece.points.size());
    piece.points.push_back(i);
    piece.shape.points.push_back(welded.points[i]);
  }
  for (std::size_t t = 0; t < welded.triangles.size(); ++t) {
    const Triangle& corners = welded.triangles[t];
    pieces[components.ofTriangle[t]].shape.triangles.push_back(
        {index[corners[0]], index[corners[1]], index[corners[2]]});
  }
  return pieces;
}

void describeEdges(PieceToBrace& shape) {
  shape.edges = uniqueEdges(shape.triangles);
  const EdgeDefects defects = findEdgeDefects(shape.triangles);
  shape.closed = defects.open == 0 && defects.nonManifold == 0 && defects.inconsistent == 0;
}

/// Asks progress and clock whether to go on; once not, never again.
Progress impatient(const NetworkSettings& settings) {
  using Clock = std::chrono::steady_clock;
  return [&settings, begin = Clock::now(), going = true](const char* what, double done) mutable {
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    going = going && (settings.mostSeconds == 0.0 || seconds < settings.mostSeconds) &&
            (!settings.progress || settings.progress(what, done));
    return going;
  };
}

std::vector<Edge> findBraces(const PieceToBrace& shape, const NetworkSettings& settings,
                             const Progress& goOn) {
  switch (settings.braces) {
    case BraceRule::None:
      return {};
    case BraceRule::EqualLength:
      return findEqualLengthPairs(shape.points, shape.edges);
    case BraceRule::TwoRing:
      return findTwoRingPairs(shape.points.size(), shape.edges);
    case BraceRule::Pipeline:
      return bracePiece(shape, {weightOf(settings), settings.mostBraces, settings.seed}, goOn);
  }
  return {};
}

void addSprings(const Piece& piece, const std::vector<Edge>& pairs, SpringKind kind, double stiffnessScale,
                std::vector<NetworkSpring>& springs) {
  for (const Edge& pair : pairs)
    springs.push_back({piece.points[pair[0]], piece.points[pair[1]], kind, stiffnessScale});
}

/// The edges and, within each component, braces.
std::vector<NetworkSpring> connect(const WeldedMesh& welded, const NetworkSettings& settings) {
  std::vector<NetworkSpring> springs;
  const Progress goOn = impatient(settings);
  for (Piece& piece : splitIntoPieces(welded)) {
    describeEdges(piece.shape);
    addSprings(piece, piece.shape.edges, SpringKind::Structural, 1.0, springs);
    addSprings(piece, findBraces(piece.shape, settings, goOn), SpringKind::Brace, weightOf(settings),
               springs);
  }
  std::sort(springs.begin(), springs.end(), [](const NetworkSpring& s, const NetworkSpring& t) {
    return s.a != t.a ? s.a < t.a : s.b < t.b;
  });
  return springs;
}

RenderSurface makeRenderSurface(const TriangleMesh& mesh, const WeldedMesh& welded) {
  RenderSurface render;
  render.vertexToPoint = welded.vertexToPoint;
  render.uvs = mesh.uvs;
  render.triangles.reserve(welded.keptTriangles.size());
  for (const std::uint32_t kept : welded.keptTriangles) render.triangles.push_back(mesh.triangles[kept]);
  return render;
}

}  // namespace

Result<SharedNetwork> buildNetwork(const TriangleMesh& mesh, const NetworkSettings& settings) {
  const std::string reason = checkSettings(settings);
  if (!reason.empty()) return Error{reason};
  Result<WeldedMesh> welded = weld(mesh, settings.weldTolerance);
  if (!welded) return Error{welded.error()};

  const std::vector<bool> inward = facingInward(welded->points, welded->triangles);
  turn(welded->triangles, inward);
  auto network = std::make_shared<SpringNetwork>();
  network->kind = NetworkKind::Solid;
  network->springs = connect(*welded, settings);
  network->massShares = shareMass(settings.masses, welded->points, welded->triangles).shares;
  network->render = makeRenderSurface(mesh, *welded);
  turn(network->render.triangles, inward);
  network->report = welded->report;
  network->restPoints = std::move(welded->points);
  network->surface = std::move(welded->triangles);
  return SharedNetwork(std::move(network));
}

}  // namespace limber

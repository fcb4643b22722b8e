// SPDX-License-Identifier: Zlib
#include "cook/bracing.h"

#include "cook/antipodal_braces.h"
#include "cook/counterexample_braces.h"
#include "cook/soft_mode_braces.h"
#include "cook/triangle_geometry.h"
#include "cook/two_ring_braces.h"
#include "solver/linear_algebra.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// Thickness over size below which a piece counts as flat.
constexpr double kFlatPiece = 1e-3;

/// Chords per point below which an open piece counts as without an inside.
constexpr double kLeastChords = 0.125;

/// Of the braces that a piece may get: what soft modes may take of them. Thin rods stay soft whatever they
/// get, and would have none left for what large deformations do to them.
constexpr double kShareForModes = 0.75;
constexpr double kRounding = 1e-6;  // 0.7 x 90 springs are 63, not 62

/// Root mean square distance from the best plane over that from the centre.
double thickness(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) centre += p / static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) covariance += (p - centre) * (p - centre).transpose();
  const double trace = covariance.trace();
  return trace > 0.0 ? std::sqrt(std::max(0.0, symmetricParts3(covariance).values[0]) / trace) : 0.0;
}

/// A piece that bounds a hollow comes facing into it.
SpringNetwork bareNetwork(const PieceToBrace& piece) {
  SpringNetwork network;
  network.restPoints = piece.points;
  network.surface = piece.triangles;
  if (signedVolume(piece.points, piece.triangles) < 0.0)
    for (Triangle& t : network.surface) std::swap(t[1], t[2]);
  for (const Edge& e : piece.edges) network.springs.push_back({e[0], e[1], SpringKind::Structural, 1.0});
  return network;
}

GoOn during(const char* what, const Progress& goOn) {
  return [&goOn, what](double done) { return goOn(what, done); };
}

}  // namespace

std::vector<Edge> bracePiece(const PieceToBrace& piece, const BracingSettings& settings,
                             const Progress& goOn) {
  const std::size_t points = piece.points.size();
  if (thickness(piece.points) < kFlatPiece) return findTwoRingPairs(points, piece.edges);
  if (!goOn("bracing: chords", 0.0)) return {};
  SpringNetwork network = bareNetwork(piece);
  InsideChords chords(network.restPoints, network.surface, piece.edges);
  const double pairs = 0.5 * static_cast<double>(points) * static_cast<double>(points - 1);
  const double most = std::min(settings.mostBraces * static_cast<double>(points) + kRounding, pairs);
  BracedPiece braced{
      std::move(network), std::move(chords), settings.weight, static_cast<std::size_t>(most), {}};
  addAntipodalBraces(braced);
  const bool hollow = static_cast<double>(braced.braces.size()) < kLeastChords * static_cast<double>(points);
  if (hollow && !piece.closed) return findTwoRingPairs(points, piece.edges);
  const auto forModes = static_cast<std::size_t>(kShareForModes * most);
  addSoftModeBraces(braced, forModes, settings.seed, during("bracing: soft modes", goOn));
  addCounterexampleBraces(braced, settings.seed, during("bracing: wrong shapes", goOn));
  std::sort(braced.braces.begin(), braced.braces.end());
  return braced.braces;
}

}  // namespace limber

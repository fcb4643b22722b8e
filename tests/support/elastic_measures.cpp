// SPDX-License-Identifier: Zlib
#include "support/elastic_measures.h"

#include "network/masses.h"

#include <Eigen/Geometry>

#include <vector>

namespace limber::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

std::vector<Vector3d> asVector(const MatrixXd& points) {
  std::vector<Vector3d> result;
  for (Index i = 0; i < points.cols(); ++i) result.push_back(points.col(i));
  return result;
}

Vector3d twiceAreaVector(const MatrixXd& points, const Triangle& t) {
  const Vector3d a = points.col(t[0]), b = points.col(t[1]), c = points.col(t[2]);
  return (b - a).cross(c - a);
}

/// The part of the surface within a distance from a position: each point's fraction of its area, and the
/// area-weighted mean of the points.
struct Patch {
  Eigen::VectorXd share;
  Vector3d middle = Vector3d::Zero();
};

Patch findPatch(const std::vector<Triangle>& surface, const MatrixXd& points, const Vector3d& position,
                double radius) {
  Patch patch{Eigen::VectorXd::Zero(points.cols())};
  for (const Triangle& t : surface)
    for (const std::uint32_t corner : t)
      if ((points.col(corner) - position).norm() <= radius)
        patch.share[corner] += twiceAreaVector(points, t).norm();
  if (patch.share.sum() > 0.0) patch.share /= patch.share.sum();
  patch.middle = points * patch.share;
  return patch;
}

/// Adds the tractions s_aa along axis `along`, growing along axis `across`, integrated against linear shape
/// functions. The force of a corner is area / 12 times the sum of the stresses at all corners, where its own
/// stress counts twice.
void addTractions(const MatrixXd& points, const Triangle& t, const Vector3d& centre, Index along,
                  Index across, Eigen::Ref<Eigen::VectorXd> forces) {
  const Vector3d u = points.col(t[1]) - points.col(t[0]), v = points.col(t[2]) - points.col(t[0]);
  const double area = u.cross(v)[along] / 2.0;
  double sum = 0.0;
  for (const std::uint32_t corner : t) sum += points(across, corner) - centre[across];
  for (const std::uint32_t corner : t)
    forces[3 * Index(corner) + along] += area / 12.0 * (sum + points(across, corner) - centre[across]);
}

}  // namespace

double openingStiffness(const ElasticBody& body, const Vector3d& positionA, const Vector3d& positionB,
                        double radius) {
  const LinearResponse response(body);
  const Patch a = findPatch(body.network.surface, response.points(), positionA, radius);
  const Patch b = findPatch(body.network.surface, response.points(), positionB, radius);
  const Vector3d apart = (b.middle - a.middle).normalized();
  if (a.share.sum() == 0.0 || b.share.sum() == 0.0 || apart.norm() == 0.0) return 0.0;
  const MatrixXd force = (apart * (b.share - a.share).transpose()).reshaped();
  return 1.0 / force.col(0).dot(response.displacements(force).col(0));
}

std::array<double, 6> measureBendingModuli(const ElasticBody& body) {
  const LinearResponse response(body);
  const MatrixXd& points = response.points();
  const SolidMoments solid = solidMoments(asVector(points), body.network.surface);
  MatrixXd forces = MatrixXd::Zero(points.size(), 6);
  const auto axes = [](Index load) { return std::array<Index, 2>{load / 2, (load / 2 + 1 + load % 2) % 3}; };
  for (Index load = 0; load < 6; ++load)
    for (const Triangle& t : body.network.surface)
      addTractions(points, t, solid.centre, axes(load)[0], axes(load)[1], forces.col(load));
  const MatrixXd u = response.displacements(forces);
  std::array<double, 6> moduli{};
  for (Index load = 0; load < 6; ++load)
    moduli[std::size_t(load)] =
        solid.volume * solid.second(axes(load)[1], axes(load)[1]) / forces.col(load).dot(u.col(load));
  return moduli;
}

}  // namespace limber::test

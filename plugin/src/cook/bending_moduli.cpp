// SPDX-License-Identifier: Zlib
#include "cook/bending_moduli.h"

#include "cook/linear_response.h"
#include "cook/solid_moments.h"

#include <Eigen/Geometry>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// The tractions s_aa along axis `along`, growing along axis `across`, integrated against linear shape
/// functions: for a corner, area / 12 times the sum of the corners' stresses and its own once more.
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

std::array<double, 6> measureBendingModuli(const ElasticBody& body) {
  const LinearResponse response(body);
  const MatrixXd& points = response.points();
  const SolidMoments solid = solidMoments(points, body.network.surface);
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

}  // namespace limber

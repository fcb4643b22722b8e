// SPDX-License-Identifier: Zlib
#include "cook/elastic_moduli.h"

#include "cook/linear_response.h"
#include "solver/linear_algebra.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr int kDirections = 40;

/// Evenly over a half sphere, by the golden angle.
Vector3d direction(int i) {
  const double z = (i + 0.5) / kDirections, radius = std::sqrt(1.0 - z * z);
  const double angle = i * 3.14159265358979323846 * (3.0 - std::sqrt(5.0));
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

/// The uniform stresses xx, yy, zz, yz, xz, xy of 1 Pa.
Matrix3d unitStress(int i) {
  Matrix3d stress = Matrix3d::Zero();
  const int a = i < 3 ? i : (i - 2) % 3, b = i < 3 ? i : (i - 1) % 3;
  stress(a, b) = stress(b, a) = 1.0;
  return stress;
}

/// What of each unit stress the stress d d^T has.
std::array<double, 6> uniaxial(const Vector3d& d) {
  return {d[0] * d[0], d[1] * d[1], d[2] * d[2], d[1] * d[2], d[2] * d[0], d[0] * d[1]};
}

/// Twice the area vector.
Vector3d areaVector(const MatrixXd& points, const Triangle& t) {
  const Vector3d a = points.col(t[0]), b = points.col(t[1]), c = points.col(t[2]);
  return (b - a).cross(c - a);
}

/// The mean strain under each unit stress.
std::array<Matrix3d, 6> meanStrains(const ElasticBody& body) {
  const LinearResponse response(body);
  const MatrixXd& points = response.points();
  MatrixXd forces = MatrixXd::Zero(points.size(), 6);
  double volume = 0.0;
  for (const Triangle& t : body.network.surface) {
    const Vector3d area = areaVector(points, t) / 2.0;
    volume += area.dot(points.col(t[0])) / 3.0;
    for (int load = 0; load < 6; ++load)
      for (const std::uint32_t corner : t)
        forces.block<3, 1>(3 * corner, load) += unitStress(load) * area / 3.0;
  }
  const MatrixXd u = response.displacements(forces);
  std::array<Matrix3d, 6> strains;
  for (int load = 0; load < 6; ++load) {
    Matrix3d sum = Matrix3d::Zero();
    for (const Triangle& t : body.network.surface)
      for (const std::uint32_t corner : t)
        sum += u.block<3, 1>(3 * corner, load) * areaVector(points, t).transpose() / 6.0;
    strains[static_cast<std::size_t>(load)] = (sum + sum.transpose()) / (2.0 * volume);
  }
  return strains;
}

Eigen::Matrix<double, 6, 6> elasticityOf(const std::array<Matrix3d, 6>& strains) {
  Eigen::Matrix<double, 6, 6> compliance;
  for (int load = 0; load < 6; ++load) {
    const Matrix3d& s = strains[static_cast<std::size_t>(load)];
    compliance.col(load) << s(0, 0), s(1, 1), s(2, 2), 2.0 * s(1, 2), 2.0 * s(2, 0), 2.0 * s(0, 1);
  }
  return LuFactor(compliance).inverse();
}

/// The surface within reach of a place: each point's share of its area, and its middle.
struct Patch {
  Eigen::VectorXd share;
  Vector3d middle = Vector3d::Zero();
};

Patch findPatch(const std::vector<Triangle>& surface, const MatrixXd& points, const Vector3d& place,
                double reach) {
  Patch patch{Eigen::VectorXd::Zero(points.cols())};
  for (const Triangle& t : surface)
    for (const std::uint32_t corner : t)
      if ((points.col(corner) - place).norm() <= reach) patch.share[corner] += areaVector(points, t).norm();
  if (patch.share.sum() > 0.0) patch.share /= patch.share.sum();
  patch.middle = points * patch.share;
  return patch;
}

}  // namespace

ElasticModuli measureModuli(const ElasticBody& body) {
  const std::array<Matrix3d, 6> strains =
      meanStrains({body.network, body.stiffness, body.volumeModulus, body.scale.cwiseAbs()});
  ElasticModuli moduli;
  for (int i = 0; i < kDirections; ++i) {
    const Vector3d d = direction(i);
    const std::array<double, 6> part = uniaxial(d);
    Matrix3d strain = Matrix3d::Zero();
    for (std::size_t load = 0; load < 6; ++load) strain += part[load] * strains[load];
    const double along = d.dot(strain * d);
    moduli.youngsModuli.push_back(1.0 / along);
    moduli.youngsModulus += 1.0 / (along * kDirections);
    moduli.poissonRatio += 0.5 * (along - strain.trace()) / (along * kDirections);
  }
  const auto [least, most] = std::minmax_element(moduli.youngsModuli.begin(), moduli.youngsModuli.end());
  moduli.isotropy = *least / *most;
  moduli.bulkModulus = 1.0 / (strains[0] + strains[1] + strains[2]).trace();
  moduli.elasticity = elasticityOf(strains);
  return moduli;
}

double openingStiffness(const ElasticBody& body, const Vector3d& placeA, const Vector3d& placeB,
                        double reach) {
  const LinearResponse response(body);
  const Patch a = findPatch(body.network.surface, response.points(), placeA, reach);
  const Patch b = findPatch(body.network.surface, response.points(), placeB, reach);
  const Vector3d apart = (b.middle - a.middle).normalized();
  if (a.share.sum() == 0.0 || b.share.sum() == 0.0 || apart.norm() == 0.0) return 0.0;
  const MatrixXd force = (apart * (b.share - a.share).transpose()).reshaped();
  return 1.0 / force.col(0).dot(response.displacements(force).col(0));
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "support/elastic_measures.h"

#include "mesh/linear_algebra.h"
#include "network/masses.h"

#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <vector>

namespace limber::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

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

MatrixXd asMatrix(const std::vector<Vector3d>& points) {
  return Eigen::Map<const MatrixXd>(points.front().data(), 3, static_cast<Index>(points.size()));
}

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

}  // namespace

double openingStiffness(const ElasticBody& body, const Vector3d& positionA, const Vector3d& positionB,
                        double radius) {
  const LinearResponse response(body);
  const MatrixXd points = asMatrix(response.points());
  const Patch a = findPatch(body.network.surface, points, positionA, radius);
  const Patch b = findPatch(body.network.surface, points, positionB, radius);
  const Vector3d apart = (b.middle - a.middle).normalized();
  if (a.share.sum() == 0.0 || b.share.sum() == 0.0 || apart.norm() == 0.0) return 0.0;
  const MatrixXd force = (apart * (b.share - a.share).transpose()).reshaped();
  return 1.0 / force.col(0).dot(response.displacements(force).col(0));
}

TriangleMesh boxMesh(const Vector3d& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back(
        Vector3d(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5).cwiseProduct(size));
  constexpr std::uint32_t kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                          {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& f : kFaces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

namespace {

/// A linear map from the position to a traction on the ends (for an area that faces +x), or a displacement.
using Field = std::function<Vector3d(const Vector3d&)>;

Eigen::VectorXd endForces(const ElasticBody& body, const MatrixXd& points, const Field& traction) {
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(points.size());
  for (const Triangle& t : body.network.surface) {
    const double area = twiceAreaVector(points, t).x() / 2.0;
    Vector3d sum = Vector3d::Zero();
    for (const std::uint32_t corner : t) sum += traction(points.col(corner));
    for (const std::uint32_t corner : t)
      forces.segment<3>(3 * Index(corner)) += area / 12.0 * (sum + traction(points.col(corner)));
  }
  return forces;
}

/// Returns the factor of the field that, with a rigid motion, is nearest to the displacements of the beam's
/// middle half.
double factorOf(const Field& field, const MatrixXd& points, const Eigen::VectorXd& displacements) {
  const double half = points.row(0).maxCoeff() / 2.0;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(7, 7), right = Eigen::MatrixXd::Zero(7, 1);
  for (Index i = 0; i < points.cols(); ++i) {
    const Vector3d p = points.col(i);
    if (std::abs(p.x()) > 1.0001 * half) continue;
    Eigen::Matrix<double, 3, 7> row;
    row << field(p), Eigen::Matrix3d::Identity(), Vector3d::UnitX().cross(p), Vector3d::UnitY().cross(p),
        Vector3d::UnitZ().cross(p);
    normal += row.transpose() * row;
    right += row.transpose() * displacements.segment<3>(3 * i);
  }
  solveSmall(normal, right);
  return right(0, 0);
}

}  // namespace

BeamModuli measureBeam(const ElasticBody& body) {
  const LinearResponse response(body);
  const MatrixXd points = asMatrix(response.points());
  MatrixXd forces(points.size(), 4);
  forces.col(0) = endForces(body, points, [](const Vector3d&) { return Vector3d(1.0, 0.0, 0.0); });
  forces.col(1) = endForces(body, points, [](const Vector3d& p) { return Vector3d(p.y(), 0.0, 0.0); });
  forces.col(2) = endForces(body, points, [](const Vector3d& p) { return Vector3d(p.z(), 0.0, 0.0); });
  forces.col(3) = endForces(body, points, [](const Vector3d& p) { return Vector3d(0.0, -p.z(), p.y()); });
  const MatrixXd u = response.displacements(forces);
  const double stretch =
      factorOf([](const Vector3d& p) { return Vector3d(p.x(), -p.y() / 4, -p.z() / 4); }, points, u.col(0));
  // a beam under  s_xx = y  has the displacements  x y, -(x^2 + (y^2 - z^2) / 4) / 2, -y z / 4,  over E
  const auto bend = [](double x, double y, double z) { return -(x * x + (y * y - z * z) / 4) / 2; };
  const double alongY = factorOf(
      [&](const Vector3d& p) {
        return Vector3d(p.x() * p.y(), bend(p.x(), p.y(), p.z()), -p.y() * p.z() / 4);
      },
      points, u.col(1));
  const double alongZ = factorOf(
      [&](const Vector3d& p) {
        return Vector3d(p.x() * p.z(), -p.y() * p.z() / 4, bend(p.x(), p.z(), p.y()));
      },
      points, u.col(2));
  const double twist = factorOf(
      [](const Vector3d& p) { return Vector3d(0.0, -p.x() * p.z(), p.x() * p.y()); }, points, u.col(3));
  // the torque of the shear stresses is that of the polar moment a^4 / 6
  return {1.0 / stretch, 0.5 / alongY + 0.5 / alongZ, 2.5 / (6.0 * 0.140577 * twist)};
}

}  // namespace limber::test

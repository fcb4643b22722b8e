// SPDX-License-Identifier: Zlib
#include "networks/skin_table.h"

#include "clocks.h"
#include "network/skin.h"
#include "networks/value_of.h"
#include "support/network_shapes.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"
#include "text_format.h"

#include <limber/mesh.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace limber::bench {
namespace {

using Field = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

Eigen::Matrix3d affineMatrix() {
  Eigen::Matrix3d m;
  m << 0.9, 0.3, -0.2, -0.4, 1.2, 0.1, 0.2, 0.5, 0.8;
  return m;
}

Eigen::Vector3d turned(const Eigen::Vector3d& x, double angle, int axis) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)) * x;
}

/// Smooth deformations of a body about a metre large.
std::vector<Field> smoothFields() {
  return {[](const Eigen::Vector3d& x) { return turned(x, x.y(), 2); },
          [](const Eigen::Vector3d& x) { return turned(x, 1.5 * x.y(), 1); },
          [](const Eigen::Vector3d& x) {
            const double s = 1.0 - 0.4 * std::cos(2.0 * x.y());
            return Eigen::Vector3d(x.x() / std::sqrt(s), x.y() * s, x.z() / std::sqrt(s));
          },
          [](const Eigen::Vector3d& x) {
            return Eigen::Vector3d(
                x + 0.1 * Eigen::Vector3d(std::sin(4 * x.y()), std::sin(4 * x.z()), std::sin(4 * x.x())));
          }};
}

struct Errors {
  double largest = 0.0, rms = 0.0;
};

Errors errorsOf(const Field& field, const SkinWeights& skin, const std::vector<Eigen::Vector3d>& points,
                const std::vector<Eigen::Vector3d>& places) {
  Errors e;
  for (std::size_t i = 0; i < places.size(); ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::uint32_t w = skin.firstWeight[i]; w < skin.firstWeight[i + 1]; ++w)
      sum += skin.weights[w] * field(points[skin.points[w]]);
    const double error = (sum - field(places[i])).norm();
    e.largest = std::max(e.largest, error);
    e.rms += error * error / static_cast<double>(places.size());
  }
  e.rms = std::sqrt(e.rms);
  return e;
}

SkinRow measure(const char* mesh, const SpringNetwork& coarse, const WeldedMesh& fine, SkinKind kind,
                const char* name) {
  SkinSettings settings;
  settings.kind = kind;
  const Stopwatch watch;
  const SkinWeights skin = valueOf(skinWeights(coarse, fine, settings));
  SkinRow row{mesh, name, fine.points.size(), coarse.restPoints.size()};
  row.seconds = 1e-3 * watch.time().cpuMs;
  row.weightsPerVertex = double(skin.weights.size()) / double(fine.points.size());
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : fine.points) box.extend(p);
  const double size = box.sizes().maxCoeff();
  const Eigen::Matrix3d matrix = affineMatrix();
  const auto affine = [&](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(matrix * x + Eigen::Vector3d(1, 2, 3));
  };
  row.affine = errorsOf(affine, skin, coarse.restPoints, fine.points).largest / size;
  for (const Field& field : smoothFields())
    row.smooth = std::max(row.smooth, errorsOf(field, skin, coarse.restPoints, fine.points).rms / size);
  return row;
}

}  // namespace

std::vector<SkinRow> measureSkins(bool quick) {
  const std::pair<const char*, TriangleMesh> meshes[] = {
      {"rabbit", test_shapes::rabbit(quick ? 0.04 : 0.015)},
      {"torus", test_shapes::roundTorus(quick ? 0.04 : 0.015)},
      {"cube", small_meshes::cube(quick ? 16 : 40)},
      {"noise", test_shapes::noiseSphere(quick ? 4 : 5)}};
  const std::pair<SkinKind, const char*> kinds[] = {
      {SkinKind::Dense, "dense"}, {SkinKind::Sparse, "sparse"}, {SkinKind::Barycentric, "barycentric"}};
  std::vector<SkinRow> rows;
  for (const auto& [name, mesh] : meshes) {
    const WeldedMesh fine = valueOf(weld(mesh));
    const SharedNetwork coarse = network_shapes::bare(valueOf(simplify(mesh, 100)));
    for (const auto& [kind, kindName] : kinds) rows.push_back(measure(name, *coarse, fine, kind, kindName));
  }
  return rows;
}

std::string skinTable(const std::vector<SkinRow>& rows) {
  std::string text = "\ndetailed meshes on coarse ones: errors relative to the size\n";
  text += format("%-8s %8s %6s %-12s %9s %9s %9s %7s\n", "mesh", "vertices", "points", "skin", "weights",
                 "affine", "smooth", "s");
  for (const SkinRow& r : rows)
    text += format("%-8s %8zu %6zu %-12s %9.1f %9.1e %9.1e %7.2f\n", r.mesh.c_str(), r.vertices, r.points,
                   r.kind.c_str(), r.weightsPerVertex, r.affine, r.smooth, r.seconds);
  return text;
}

}  // namespace limber::bench

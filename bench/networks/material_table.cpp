// SPDX-License-Identifier: Zlib
#include "networks/material_table.h"

#include "cook/elastic_moduli.h"
#include "cook/spring_constants.h"
#include "cook/tetrahedra.h"
#include "support/network_shapes.h"
#include "text_format.h"

#include <limber/material_network.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace limber::bench {
namespace {

constexpr double kYoung = 1e5;

template <class T>
T valueOf(Result<T> result) {
  if (!result) throw std::runtime_error(result.error());
  return std::move(*result);
}

SharedNetwork filled(const TriangleMesh& mesh, std::uint32_t points) {
  MaterialMesh settings;
  settings.points = points;
  return valueOf(buildMaterialNetwork(mesh, settings));
}

ElasticModuli moduliOf(const SpringNetwork& network, double stiffnessPerModulus) {
  ElasticBody body{network};
  body.stiffness = kYoung * stiffnessPerModulus;
  return measureModuli(body);
}

/// The factor by which the springs of a lattice of so many points miss the modulus before they are
/// calibrated.
double calibrationOf(const TriangleMesh& mesh, std::size_t points) {
  const TetrahedralMesh filled = valueOf(fillWithPoints(valueOf(weld(mesh)), points));
  SpringNetwork network;
  network.restPoints = filled.points;
  network.tetrahedra = filled.tetrahedra;
  network.surface = filled.surface;
  return setMaterialSprings(network);
}

MaterialRow measureRow(const network_shapes::NamedShape& shape, std::uint32_t points) {
  const TriangleMesh mesh = shape.make();
  const SharedNetwork coarse = filled(mesh, points), fine = filled(mesh, 4 * points);
  const ElasticModuli moduli = moduliOf(*coarse, coarse->stiffnessPerModulus);
  MaterialRow row{shape.name, coarse->restPoints.size(), fine->restPoints.size()};
  row.youngError = std::abs(moduli.youngsModulus / kYoung - 1.0);
  row.isotropy = moduli.isotropy;
  row.poissonRatio = moduli.poissonRatio;
  row.drift = std::abs(calibrationOf(mesh, 4 * points) / calibrationOf(mesh, points) - 1.0);
  return row;
}

double relativeOpening(const SpringNetwork& network, double stiffness) {
  ElasticBody body{network};
  body.stiffness = stiffness;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : network.restPoints) box.extend(p);
  // the ends of the two arms
  const Eigen::Vector3d low = box.min(), high = box.max(), middle = box.center();
  const Eigen::Vector3d a(low.x(), high.y(), middle.z()), b(high.x(), low.y(), middle.z());
  return openingStiffness(body, a, b, 0.3 * box.sizes().maxCoeff()) / measureModuli(body).bulkModulus;
}

double measureOpening() {
  const TriangleMesh mesh = network_shapes::lshape90();
  const SharedNetwork braced = valueOf(buildNetwork(mesh)), reference = filled(mesh, 300);
  return relativeOpening(*braced, 1000.0) /
         relativeOpening(*reference, kYoung * reference->stiffnessPerModulus);
}

}  // namespace

MaterialResults measureMaterials(bool quick) {
  MaterialResults results;
  for (const network_shapes::NamedShape& shape : network_shapes::solids()) {
    const std::string name = shape.name;
    const bool wanted = name == "cube8" || name == "ico162" || name == "lshape90" || name == "cyl62" ||
                        name == "noise162" || name == "rabbit302";
    if (wanted && (!quick || name == "cube8")) results.rows.push_back(measureRow(shape, 300));
  }
  results.openingRatio = measureOpening();
  return results;
}

std::string materialTable(const MaterialResults& results) {
  std::string text = "\nmaterial mode: bodies of tetrahedra, and four times as many points\n";
  text += format("%-10s %6s %6s %12s %8s %9s %8s\n", "mesh", "points", "fine", "E off by", "drift",
                 "isotropy", "Poisson");
  for (const MaterialRow& r : results.rows)
    text += format("%-10s %6zu %6zu %12.1e %6.1f %% %9.3f %8.3f\n", r.mesh.c_str(), r.points, r.finePoints,
                   r.youngError, 100.0 * r.drift, r.isotropy, r.poissonRatio);
  return text + format("opening the L, braced over tetrahedra, each relative to its bulk modulus: %.2f\n",
                       results.openingRatio);
}

std::string materialTargets(const MaterialResults& results) {
  double young = 0.0, drift = 0.0, isotropy = 1.0;
  for (const MaterialRow& r : results.rows) {
    young = std::max(young, r.youngError);
    drift = std::max(drift, r.drift);
    isotropy = std::min(isotropy, r.isotropy);
  }
  const auto line = [](bool hit, const char* what, const std::string& value) {
    return format("  %-4s  %-78s %s\n", hit ? "hit" : "MISS", what, value.c_str());
  };
  return line(young <= 0.01, "material mode: Young's modulus within 1 %", format("%.1e", young)) +
         line(drift <= 0.1, "material mode: drift over a 4x refinement at most 10 %",
              format("%.1f %%", 100 * drift)) +
         line(isotropy >= 0.85, "material mode: isotropy at least 0.85", format("%.3f", isotropy)) +
         line(results.openingRatio <= 1.5, "opening the L at most 1.5 times the tetrahedral reference",
              format("%.2f", results.openingRatio));
}

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#include "networks/material_table.h"

#include "mesh/surface.h"
#include "network/material.h"
#include "network/tetrahedra.h"
#include "networks/value_of.h"
#include "solver/volumes.h"
#include "support/elastic_measures.h"
#include "support/network_shapes.h"
#include "text_format.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <cmath>

namespace limber::bench {
namespace {

constexpr double kYoung = 1e5;

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

/// How much the refined body differs from the coarse one, both of the same material, under loads that neither
/// was calibrated by: their moduli under uniform stress are equal by construction.
void setBendingDrift(MaterialRow& row, const SpringNetwork& coarse, const SpringNetwork& fine) {
  const auto before = test::measureBendingModuli({coarse, coarse.stiffnessPerModulus});
  const auto after = test::measureBendingModuli({fine, fine.stiffnessPerModulus});
  double meanBefore = 0.0, meanAfter = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    meanBefore += before[i] / 6.0;
    meanAfter += after[i] / 6.0;
    row.worstBending = std::max(row.worstBending, std::abs(after[i] / before[i] - 1.0));
  }
  row.bending = std::abs(meanAfter / meanBefore - 1.0);
}

MaterialRow measureRow(const network_shapes::NamedShape& shape, std::uint32_t points) {
  const TriangleMesh mesh = shape.make();
  const SharedNetwork coarse = filled(mesh, points), fine = filled(mesh, 4 * points);
  const ElasticModuli moduli = moduliOf(*coarse, coarse->stiffnessPerModulus);
  MaterialRow row{shape.name, coarse->restPoints.size(), fine->restPoints.size()};
  row.youngError = std::abs(moduli.youngsModulus / kYoung - 1.0);
  row.isotropy = moduli.isotropy;
  row.poissonRatio = moduli.poissonRatio;
  row.calibration = std::abs(calibrationOf(mesh, 4 * points) / calibrationOf(mesh, points) - 1.0);
  setBendingDrift(row, *coarse, *fine);
  return row;
}

BeamRow measureBeamRow(std::uint32_t points) {
  const SharedNetwork network = filled(test::boxMesh({4.0, 1.0, 1.0}), points);
  const test::BeamModuli beam = test::measureBeam({*network, network->stiffnessPerModulus});
  return {network->restPoints.size(), beam.tension, beam.bending, beam.torsion};
}

/// The body with the volume term that it has in a simulation unless told otherwise: as stiff as its springs
/// are together, of the inside of the surface or of each tetrahedron.
ElasticBody asSimulated(const SpringNetwork& network) {
  ElasticBody body{network};
  const double volume = signedVolume(network.restPoints, network.surface);
  body.volumeModulus = networkModulus(network, body.scale, body.stiffness, volume);
  return body;
}

/// m: of the force that draws the arms' ends apart over the change of their distance (openingStiffness), to
/// the bulk modulus, both of the whole body with its volume term. It does not depend on the springs' unit.
double relativeOpening(const SpringNetwork& network) {
  const ElasticBody body = asSimulated(network);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : network.restPoints) box.extend(p);
  // the ends of the two arms
  const Eigen::Vector3d low = box.min(), high = box.max(), middle = box.center();
  const Eigen::Vector3d a(low.x(), high.y(), middle.z()), b(high.x(), low.y(), middle.z());
  return test::openingStiffness(body, a, b, 0.3 * box.sizes().maxCoeff()) / measureModuli(body).bulkModulus;
}

/// The opening of the surface network over that of the same L filled with tetrahedra, fine enough that a
/// coarse lattice's own stiffness in bending is no part of the measure.
double measureOpening() {
  constexpr std::uint32_t kFine = 1200;
  const TriangleMesh mesh = network_shapes::lshape90();
  const SharedNetwork braced = valueOf(buildNetwork(mesh)), reference = filled(mesh, kFine);
  return relativeOpening(*braced) / relativeOpening(*reference);
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
  for (const std::uint32_t points : {185u, 969u, 6050u})
    if (!quick || points < 1000u) results.beams.push_back(measureBeamRow(points));
  results.openingRatio = measureOpening();
  return results;
}

std::string materialTable(const MaterialResults& results) {
  std::string text = "\nmaterial mode: bodies of tetrahedra, and four times as many points\n";
  text += format("%-10s %6s %6s %12s %11s %8s %8s %9s %8s\n", "mesh", "points", "fine", "E off by",
                 "calibration", "bending", "(worst)", "isotropy", "Poisson");
  for (const MaterialRow& r : results.rows)
    text += format("%-10s %6zu %6zu %12.1e %9.1f %% %6.1f %% %6.1f %% %9.3f %8.3f\n", r.mesh.c_str(),
                   r.points, r.finePoints, r.youngError, 100.0 * r.calibration, 100.0 * r.bending,
                   100.0 * r.worstBending, r.isotropy, r.poissonRatio);
  text +=
      format("%-24s %6s %8s %8s %8s\n", "bar 4 : 1 / beam theory", "points", "tension", "bending", "torsion");
  for (const BeamRow& b : results.beams)
    text += format("%-24s %6zu %8.3f %8.3f %8.3f\n", "", b.points, b.tension, b.bending, b.torsion);
  return text + format(
                    "opening the L, braced over tetrahedra, each relative to its bulk modulus, both with "
                    "volume term: %.2f\n",
                    results.openingRatio);
}

namespace {

/// The largest deviation of a beam from theory.
double deviation(const BeamRow& b) {
  return std::max({std::abs(b.tension - 1.0), std::abs(b.bending - 1.0), std::abs(b.torsion - 1.0)});
}

/// The largest change from one beam to the other.
double drift(const BeamRow& a, const BeamRow& b) {
  return std::max({std::abs(b.tension / a.tension - 1.0), std::abs(b.bending / a.bending - 1.0),
                   std::abs(b.torsion / a.torsion - 1.0)});
}

std::string targetLine(bool hit, const char* what, const std::string& value) {
  return format("  %-4s  %-78s %s\n", hit ? "hit" : "MISS", what, value.c_str());
}

std::string beamTargets(const std::vector<BeamRow>& beams) {
  std::string text;
  const auto line = [&](double value, double limit, const char* what) {
    text += targetLine(value <= limit, what, format("%.1f %%", 100.0 * value));
  };
  if (beams.size() >= 2) {
    line(deviation(beams[1]), 0.1, "a bar's tension, bending, torsion within 10 % of theory at 1 000 points");
    line(drift(beams[0], beams[1]), 0.1, "... and drift by at most 10 % from 185 to 969 points");
  }
  if (beams.size() >= 3) line(deviation(beams[2]), 0.05, "... and are within 5 % at 6 000 points");
  return text;
}

}  // namespace

std::string materialTargets(const MaterialResults& results) {
  double young = 0.0, calibration = 0.0, bending = 0.0, isotropy = 1.0;
  for (const MaterialRow& r : results.rows) {
    young = std::max(young, r.youngError);
    calibration = std::max(calibration, r.calibration);
    bending = std::max(bending, r.bending);
    isotropy = std::min(isotropy, r.isotropy);
  }
  return targetLine(young <= 0.01, "material mode: Young's modulus within 1 %", format("%.1e", young)) +
         targetLine(bending <= 0.1, "material mode: bending drifts over a 4x refinement by at most 10 %",
                    format("%.1f %%", 100 * bending)) +
         targetLine(calibration <= 0.1,
                    "material mode: calibration drifts over a 4x refinement by at most 10 %",
                    format("%.1f %%", 100 * calibration)) +
         targetLine(isotropy >= 0.85, "material mode: isotropy at least 0.85", format("%.3f", isotropy)) +
         beamTargets(results.beams) +
         targetLine(results.openingRatio <= 1.5, "opening the L at most 1.5 times the tetrahedral reference",
                    format("%.2f", results.openingRatio));
}

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
// Masses, skins and materials of networks.
#include "mesh/surface.h"
#include "network/material.h"
#include "network/skin.h"
#include "network/tetrahedra.h"
#include "networks/networks.h"
#include "solver/volumes.h"
#include "support/elastic_measures.h"
#include "support/mass_errors.h"
#include "support/network_shapes.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"
#include "timing.h"

#include <limber/mesh.h>
#include <limber/network_builder.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

namespace limber::bench {
namespace {

// --- masses ---

/// What it takes to match the moments: points inside.
double inertiaWithPointsInside(const TriangleMesh& mesh) {
  const Result<SharedNetwork> filled = buildMaterialNetwork(mesh);
  if (!filled) return -1.0;
  return test::shareMass(MassRule::Moments, (*filled)->restPoints, (*filled)->surface).inertiaError;
}

/// Compares point masses with the solid.
void measureMass(const network_shapes::NamedShape& shape, MassRule rule, Results& results) {
  const char* const names[] = {"equal", "by area", "by moments"};
  const SharedNetwork network = network_shapes::bare(shape.make());
  const test::MassFractions m = test::shareMass(rule, network->restPoints, network->surface);
  const auto [least, most] = std::minmax_element(m.shares.begin(), m.shares.end());
  const Subject subject{"masses", shape.name, "Limber", names[static_cast<int>(rule)]};
  results.add(subject, "centre off by", "% of size", 100.0 * m.centreError);
  results.add(subject, "inertia off by", "%", 100.0 * m.inertiaError);
  results.add(subject, "largest over smallest mass", "", *most / *least);
  if (rule != MassRule::Moments) return;
  const bool matches = m.centreError <= 0.01 && m.inertiaError <= 0.01, unsolvable = m.leastMisfit > 0.0;
  results.add(subject, "proven without solution", "", unsolvable);
  results.add(subject, "proven without solution by any masses", "", m.leastMisfitAnyMass > 0.0);
  if (!unsolvable) results.add(subject, "solution missed", "", !matches);
  if (unsolvable)
    results.add(subject, "inertia off by, with points inside", "%",
                100.0 * inertiaWithPointsInside(shape.make()));
}

}  // namespace

void measureMasses(const Options& options, Results& results) {
  for (const network_shapes::NamedShape& shape : network_shapes::solids())
    if (options.wantsScene(shape.name))
      for (const MassRule rule : {MassRule::Equal, MassRule::Area, MassRule::Moments})
        measureMass(shape, rule, results);
}

// --- skins ---

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

/// Measures a detailed mesh that rides on a coarse one.
void measureSkin(const Subject& subject, const SpringNetwork& coarse, const WeldedMesh& fine, SkinKind kind,
                 Results& results) {
  SkinSettings settings;
  settings.kind = kind;
  const Stopwatch watch;
  const SkinWeights skin = valueOf(skinWeights(coarse, fine, settings));
  const double seconds = 1e-3 * watch.time().cpuMs;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : fine.points) box.extend(p);
  const double size = box.sizes().maxCoeff();
  const Eigen::Matrix3d matrix = affineMatrix();
  const auto affine = [&](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(matrix * x + Eigen::Vector3d(1, 2, 3));
  };
  double smooth = 0.0;
  for (const Field& field : smoothFields())
    smooth = std::max(smooth, errorsOf(field, skin, coarse.restPoints, fine.points).rms / size);
  results.add(subject, "vertices", "", double(fine.points.size()));
  results.add(subject, "points", "", double(coarse.restPoints.size()));
  results.add(subject, "weights per vertex", "", double(skin.weights.size()) / double(fine.points.size()));
  results.add(subject, "error of affine motion", "of size",
              errorsOf(affine, skin, coarse.restPoints, fine.points).largest / size);
  results.add(subject, "error of smooth motion", "of size", smooth);
  results.add(subject, "computing", "s", seconds);
}

}  // namespace

void measureSkins(const Options& options, Results& results) {
  const bool quick = options.quick;
  const std::pair<const char*, TriangleMesh> meshes[] = {
      {"rabbit", test_shapes::rabbit(quick ? 0.04 : 0.015)},
      {"torus", test_shapes::roundTorus(quick ? 0.04 : 0.015)},
      {"cube", small_meshes::cube(quick ? 16 : 40)},
      {"noise", test_shapes::noiseSphere(quick ? 4 : 5)}};
  const std::pair<SkinKind, const char*> kinds[] = {
      {SkinKind::Dense, "dense"}, {SkinKind::Sparse, "sparse"}, {SkinKind::Barycentric, "barycentric"}};
  for (const auto& [name, mesh] : meshes) {
    if (!options.wantsScene(name)) continue;
    const WeldedMesh fine = valueOf(weld(mesh));
    const SharedNetwork coarse = network_shapes::bare(valueOf(simplify(mesh, 100)));
    for (const auto& [kind, setting] : kinds)
      measureSkin({"skins", name, "Limber", setting}, *coarse, fine, kind, results);
  }
}

// --- materials ---

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

/// Adds how much the refined body differs from the coarse one, both of the same material, under loads that
/// neither was calibrated by: their moduli under uniform stress are equal by construction.
void addBendingDrift(const Subject& subject, const SpringNetwork& coarse, const SpringNetwork& fine,
                     Results& results) {
  const auto before = measureModuli({coarse, coarse.stiffnessPerModulus}).bending;
  const auto after = measureModuli({fine, fine.stiffnessPerModulus}).bending;
  double meanBefore = 0.0, meanAfter = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    meanBefore += before[i].modulus / 6.0;
    meanAfter += after[i].modulus / 6.0;
    worst = std::max(worst, std::abs(after[i].modulus / before[i].modulus - 1.0));
  }
  results.add(subject, "drift of bending", "%", 100.0 * std::abs(meanAfter / meanBefore - 1.0));
  results.add(subject, "drift of bending, worst load", "%", 100.0 * worst);
}

/// Compares a body of a material with the same on a lattice of four times as many points.
void measureMaterial(const network_shapes::NamedShape& shape, std::uint32_t points, Results& results) {
  const TriangleMesh mesh = shape.make();
  const SharedNetwork coarse = filled(mesh, points), fine = filled(mesh, 4 * points);
  const ElasticModuli moduli = moduliOf(*coarse, coarse->stiffnessPerModulus);
  const Subject subject{"materials", shape.name, "Limber", "tetrahedra"};
  results.add(subject, "points", "", double(coarse->restPoints.size()));
  results.add(subject, "points of the refined body", "", double(fine->restPoints.size()));
  results.add(subject, "Young's modulus off by", "%", 100.0 * std::abs(moduli.youngsModulus / kYoung - 1.0));
  results.add(subject, "isotropy", "", moduli.isotropy);
  results.add(subject, "Poisson's ratio", "", moduli.poissonRatio);
  results.add(subject, "drift of calibration", "%",
              100.0 * std::abs(calibrationOf(mesh, 4 * points) / calibrationOf(mesh, points) - 1.0));
  addBendingDrift(subject, *coarse, *fine, results);
}

/// The largest change from one bar to the other.
double driftOf(const test::BeamModuli& a, const test::BeamModuli& b) {
  return std::max({std::abs(b.tension / a.tension - 1.0), std::abs(b.bending / a.bending - 1.0),
                   std::abs(b.torsion / a.torsion - 1.0)});
}

/// Measures bars 4 : 1 of square section: the measured Young's modulus over the requested one.
void measureBeams(bool quick, Results& results) {
  std::optional<test::BeamModuli> last;
  for (const std::uint32_t points : {185u, 969u, 6050u}) {
    if (quick && points > 1000u) continue;
    const SharedNetwork network = filled(test::boxMesh({4.0, 1.0, 1.0}), points);
    const test::BeamModuli beam = test::measureBeam({*network, network->stiffnessPerModulus});
    const Subject subject{"bars", format("%u points", points), "Limber", "tetrahedra"};
    results.add(subject, "tension over theory", "", beam.tension);
    results.add(subject, "bending over theory", "", beam.bending);
    results.add(subject, "torsion over theory", "", beam.torsion);
    results.add(subject, "largest deviation", "%", 100.0 * driftOf({1.0, 1.0, 1.0}, beam));
    if (last) results.add(subject, "drift from fewer points", "%", 100.0 * driftOf(*last, beam));
    last = beam;
  }
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

void measureMaterials(const Options& options, Results& results) {
  for (const network_shapes::NamedShape& shape : network_shapes::solids()) {
    const std::string name = shape.name;
    const bool chosen = name == "cube8" || name == "ico162" || name == "lshape90" || name == "cyl62" ||
                        name == "noise162" || name == "rabbit302";
    if (chosen && (!options.quick || name == "cube8") && options.wantsScene(name))
      measureMaterial(shape, 300, results);
  }
  if (options.wantsScene("bar")) measureBeams(options.quick, results);
  if (options.wantsScene("lshape90"))
    results.add({"opening", "lshape90", "Limber", "braces over tetrahedra"}, "opening stiffness, relative",
                "", measureOpening());
}

}  // namespace limber::bench

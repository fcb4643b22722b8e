// SPDX-License-Identifier: Zlib
// Builds networks of tetrahedra with the elasticity of a material, and chooses the settings of a body with
// the requested elasticity.

#include <limber/network_builder.h>

#include "network/material.h"
#include "network/tetrahedra.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace limber {
namespace {

/// Tolerance of Poisson's ratio, and the largest number of measurements.
constexpr double kPoissonError = 5e-4;
constexpr int kMaxMeasurements = 6;

double volumeOfTetrahedra(const SpringNetwork& network) {
  double volume = 0.0;
  for (const Tetrahedron& t : network.tetrahedra) volume += volumeOf(network.restPoints, t);
  return volume;
}

std::string outOfRange(const char* name, double value, const char* rule) {
  char text[128];
  std::snprintf(text, sizeof text, "%s is %g, must be %s", name, value, rule);
  return text;
}

/// Settings of a body of this network for a Young's modulus of 1 Pa.
struct UnitMaterial {
  double stiffness = 0.0;      ///< m
  double volumeModulus = 0.0;  ///< per Pa
};

/// Springs alone have lambda = mu = 2/5 E; a volume term of modulus K adds K to lambda. With
/// nu = lambda / (2 (lambda + mu)) that is  nu = (mu + K) / (2 (2 mu + K)),  so
/// K = mu (4 nu - 1) / (1 - 2 nu). A network is a little softer than this estimate, so the target nu is
/// corrected by the measured nu.
UnitMaterial findUnitMaterial(const SpringNetwork& network, double poissonRatio,
                              const Eigen::Vector3d& scale) {
  const double mu = 0.4;
  double targetRatio = poissonRatio;
  UnitMaterial unit;
  for (int i = 0; i < kMaxMeasurements; ++i) {
    // computed as if the springs were of 1 Pa; scaled below
    const double modulus = mu * (4.0 * targetRatio - 1.0) / (1.0 - 2.0 * targetRatio);
    const ElasticModuli moduli = measureModuli({network, network.stiffnessPerModulus, modulus, scale});
    unit = {network.stiffnessPerModulus / moduli.youngsModulus, modulus / moduli.youngsModulus};
    const double error = poissonRatio - moduli.poissonRatio;
    if (std::abs(error) < kPoissonError || (targetRatio <= 0.25 && error < 0.0)) break;
    targetRatio = std::clamp(targetRatio + error, 0.25, 0.5 * (targetRatio + 0.5));
  }
  return unit;
}

}  // namespace

Result<void> validate(const Material& m) {
  if (!std::isfinite(m.youngsModulus) || m.youngsModulus <= 0.0)
    return Error{outOfRange("youngsModulus", m.youngsModulus, "above 0")};
  if (!(m.poissonRatio >= 0.25 && m.poissonRatio < 0.5))
    return Error{outOfRange("poissonRatio", m.poissonRatio, "from 0.25 to below 0.5")};
  if (!std::isfinite(m.density) || m.density <= 0.0)
    return Error{outOfRange("density", m.density, "above 0")};
  if (m.dampingTime && !(std::isfinite(*m.dampingTime) && *m.dampingTime >= 0.0))
    return Error{outOfRange("dampingTime", *m.dampingTime, "0 or more")};
  return {};
}

Material Material::jelly() { return {5e4, 0.4, 1000.0, 0.01}; }
Material Material::rubber() { return {1.5e6, 0.4, 1100.0, 0.003}; }
Material Material::foam() { return {1e5, 0.25, 60.0, 0.02}; }
Material Material::stiff() { return {1e7, 0.3, 1100.0, 0.001}; }

SpringNetwork materialNetwork(TetrahedralMesh filling, const std::function<bool(double)>& goOn,
                              double minGrowth) {
  SpringNetwork network;
  network.restPoints = std::move(filling.points);
  network.tetrahedra = std::move(filling.tetrahedra);
  network.surface = std::move(filling.surface);
  setMaterialSprings(network, goOn, minGrowth);
  network.massFractions = materialMasses(network);
  return network;
}

Result<SharedNetwork> buildMaterialNetwork(const TriangleMesh& mesh, const MaterialMesh& settings) {
  bool going = true;  // once false, it stays false
  const auto reportProgress = [&](const char* what, double done) {
    return going = going && (!settings.progress || settings.progress(what, done));
  };
  if (settings.spacing && !(std::isfinite(*settings.spacing) && *settings.spacing > 0.0))
    return Error{outOfRange("spacing", *settings.spacing, "above 0")};
  const Result<WeldedMesh> welded = weld(mesh);
  if (!welded) return Error{welded.error()};
  if (!reportProgress("tetrahedra", 0.0)) return Error{kEnded};
  const auto fillingProgress = [&](double done) { return reportProgress("tetrahedra", done); };
  Result<TetrahedralMesh> filling = settings.spacing
                                        ? fillWithTetrahedra(*welded, *settings.spacing)
                                        : fillWithPoints(*welded, settings.points, fillingProgress);
  if (!reportProgress("tetrahedra", 1.0)) return Error{kEnded};
  if (!filling) return Error{filling.error()};
  const auto springProgress = [&](double done) { return reportProgress("spring constants", done); };
  SpringNetwork network = materialNetwork(std::move(*filling), springProgress);
  network.report = welded->report;
  if (!reportProgress("skin", 0.0)) return Error{kEnded};
  Result<SharedNetwork> skinned = withSkin(network, mesh, {SkinKind::Barycentric, 32, 0.0});
  if (!reportProgress("skin", 1.0)) return Error{kEnded};
  return skinned;
}

Result<SoftBodySettings> withMaterial(const SpringNetwork& network, const Material& material,
                                      SoftBodySettings settings) {
  if (network.tetrahedra.empty() || network.stiffnessPerModulus <= 0.0)
    return Error{"the network has no tetrahedra to be of a material: make it with buildMaterialNetwork"};
  if (Result<void> valid = validate(material); !valid) return Error{valid.error()};
  if (Result<void> valid = validate(settings); !valid) return Error{valid.error()};
  const UnitMaterial unit = findUnitMaterial(network, material.poissonRatio, settings.scale.cwiseAbs());
  settings.extensionStiffness = settings.compressionStiffness = unit.stiffness * material.youngsModulus;
  settings.volumeModulus = unit.volumeModulus * material.youngsModulus;
  if (material.dampingTime) settings.damping = *material.dampingTime * settings.extensionStiffness;
  settings.totalMass = material.density * volumeOfTetrahedra(network) * std::abs(settings.scale.prod());
  if (Result<void> valid = validate(settings); !valid)
    return Error{"a body of this material: " + valid.error()};
  return settings;
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include <limber/material_network.h>

#include "cook/elastic_moduli.h"
#include "cook/spring_constants.h"
#include "cook/tetrahedra.h"
#include "cook/tetrahedron_faces.h"

#include <limber/skin.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace limber {
namespace {

/// The least mass of a point, of the mean: the lightest point limits the time step.
constexpr double kLeastCornerShare = 0.2;

/// A material with half its springs is none, so there is no early result.
constexpr char kEnded[] = "ended early: progress returned false";

/// How near Poisson's ratio comes to the one asked for, and after how many measurements at most.
constexpr double kPoissonError = 5e-4;
constexpr int kMeasurements = 6;

double volumeOfTetrahedra(const SpringNetwork& network) {
  double volume = 0.0;
  for (const Tetrahedron& t : network.tetrahedra) volume += volumeOf(network.restPoints, t);
  return volume;
}

/// A quarter of each tetrahedron for each of its corners.
std::vector<double> volumeShares(const SpringNetwork& network) {
  std::vector<double> shares(network.restPoints.size(), 0.0);
  const double volume = volumeOfTetrahedra(network);
  for (const Tetrahedron& t : network.tetrahedra)
    for (const std::uint32_t point : t) shares[point] += volumeOf(network.restPoints, t) / (4.0 * volume);
  double sum = 0.0;
  for (double& share : shares) {
    share = std::max(share, kLeastCornerShare / static_cast<double>(shares.size()));
    sum += share;
  }
  for (double& share : shares) share /= sum;
  return shares;
}

std::string outOfRange(const char* name, double value, const char* rule) {
  char text[128];
  std::snprintf(text, sizeof text, "%s is %g, must be %s", name, value, rule);
  return text;
}

std::string check(const Material& m) {
  if (!std::isfinite(m.youngsModulus) || m.youngsModulus <= 0.0)
    return outOfRange("youngsModulus", m.youngsModulus, "above 0");
  if (!(m.poissonRatio >= 0.25 && m.poissonRatio < 0.5))
    return outOfRange("poissonRatio", m.poissonRatio, "from 0.25 to below 0.5");
  if (!std::isfinite(m.density) || m.density <= 0.0) return outOfRange("density", m.density, "above 0");
  return {};
}

/// What a body of this network needs for a Young's modulus of 1 Pa.
struct UnitMaterial {
  double stiffness = 0.0;      ///< m
  double volumeModulus = 0.0;  ///< per Pa
};

/// Springs alone have lambda = mu = 2/5 E; a volume term of modulus K adds K to lambda. With
/// nu = lambda / (2 (lambda + mu)) that is  nu = (mu + K) / (2 (2 mu + K)),  so
/// K = mu (4 nu - 1) / (1 - 2 nu). A network gives way a little more than that, and the nu to aim at is
/// corrected by the nu found.
UnitMaterial findUnitMaterial(const SpringNetwork& network, double poissonRatio,
                              const Eigen::Vector3d& scale) {
  const double mu = 0.4;
  double aim = poissonRatio;
  UnitMaterial unit;
  for (int i = 0; i < kMeasurements; ++i) {
    // as though the springs were of 1 Pa; scaled below
    const double modulus = mu * (4.0 * aim - 1.0) / (1.0 - 2.0 * aim);
    const ElasticModuli found = measureModuli({network, network.stiffnessPerModulus, modulus, scale});
    unit = {network.stiffnessPerModulus / found.youngsModulus, modulus / found.youngsModulus};
    const double miss = poissonRatio - found.poissonRatio;
    if (std::abs(miss) < kPoissonError || (aim <= 0.25 && miss < 0.0)) break;
    aim = std::clamp(aim + miss, 0.25, 0.5 * (aim + 0.5));
  }
  return unit;
}

}  // namespace

Result<SharedNetwork> buildMaterialNetwork(const TriangleMesh& mesh, const MaterialMesh& settings) {
  bool going = true;  // once not, never again
  const auto tell = [&](const char* what, double done) {
    return going = going && (!settings.progress || settings.progress(what, done));
  };
  if (!std::isfinite(settings.spacing) || settings.spacing < 0.0)
    return Error{outOfRange("spacing", settings.spacing, "0 or more")};
  const Result<WeldedMesh> welded = weld(mesh);
  if (!welded) return Error{welded.error()};
  if (!tell("tetrahedra", 0.0)) return Error{kEnded};
  const auto whileFilling = [&](double done) { return tell("tetrahedra", 0.4 * done); };
  Result<TetrahedralMesh> filling = settings.spacing > 0.0
                                        ? fillWithTetrahedra(*welded, settings.spacing)
                                        : fillWithPoints(*welded, settings.points, whileFilling);
  if (!tell("tetrahedra", 0.4)) return Error{kEnded};
  if (!filling) return Error{filling.error()};
  SpringNetwork network;
  network.restPoints = std::move(filling->points);
  network.tetrahedra = std::move(filling->tetrahedra);
  network.surface = std::move(filling->surface);
  network.report = welded->report;
  network.massShares = volumeShares(network);
  setMaterialSprings(network, [&](double done) { return tell("spring constants", 0.4 + 0.5 * done); });
  if (!tell("skin", 0.9)) return Error{kEnded};
  Result<SharedNetwork> skinned = withSkin(network, mesh, {SkinKind::Barycentric, 32, 0.0});
  if (!tell("skin", 1.0)) return Error{kEnded};
  return skinned;
}

Result<SoftBodySettings> withMaterial(const SpringNetwork& network, const Material& material,
                                      SoftBodySettings settings) {
  if (network.tetrahedra.empty() || network.stiffnessPerModulus <= 0.0)
    return Error{"the network has no tetrahedra to be of a material: make it with buildMaterialNetwork"};
  if (std::string reason = check(material); !reason.empty()) return Error{std::move(reason)};
  if (std::string reason = validate(settings); !reason.empty()) return Error{std::move(reason)};
  const UnitMaterial unit = findUnitMaterial(network, material.poissonRatio, settings.scale.cwiseAbs());
  settings.extensionStiffness = settings.compressionStiffness = unit.stiffness * material.youngsModulus;
  settings.volumeModulus = unit.volumeModulus * material.youngsModulus;
  settings.totalMass = material.density * volumeOfTetrahedra(network) * std::abs(settings.scale.prod());
  if (std::string reason = validate(settings); !reason.empty())
    return Error{"a body of this material: " + std::move(reason)};
  return settings;
}

}  // namespace limber

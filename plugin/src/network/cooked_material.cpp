// SPDX-License-Identifier: Zlib
// Chooses the settings of cooked bodies for a material.

#include <limber/cook.h>

#include "mesh/linear_algebra.h"
#include "mesh/surface.h"
#include "network/material.h"

#include <cmath>
#include <utility>

namespace limber {

namespace {

/// Returns the sum of stiffnessScale times the square of the rest length over the springs that carry tension,
/// m^2.
double stiffnessMoment(const SpringNetwork& network, bool structuralOnly) {
  double sum = 0.0;
  for (const NetworkSpring& s : network.springs)
    if (!structuralOnly || s.kind == SpringKind::Structural)
      sum += s.stiffnessScale * (network.restPoints[s.b] - network.restPoints[s.a]).squaredNorm();
  return sum;
}

double areaOf(const SpringNetwork& network) {
  double area = 0.0;
  for (const Triangle& t : network.surface)
    area += areaVector(network.restPoints[t[0]], network.restPoints[t[1]], network.restPoints[t[2]]).norm();
  return area;
}

/// Spring constant (N/m) for 1 Pa, and the volume (m^3) of the material, at scale 1.
struct FormMaterial {
  double stiffness = 0.0, volume = 0.0;
};

FormMaterial materialOf(const CookedBody& body) {
  const SpringNetwork& n = *body.network;
  if (n.kind == NetworkKind::Rope) {
    const double section = 0.25 * kPi * body.thickness * body.thickness;
    double length = 0.0;
    for (std::size_t i = 1; i < n.restPoints.size(); ++i)
      length += (n.restPoints[i] - n.restPoints[i - 1]).norm();
    return {section * static_cast<double>(n.restPoints.size() - 1) / length, section * length};
  }
  if (body.thickness > 0.0) {
    const double area = areaOf(n);
    return {3.0 * body.thickness * area / stiffnessMoment(n, true), body.thickness * area};
  }
  const double volume = std::abs(signedVolume(n.restPoints, n.surface));
  return {6.0 * volume / stiffnessMoment(n, false), volume};
}

Result<SoftBodySettings> ofTetrahedra(const CookedBody& body, const Material& material,
                                      SoftBodySettings settings) {
  Result<SoftBodySettings> made = withMaterial(*body.network, material, std::move(settings));
  if (!made || body.volume == 0.0) return made;
  made->totalMass = material.density * body.volume * std::abs(made->scale.prod());
  if (Result<void> valid = validate(*made); !valid) return Error{"a body of this material: " + valid.error()};
  return made;
}

}  // namespace

Result<SoftBodySettings> withMaterial(const CookedBody& body, const Material& material,
                                      SoftBodySettings settings) {
  if (!body.network->tetrahedra.empty()) return ofTetrahedra(body, material, std::move(settings));
  if (Result<void> valid = validate(material); !valid) return Error{valid.error()};
  if (Result<void> valid = validate(settings); !valid) return Error{valid.error()};
  const double volumeScale = std::abs(settings.scale.prod()), lengthScale = std::cbrt(volumeScale);
  const FormMaterial form = materialOf(body);
  settings.extensionStiffness = settings.compressionStiffness =
      lengthScale * form.stiffness * material.youngsModulus;
  settings.totalMass = material.density * form.volume * volumeScale;
  if (material.dampingTime) settings.damping = *material.dampingTime * settings.extensionStiffness;
  if (body.thickness > 0.0 && !settings.pointRadius)
    settings.pointRadius = 0.5 * lengthScale * body.thickness;
  if (Result<void> valid = validate(settings); !valid)
    return Error{"a body of this material: " + valid.error()};
  return settings;
}

}  // namespace limber

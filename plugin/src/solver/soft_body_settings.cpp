// SPDX-License-Identifier: Zlib
// Checks the settings of bodies, springs, air, water and drag, and makes gusts.

#include <limber/soft_body_settings.h>

#include "mesh/surface.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <tuple>

namespace limber {
namespace {

/// Share of the shortest spring: small compared to the body, large compared to Bullet's margins at 1 m.
constexpr double kRadiusPerSpring = 0.02;

struct Check {
  const char* name;
  double value;
  double low, high;  // the smallest and the largest value allowed
  const char* rule;
};

template <std::size_t N>
Result<void> firstViolation(const Check (&checks)[N]) {
  for (const Check& c : checks)
    if (!(c.value >= c.low && c.value <= c.high)) return Error{mustBe(c.name, c.value, c.rule)};
  return {};
}

/// m: beyond it a float has steps of 6 cm and more.
constexpr double kMaxPosition = 1e6;

/// m/s, rad/s: a hundred times as fast as a bullet of a rifle.
constexpr double kMaxSpeed = 1e5;

/// Brings networks in any unit, from nanometres to gigametres, to metres.
constexpr double kMaxScale = 1e9;

/// The positions of bodies that are flattened by more became infinite in random tests.
constexpr double kMaxScaleRatio = 1e3;

std::string checkVector(const char* name, const Eigen::Vector3d& v, double largest) {
  char rule[60];
  std::snprintf(rule, sizeof rule, "from -%.0e to %.0e", largest, largest);
  std::string text = rule;
  for (std::size_t plus; (plus = text.find("e+0")) != std::string::npos;) text.replace(plus, 3, "e");
  for (int i = 0; i < 3; ++i)
    if (!(std::abs(v[i]) <= largest))
      return mustBe(name + std::string(".") + "xyz"[i], v[i], std::isfinite(v[i]) ? text.c_str() : "finite");
  return {};
}

std::string checkPlacement(const SoftBodySettings& s) {
  for (const auto& [name, v, largest] :
       {std::tuple("position", s.position, kMaxPosition), std::tuple("scale", s.scale, kMaxScale),
        std::tuple("linearVelocity", s.linearVelocity, kMaxSpeed),
        std::tuple("angularVelocity", s.angularVelocity, kMaxSpeed)})
    if (std::string reason = checkVector(name, v, largest); !reason.empty()) return reason;
  for (int i = 0; i < 3; ++i)
    if (std::abs(s.scale[i]) < 1.0 / kMaxScale)
      return mustBe(std::string("scale.") + "xyz"[i], s.scale[i],
                    s.scale[i] == 0.0 ? "other than 0" : "1e-9 or more, or -1e-9 or less");
  const Eigen::Array3d factors = s.scale.array().abs();
  if (factors.maxCoeff() > kMaxScaleRatio * factors.minCoeff())
    return mustBe("largest over smallest axis of scale", factors.maxCoeff() / factors.minCoeff(),
                  "at most 1000");
  const double norm = s.rotation.norm();
  if (!(std::abs(norm - 1.0) < 1e-6)) return mustBe("length of rotation", norm, "1");
  return {};
}

Result<void> checkGroups(const std::vector<GroupSettings>& groups) {
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const GroupSettings& g = groups[i];
    const Check checks[] = {
        {"stiffness", g.stiffness, 0, 1e6, "from 0 to 1e6"},
        {"damping", g.damping, 0, 1e6, "from 0 to 1e6"},
        {"limitStrain", g.limitStrain, 1e-6, 1e6, "from 1e-6 to 1e6"},
        {"restLength", g.restLength, 1e-3, 1e3, "from 1e-3 to 1e3"},
        {"mass", g.mass, 1e-3, 1e3, "from 1e-3 to 1e3"},
    };
    if (Result<void> valid = firstViolation(checks); !valid)
      return Error{"groups[" + std::to_string(i) + "]." + valid.error()};
  }
  return {};
}

}  // namespace

/// (omega dt)^2 / 24 = 0.08 is (omega dt)^2 = 1.92 for the stiffest oscillation, whose energy then varies by
/// the factor  1 / (1 - (omega dt)^2 / 4) = 1.9  at most.
Stepping Stepping::fast() {
  Stepping s;
  s.minSubsteps = 2;
  s.periodTolerance = 0.08;
  s.maxSubsteps = 10;
  s.searchDistance = 0.25;
  return s;
}

SoftBodySettings SoftBodySettings::paper() {
  SoftBodySettings s;
  s.extensionStiffness = 20.0;
  s.compressionStiffness = 20.0;
  s.damping = 0.2;
  return s;
}

Result<void> validate(const SoftBodySettings& s) {
  if (std::string reason = checkPlacement(s); !reason.empty()) return Error{std::move(reason)};
  if (s.selfCollision && s.collision != Collision::Surface)
    return Error{"selfCollision needs collision to be Collision::Surface"};
  if (s.hollow && s.collision != Collision::Surface)
    return Error{"hollow needs collision to be Collision::Surface"};
  const Check checks[] = {
      {"extensionStiffness", s.extensionStiffness, 0, 1e12, "from 0 to 1e12"},
      {"compressionStiffness", s.compressionStiffness, 0, 1e12, "from 0 to 1e12"},
      {"damping", s.damping, 0, 1e12, "from 0 to 1e12"},
      {"collision", static_cast<double>(s.collision), 0, double(Collision::Surface), "one of Collision's"},
      {"totalMass", s.totalMass, 1e-9, 1e12, "from 1e-9 to 1e12"},
      {"volumeModulus", s.volumeModulus.value_or(0.0), 0, 1e15, "from 0 to 1e15"},
      {"pressure", s.pressure, 0, 1e12, "from 0 to 1e12"},
      {"ambientPressure", s.ambientPressure, 0, 1e12, "from 0 to 1e12"},
      {"pointRadius", s.pointRadius.value_or(1.0), 1e-9, 1e4, "from 1e-9 to 1e4"},
      {"friction", s.friction, 0, 1e6, "from 0 to 1e6"},
      {"restitution", s.restitution, 0, 1, "from 0 to 1"},
      {"sleepingSpeed", s.sleepingSpeed, 0, 1e6, "from 0 to 1e6"},
      {"gravityFactor", s.gravityFactor, -1e3, 1e3, "from -1000 to 1000"},
      {"maxPinSpeed", s.maxPinSpeed, 1e-6, 1e6, "from 1e-6 to 1e6"},
      {"stepping.stepper", static_cast<double>(s.stepping.stepper), 0, double(Stepper::Newton),
       "one of Stepper's"},
      {"stepping.minSubsteps", static_cast<double>(s.stepping.minSubsteps), 1, 1e4, "from 1 to 10000"},
      {"stepping.periodTolerance", s.stepping.periodTolerance, 1e-8, 1, "from 1e-8 to 1"},
      {"stepping.tolerance", s.stepping.tolerance, 0, 1e6, "from 0 to 1e6"},
      {"stepping.relativeTolerance", s.stepping.relativeTolerance, 0, 1e6, "from 0 to 1e6"},
      {"stepping.maxSubsteps", static_cast<double>(s.stepping.maxSubsteps), 0, 1e4, "from 0 to 10000"},
      {"stepping.searchDistance", s.stepping.searchDistance, 0.01, 0.25, "from 0.01 to 0.25"},
      {"elasticLimit.stiffenStrain", s.elasticLimit.stiffenStrain, 0, 1e6, "from 0 to 1e6"},
      {"elasticLimit.stiffenFactor", s.elasticLimit.stiffenFactor, 1, 1e6, "from 1 to 1e6"},
      {"elasticLimit.yieldStrain", s.elasticLimit.yieldStrain, 0, 1e6, "from 0 to 1e6"},
      {"elasticLimit.yieldMaximum", s.elasticLimit.yieldMaximum, 0, 0.999, "from 0 to 0.999"},
      {"elasticLimit.breakStrain", s.elasticLimit.breakStrain, 0, 1e6, "from 0 to 1e6"},
  };
  if (Result<void> valid = firstViolation(checks); !valid) return valid;
  if (Result<void> valid = validate(s.flow); !valid) return Error{"flow." + valid.error()};
  return checkGroups(s.groups);
}

Result<void> validate(const SpringSettings& s) {
  const Check checks[] = {
      {"restLength", s.restLength.value_or(0.0), 0, 4e6, "from 0 to 4e6"},
      {"stiffness", s.stiffness, 0, 1e12, "from 0 to 1e12"},
      {"damping", s.damping, 0, 1e12, "from 0 to 1e12"},
      {"breakForce", s.breakForce, 0, 1e18, "from 0 to 1e18"},
      {"action", static_cast<double>(s.action), 0, double(SpringAction::CompressionOnly),
       "one of SpringAction's"},
  };
  return firstViolation(checks);
}

double pointRadius(const SpringNetwork& network, const SoftBodySettings& settings) {
  if (settings.pointRadius) return *settings.pointRadius;
  double shortest = std::numeric_limits<double>::max();
  for (const NetworkSpring& s : network.springs) {
    const Eigen::Vector3d d = network.restPoints[s.b] - network.restPoints[s.a];
    const double length = d.cwiseProduct(settings.scale).norm();
    if (length > 0.0) shortest = std::min(shortest, length);
  }
  return shortest < std::numeric_limits<double>::max() ? kRadiusPerSpring * shortest : kRadiusPerSpring;
}

// --- air and water -----------------------------------------------------------------------------------------

namespace {

using Eigen::Vector3d;

/// m/s, in worlds of millimetres three times the speed of sound.
constexpr double kMaxFlowSpeed = 1e6;

Result<void> checkFlowVelocity(const std::string& name, const Vector3d& v) {
  for (std::size_t i = 0; i < 3; ++i)
    if (!(std::abs(v[static_cast<Eigen::Index>(i)]) <= kMaxFlowSpeed))
      return Error{mustBe(name + "." + "xyz"[i], v[static_cast<Eigen::Index>(i)], "from -1e6 to 1e6")};
  return {};
}

}  // namespace

Result<void> validate(const Air& air) {
  const Check checks[] = {{"density", air.density, 0, 1e9, "from 0 to 1e9"}};
  if (Result<void> valid = firstViolation(checks); !valid) return valid;
  return checkFlowVelocity("wind", air.wind);
}

Result<void> validate(const Water& water) {
  const Check checks[] = {{"density", water.density, 1e-15, 1e9, "from 1e-15 to 1e9"},
                          {"level", water.level, -1e6, 1e6, "from -1e6 to 1e6"}};
  if (Result<void> valid = firstViolation(checks); !valid) return valid;
  return checkFlowVelocity("flow", water.flow);
}

Result<void> validate(const FlowCoefficients& flow) {
  const Check checks[] = {{"drag", flow.drag.value_or(0.0), 0, 100, "from 0 to 100"},
                          {"lift", flow.lift.value_or(0.0), 0, flow.drag ? *flow.drag : 1.0,
                           flow.drag ? "from 0 to drag" : "from 0 to 1 without drag"},
                          {"friction", flow.friction, 0, 100, "from 0 to 100"},
                          {"linearDrag", flow.linearDrag.value_or(0.0), 0, 1e6, "from 0 to 1e6"},
                          {"displacedVolume", flow.displacedVolume, 0, 1e9, "from 0 to 1e9"}};
  return firstViolation(checks);
}

// Eddies are plane waves whose velocities are perpendicular to their wave vectors, so that the air neither
// gathers nor thins; the mean wind carries them along (Kraichnan 1970).

WindFunction gusts(const Vector3d& meanWind, double strength, double size) {
  constexpr int kWaves = 6;
  struct Wave {
    Vector3d vector, velocity;
    double phase;
  };
  std::array<Wave, kWaves> waves;
  const double speed = meanWind.norm();
  const Vector3d along = speed > 0.0 ? Vector3d(meanWind / speed) : Vector3d(Vector3d::UnitX());
  const Vector3d side = along.unitOrthogonal(), up = along.cross(side);
  for (int i = 0; i < kWaves; ++i) {
    const double turn = 2.399963 * i, slant = 0.35 + 0.1 * i, number = (1.0 + 0.37 * i) / size;
    const Vector3d across = std::cos(turn) * side + std::sin(turn) * up;
    const Vector3d direction = std::cos(slant) * across + std::sin(slant) * along;
    const Vector3d normal = (along - direction.dot(along) * direction).normalized();
    waves[static_cast<std::size_t>(i)] = {number * direction, (strength / kWaves) * normal, 1.7 * i * i};
  }
  return [waves, meanWind](const Vector3d& place, double time) {
    Vector3d sum = Vector3d::Zero();
    for (const Wave& wave : waves)
      sum += std::sin(wave.vector.dot(place - time * meanWind) + wave.phase) * wave.velocity;
    return sum;
  };
}

}  // namespace limber

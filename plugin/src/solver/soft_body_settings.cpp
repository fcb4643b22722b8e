// SPDX-License-Identifier: Zlib
#include <limber/soft_body_settings.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <tuple>
#include <utility>

namespace limber {
namespace {

/// Share of the shortest spring: small compared to the body, large compared to Bullet's margins at 1 m.
constexpr double kRadiusPerSpring = 0.02;

std::string say(const char* name, double value, const char* rule) {
  char text[160];
  std::snprintf(text, sizeof text, "%s is %g, must be %s", name, value, rule);
  return text;
}

struct Check {
  const char* name;
  double value;
  double low, high;  // the smallest and the largest value allowed
  const char* rule;
};

Result<void> firstViolation(const Check* begin, const Check* end) {
  for (const Check* c = begin; c != end; ++c)
    if (!(c->value >= c->low && c->value <= c->high)) return Error{say(c->name, c->value, c->rule)};
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
      return say((name + std::string(".") + "xyz"[i]).c_str(), v[i],
                 std::isfinite(v[i]) ? text.c_str() : "finite");
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
      return say((std::string("scale.") + "xyz"[i]).c_str(), s.scale[i],
                 s.scale[i] == 0.0 ? "other than 0" : "1e-9 or more, or -1e-9 or less");
  const Eigen::Array3d factors = s.scale.array().abs();
  if (factors.maxCoeff() > kMaxScaleRatio * factors.minCoeff())
    return say("largest over smallest axis of scale", factors.maxCoeff() / factors.minCoeff(),
               "at most 1000");
  const double norm = s.rotation.norm();
  if (!(std::abs(norm - 1.0) < 1e-6)) return say("length of rotation", norm, "1");
  return {};
}

Result<void> checkGroups(const std::vector<GroupSettings>& groups) {
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const GroupSettings& g = groups[i];
    const Check checks[] = {
        {"stiffness", g.stiffness, 0, 1e6, "from 0 to 1e6"},
        {"damping", g.damping, 0, 1e6, "from 0 to 1e6"},
        {"limitStrain", g.limitStrain, 1e-6, 1e6, "from 1e-6 to 1e6"},
        {"mass", g.mass, 1e-3, 1e3, "from 1e-3 to 1e3"},
    };
    if (Result<void> valid = firstViolation(std::begin(checks), std::end(checks)); !valid)
      return Error{"groups[" + std::to_string(i) + "]." + valid.error()};
  }
  return {};
}

}  // namespace

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
  const Check checks[] = {
      {"extensionStiffness", s.extensionStiffness, 0, 1e12, "from 0 to 1e12"},
      {"compressionStiffness", s.compressionStiffness, 0, 1e12, "from 0 to 1e12"},
      {"damping", s.damping, 0, 1e12, "from 0 to 1e12"},
      {"collision", static_cast<double>(s.collision), 0, double(Collision::Surface), "one of Collision's"},
      {"totalMass", s.totalMass, 1e-9, 1e9, "from 1e-9 to 1e9"},
      {"volumeModulus", s.volumeModulus.value_or(0.0), 0, 1e15, "from 0 to 1e15"},
      {"pressure", s.pressure, 0, 1e12, "from 0 to 1e12"},
      {"ambientPressure", s.ambientPressure, 0, 1e12, "from 0 to 1e12"},
      {"pointRadius", s.pointRadius.value_or(1.0), 1e-9, 1e4, "from 1e-9 to 1e4"},
      {"friction", s.friction, 0, 1e6, "from 0 to 1e6"},
      {"restitution", s.restitution, 0, 1, "from 0 to 1"},
      {"sleepingSpeed", s.sleepingSpeed, 0, 1e6, "from 0 to 1e6"},
      {"gravityFactor", s.gravityFactor, -1e3, 1e3, "from -1000 to 1000"},
      {"maxPinSpeed", s.maxPinSpeed, 1e-6, 1e6, "from 1e-6 to 1e6"},
      {"stepping.stepper", static_cast<double>(s.stepping.stepper), 0, double(Stepper::BandedNewton),
       "one of Stepper's"},
      {"stepping.minSubsteps", static_cast<double>(s.stepping.minSubsteps), 1, 1e4, "from 1 to 10000"},
      {"stepping.periodTolerance", s.stepping.periodTolerance, 1e-8, 1, "from 1e-8 to 1"},
      {"stepping.tolerance", s.stepping.tolerance, 0, 1e6, "from 0 to 1e6"},
      {"stepping.relativeTolerance", s.stepping.relativeTolerance, 0, 1e6, "from 0 to 1e6"},
      {"stepping.maxSubsteps", static_cast<double>(s.stepping.maxSubsteps), 0, 1e4, "from 0 to 10000"},
      {"elasticLimit.stiffenStrain", s.elasticLimit.stiffenStrain, 0, 1e6, "from 0 to 1e6"},
      {"elasticLimit.stiffenFactor", s.elasticLimit.stiffenFactor, 1, 1e6, "from 1 to 1e6"},
      {"elasticLimit.yieldStrain", s.elasticLimit.yieldStrain, 0, 1e6, "from 0 to 1e6"},
      {"elasticLimit.yieldMaximum", s.elasticLimit.yieldMaximum, 0, 0.999, "from 0 to 0.999"},
      {"elasticLimit.breakStrain", s.elasticLimit.breakStrain, 0, 1e6, "from 0 to 1e6"},
  };
  if (Result<void> valid = firstViolation(std::begin(checks), std::end(checks)); !valid) return valid;
  if (Result<void> valid = validate(s.flow); !valid) return Error{"flow." + valid.error()};
  return checkGroups(s.groups);
}

Result<void> validate(const SpringSettings& s) {
  const Check checks[] = {
      {"restLength", s.restLength.value_or(0.0), 0, 1e6, "from 0 to 1e6"},
      {"stiffness", s.stiffness, 0, 1e12, "from 0 to 1e12"},
      {"damping", s.damping, 0, 1e12, "from 0 to 1e12"},
      {"breakForce", s.breakForce, 0, 1e18, "from 0 to 1e18"},
      {"action", static_cast<double>(s.action), 0, double(SpringAction::CompressionOnly),
       "one of SpringAction's"},
  };
  return firstViolation(std::begin(checks), std::end(checks));
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

}  // namespace limber

// SPDX-License-Identifier: Zlib
// Checks the settings of air, water and drag, and makes gusts.
#include <limber/surroundings.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <string>

namespace limber {
namespace {

using Eigen::Vector3d;

/// m/s, thirty times the speed of sound.
constexpr double kMaxFlowSpeed = 1e4;

std::string outside(const char* field, double value, const char* rule) {
  char text[160];
  std::snprintf(text, sizeof text, "%s is %g, must be %s", field, value, rule);
  return text;
}

/// Returns an empty string if the value is allowed.
std::string checkRange(const char* field, double value, double low, double high, const char* rule) {
  return value >= low && value <= high ? std::string() : outside(field, value, rule);
}

std::string checkFlowVelocity(const char* field, const Vector3d& v) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(std::abs(v[axis]) <= kMaxFlowSpeed))
      return outside((std::string(field) + "." + "xyz"[axis]).c_str(), v[axis], "from -1e4 to 1e4");
  return {};
}

Result<void> firstReason(std::initializer_list<std::string> reasons) {
  for (const std::string& reason : reasons)
    if (!reason.empty()) return Error{reason};
  return {};
}

}  // namespace

Result<void> validate(const Air& air) {
  return firstReason(
      {checkRange("density", air.density, 0.0, 1e4, "from 0 to 1e4"), checkFlowVelocity("wind", air.wind)});
}

Result<void> validate(const Water& water) {
  return firstReason({checkRange("density", water.density, 1e-9, 1e5, "from 1e-9 to 1e5"),
                      checkRange("level", water.level, -1e6, 1e6, "from -1e6 to 1e6"),
                      checkFlowVelocity("flow", water.flow)});
}

Result<void> validate(const FlowCoefficients& flow) {
  return firstReason({checkRange("drag", flow.drag.value_or(0.0), 0.0, 100.0, "from 0 to 100"),
                      checkRange("lift", flow.lift.value_or(0.0), 0.0, flow.drag ? *flow.drag : 1.0,
                                 flow.drag ? "from 0 to drag" : "from 0 to 1 without drag"),
                      checkRange("friction", flow.friction, 0.0, 100.0, "from 0 to 100"),
                      checkRange("linearDrag", flow.linearDrag.value_or(0.0), 0.0, 1e6, "from 0 to 1e6"),
                      checkRange("displacedVolume", flow.displacedVolume, 0.0, 1e9, "from 0 to 1e9")});
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

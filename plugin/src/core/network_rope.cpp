// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>

#include <cmath>
#include <string>
#include <utility>

namespace limber {
namespace {

/// What takes gigabytes is a mistake.
constexpr std::uint32_t kMostRopePoints = 10'000'000;

std::string check(const RopeSettings& settings) {
  if (!std::isfinite(settings.length) || settings.length <= 0.0)
    return "the length of a rope must be above 0";
  if (settings.segments == 0) return "a rope needs at least one segment";
  if (settings.segments > kMostRopePoints) return "a rope of that many segments has more than ten million points";
  if (!std::isfinite(settings.bendingScale) || settings.bendingScale < 0.0) {
    return "the bending scale of a rope must be 0 or more";
  }
  return {};
}

std::vector<Eigen::Vector3d> ropePoints(double length, std::uint32_t segments) {
  std::vector<Eigen::Vector3d> points;
  for (std::uint32_t i = 0; i <= segments; ++i) points.emplace_back(length * i / segments, 0.0, 0.0);
  return points;
}

/// Visits the points in order and joins each to those after it, so that the springs come out sorted.
///
///     o---o---o---o   structural
///     o-------o       bending: skips one point
std::vector<NetworkSpring> ropeSprings(std::uint32_t segments, double bendingScale) {
  std::vector<NetworkSpring> springs;
  for (std::uint32_t i = 0; i < segments; ++i) {
    springs.push_back({i, i + 1, SpringKind::Structural, 1.0});
    if (bendingScale > 0.0 && i + 1 < segments)
      springs.push_back({i, i + 2, SpringKind::Bending, bendingScale});
  }
  return springs;
}

}  // namespace

Result<SharedNetwork> buildRope(const RopeSettings& settings) {
  if (std::string reason = check(settings); !reason.empty()) return Error{std::move(reason)};
  auto network = std::make_shared<SpringNetwork>();
  network->kind = NetworkKind::Rope;
  network->restPoints = ropePoints(settings.length, settings.segments);
  network->massShares.assign(settings.segments + 1, 1.0 / (settings.segments + 1.0));
  network->springs = ropeSprings(settings.segments, settings.bendingScale);
  return SharedNetwork(std::move(network));
}

}  // namespace limber

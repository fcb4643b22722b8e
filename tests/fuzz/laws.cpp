// SPDX-License-Identifier: Zlib
#include "fuzz/laws.h"

#include "fuzz/bullet_shapes.h"
#include "fuzz/dice.h"
#include "fuzz/networks.h"

#include "mesh/triangle_bvh.h"

#include <set>

namespace limber::fuzz {
namespace {

using Eigen::Vector3d;

std::string frameText(std::size_t i) { return "frame " + std::to_string(static_cast<long>(i) - 1) + ": "; }

/// Plays the story again, on more threads than the machine may have: the addresses differ and the order of
/// the work, all bits of the state must be the same.
std::optional<Failure> checkRepeats(const Story& story, const Run& first) {
  PlayOptions onThreads;
  onThreads.threads = 3;
  const Run again = play(story, onThreads);
  for (std::size_t i = 0; i < std::min(first.frames.size(), again.frames.size()); ++i)
    if (first.frames[i].hash != again.frames[i].hash)
      return Failure{"repeats", frameText(i) + "another state when the story is played again"};
  if (again.failure) return Failure{"repeats", "only the second time: " + again.failure->law};
  return {};
}

/// Whether soft bodies act on rigid ones without contact: through springs, anchors, joints, filters or
/// callbacks. Water and fields push them faster than softIsNearRigid() expects.
bool actsFromAfar(const Story& story) {
  std::set<int> softs;
  for (const Step& s : story.steps)
    if (s.kind == Kind::Soft) softs.insert(s.id);
  for (const Step& s : story.steps)
    if ((s.kind == Kind::Joint && (softs.count(s.whole("a")) || softs.count(s.whole("b")))) ||
        s.kind == Kind::Spring || s.kind == Kind::Attach || s.kind == Kind::Vehicle ||
        s.kind == Kind::Character || s.kind == Kind::OverlapFilter || s.kind == Kind::Surround ||
        s.kind == Kind::Change || s.phase == Phase::Listener)
      return true;
  return false;
}

/// Checks that rigid bodies move as in the world without soft bodies, until a soft body comes near one. The
/// check ends when several rigid pairs touch: other objects change the order in which Bullet solves them, and
/// ten iterations then give another result.
std::optional<Failure> checkTwin(const Run& run, const Run& twin) {
  for (std::size_t i = 0; i < std::min(run.frames.size(), twin.frames.size()); ++i) {
    if (twin.frames[i].rigidPairs > 1) break;
    for (const auto& [id, pose] : twin.frames[i].rigid) {
      const auto it = run.frames[i].rigid.find(id);
      if (it == run.frames[i].rigid.end() || !pose.dynamic) continue;
      const double distance = (it->second.position - pose.position).norm();
      // m, float precision in Bullet
      if (distance > 1e-5)
        return Failure{"twin", frameText(i) + "rigid body " + std::to_string(id) + " is " +
                                   std::to_string(distance) +
                                   " m from its twin before a soft body came near any"};
    }
    if (run.frames[i].near) break;
  }
  return {};
}

/// Returns the lowest energy (J) of the frames `frame` to `frame + frames`, a tenth of a second or more.
/// Contact forces change the velocities half a substep late, so the energy fluctuates during impacts.
double lastingEnergy(const Run& run, std::size_t frame, std::size_t frames) {
  double minimum = run.frames[frame].energy;
  for (std::size_t i = frame; i <= frame + frames; ++i) minimum = std::min(minimum, run.frames[i].energy);
  return minimum;
}

/// Checks that no energy is created. Allowed are `fraction` of the initial energy, the gain of the rigid
/// bodies in a world without soft ones, and 1 mJ for bodies at rest.
std::optional<Failure> checkEnergy(const Story& story, const Run& run, const Run& twin, double fraction) {
  const double start = run.frames.front().energy, dt = story.first(Kind::Time)["dt"];
  const auto window = static_cast<std::size_t>(std::max(3.0, std::ceil(0.1 / dt)));
  double allowance = fraction * std::abs(start) + 1e-3;
  for (std::size_t i = 0; i + window < std::min(run.frames.size(), twin.frames.size()); ++i) {
    allowance = std::max(
        allowance, fraction * std::abs(start) + 1e-3 + 2.0 * (twin.frames[i].energy - twin.frames[0].energy));
    const double energy = lastingEnergy(run, i, window);
    if (energy - start > allowance)
      return Failure{"energy", frameText(i) + std::to_string(energy) + " J of " + std::to_string(start)};
  }
  return {};
}

/// Returns the story with substeps at most a quarter as long.
Story inShorterSubsteps(Story story) {
  for (Step& s : story.steps)
    if (s.kind == Kind::Soft)
      s.set("period", s["period"] / 16.0)
          .set("at-least", 4.0 * s["at-least"])
          .set("budget", 0)
          .set("search", 0.05);
  return story;
}

/// Verlet conserves an energy that differs from this one by up to (omega dt)^2 / 4 of an oscillation's
/// energy, on the average by half of that. At a period error (omega dt)^2 / 24 of 4 % this is a quarter. So
/// an impact that converts most of the fall energy into the fastest oscillations shows a gain that is not
/// real. This error falls with dt^2; energy that is really created does not. So the check is repeated with
/// shorter substeps.
std::optional<Failure> checkEnergy(const Story& story, const Run& run, const Run& twin) {
  auto failure = checkEnergy(story, run, twin, 0.02);
  if (!failure || checkEnergy(story, run, twin, 0.12)) return failure;
  const Story shorter = inShorterSubsteps(story);
  const Run again = play(shorter);
  return again.failure ? again.failure : checkEnergy(shorter, again, twin, 0.02);
}

/// m, depth allowed below the floor: the floor's own margins, and the penetration of a box edge into a
/// segment whose ends lie on the box.
const double kFloorTolerance = 0.03;

/// Checks that no point of a soft body that starts above the floor gets below it while the body is over it.
/// Bodies without continuous collision are exempt.
std::optional<Failure> checkFloor(const Story& story, const Run& run) {
  const Step floor = story.first(Kind::Floor);
  if (floor.id == 0) return {};
  const double extent = floor["extent"] - 0.2;
  std::map<int, bool> exempt;
  for (const Step& s : story.steps)
    if (s.kind == Kind::Soft) exempt[s.id] = s["ccd"] == 0.0;
  for (std::size_t i = 0; i < run.frames.size(); ++i)
    for (const auto& [id, points] : run.frames[i].soft) {
      if (points.size() == 0) continue;
      const Eigen::Matrix3Xd local = points.colwise() - floor.vec("position");
      exempt[id] = exempt[id] || local.row(0).cwiseAbs().maxCoeff() > extent ||
                   local.row(2).cwiseAbs().maxCoeff() > extent;
      const double lowest = local.row(1).minCoeff();
      if (i == 0 && lowest < 0.0) exempt[id] = true;
      if (!exempt[id] && lowest < -kFloorTolerance)
        return Failure{"floor", frameText(i) + "soft body " + std::to_string(id) + " is " +
                                    std::to_string(-lowest) + " m below the floor"};
    }
  return {};
}

Eigen::AlignedBox3d boxOf(const Eigen::Matrix3Xd& points) {
  return {points.rowwise().minCoeff(), points.rowwise().maxCoeff()};
}

/// Whether each edge of the surface has a triangle on either side.
bool isClosed(const std::vector<Triangle>& surface) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const Triangle& t : surface)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
      sides[{a, b}] += t[k] < t[(k + 1) % 3] ? 1 : -1;
    }
  return !surface.empty() &&
         std::all_of(sides.begin(), sides.end(), [](const auto& e) { return e.second == 0; });
}

/// Returns the radius (m) of the largest ball about the origin within a convex shape; 0 for others.
double innerRadius(const btCollisionShape& shape) {
  if (!shape.isConvex()) return 0.0;
  const auto& convex = static_cast<const btConvexShape&>(shape);
  double radius = 1e9;
  Dice dice(1);
  for (int i = 0; i < 500; ++i) {
    const btVector3 direction = toBt(dice.ball(1.0).normalized());
    radius = std::min(radius, double(direction.dot(convex.localGetSupportingVertex(direction))));
  }
  return std::max(radius, 0.0);
}

/// Checks that no closed surface of a soft body encloses the centre of a rigid body that was outside at the
/// start.
std::optional<Failure> checkPierced(const Story& story, const Run& run) {
  for (const Step& s : story.steps) {
    if (s.kind != Kind::Soft || s["ccd"] == 0.0 || s.choice("collision") == "points") continue;
    const SpringNetwork& network = *networkNamed(s.choice("network"));
    if (!isClosed(network.surface)) continue;
    for (const Step& r : story.steps) {
      if (r.kind != Kind::Rigid) continue;
      OwnedShape shape = makeShape(r.choice("shape"), r.vec("size"), r.whole("variant"));
      // m, smaller balls are near the surface when they touch it
      if (innerRadius(*shape.shape) < 0.01) continue;
      for (std::size_t i = 0; i < run.frames.size(); ++i) {
        const auto soft = run.frames[i].soft.find(s.id);
        const auto rigid = run.frames[i].rigid.find(r.id);
        if (soft == run.frames[i].soft.end() || rigid == run.frames[i].rigid.end()) break;
        const Vector3d centre = rigid->second.position;
        Eigen::AlignedBox3d box = boxOf(soft->second);
        if (i == 0 && box.exteriorDistance(centre) < shape.radius + 0.1) break;
        if (!box.contains(centre)) continue;
        std::vector<Vector3d> points;
        for (const auto& p : soft->second.colwise()) points.emplace_back(p);
        if (std::abs(TriangleBvh(points, network.surface).windingNumber(centre)) > 0.5)
          return Failure{"pierced", frameText(i) + "soft body " + std::to_string(s.id) +
                                        " encloses the centre of rigid body " + std::to_string(r.id)};
      }
    }
  }
  return {};
}

/// Whether all soft bodies start above the floor and apart from each other. No law says how overlapping
/// bodies separate.
bool startsClear(const Story& story, const Frame& start) {
  const bool floor = story.first(Kind::Floor).id != 0;
  // m, larger than the radius of any point
  const double margin = 0.08;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const auto& [id, points] : start.soft) {
    if (points.size() == 0) continue;
    Eigen::AlignedBox3d box = boxOf(points);
    if (floor && box.min().y() < margin) return false;
    box.min().array() -= margin;
    box.max().array() += margin;
    for (const Eigen::AlignedBox3d& other : boxes)
      if (other.intersects(box)) return false;
    boxes.push_back(box);
  }
  return !start.near;
}

/// Checks the laws of closed and gentle stories, which have no source of energy.
std::optional<Failure> checkClosed(const Story& story, const Run& run, const Run& twin, const Lawbook& laws) {
  if (!startsClear(story, run.frames.front())) return {};
  if (auto failure = checkFloor(story, run)) return failure;
  if (auto failure = checkPierced(story, run)) return failure;
  if (auto failure = checkEnergy(story, run, twin)) return failure;
  if (story.first(Kind::World).choice("promise") == "gentle") return checkInvariance(story, run, laws);
  return {};
}

}  // namespace

void prepare(const Story& story) {
  for (const Step& s : story.steps)
    if (s.kind == Kind::Soft) networkNamed(s.choice("network"));
}

std::optional<Failure> checkStory(const Story& story, const Lawbook& laws) {
  PlayOptions options;
  options.threads = laws.threads;
  const Run run = play(story, options);
  PlayOptions withoutSoft;
  withoutSoft.softBodies = false;
  if (run.failure) {
    // if Bullet alone fails in the same manner, the failure is not Limber's
    const Run twin = play(story, withoutSoft);
    if (twin.failure && twin.failure->law == run.failure->law) return {};
    return run.failure;
  }
  const bool wild = story.first(Kind::World).choice("promise") == "wild";
  if (laws.once)
    return wild || !startsClear(story, run.frames.front()) ? std::nullopt : checkFloor(story, run);
  if (auto failure = checkRepeats(story, run)) return failure;
  const Run twin = play(story, withoutSoft);
  if (twin.failure) return {};
  if (!actsFromAfar(story))
    if (auto failure = checkTwin(run, twin)) return failure;
  return wild ? std::nullopt : checkClosed(story, run, twin, laws);
}

}  // namespace limber::fuzz

// SPDX-License-Identifier: Zlib
#include "fuzz/laws.h"

#include "fuzz/networks.h"

namespace limber::fuzz {
namespace {

std::string frameText(std::size_t i) { return "frame " + std::to_string(static_cast<long>(i) - 1) + ": "; }

/// The same story again: other addresses, the same bits.
std::optional<Failure> checkRepeats(const Story& story, const Run& first) {
  const Run again = play(story);
  for (std::size_t i = 0; i < std::min(first.frames.size(), again.frames.size()); ++i)
    if (first.frames[i].hash != again.frames[i].hash)
      return Failure{"repeats", frameText(i) + "another state when the story is played again"};
  if (again.failure) return Failure{"repeats", "only the second time: " + again.failure->law};
  return {};
}

/// Joints and springs between soft and rigid bodies act from afar.
bool actsFromAfar(const Story& story) {
  for (const Step& s : story.steps)
    if (s.kind == Kind::Spring || s.kind == Kind::Attach || s.kind == Kind::Vehicle ||
        s.kind == Kind::Character || s.kind == Kind::OverlapFilter || s.phase == Phase::Listener)
      return true;
  return false;
}

/// Rigid bodies move as they would without soft ones, until one of these comes near any. Where several pairs
/// touch, Bullet solves them in an order that other objects change, and ten iterations end elsewhere.
std::optional<Failure> checkTwin(const Run& run, const Run& twin) {
  for (std::size_t i = 0; i < std::min(run.frames.size(), twin.frames.size()); ++i) {
    if (twin.frames[i].rigidPairs > 1) break;
    for (const auto& [id, pose] : twin.frames[i].rigid) {
      const auto it = run.frames[i].rigid.find(id);
      if (it == run.frames[i].rigid.end() || !pose.dynamic) continue;
      const double off = (it->second.position - pose.position).norm();
      // floats, of metres
      if (off > 1e-5)
        return Failure{"twin", frameText(i) + "rigid body " + std::to_string(id) + " is " +
                                   std::to_string(off) + " m from its twin before a soft body came near any"};
    }
    if (run.frames[i].near) break;
  }
  return {};
}

/// J, what remains of the energy at a frame over the next tenth of a second. Velocities lag by half a substep
/// of contact forces, which shows as energy that comes and goes while bodies hit one another.
double lastingEnergy(const Run& run, std::size_t frame, std::size_t frames) {
  double least = run.frames[frame].energy;
  for (std::size_t i = frame; i <= frame + frames; ++i) least = std::min(least, run.frames[i].energy);
  return least;
}

/// A joule that comes from nowhere. What is allowed: `part` of the energy of the start; what the rigid bodies
/// gain without soft ones; and a millijoule for bodies at rest.
std::optional<Failure> checkEnergy(const Story& story, const Run& run, const Run& twin, double part) {
  const double start = run.frames.front().energy, dt = story.first(Kind::Time)["dt"];
  const auto lasting = static_cast<std::size_t>(std::max(3.0, std::ceil(0.1 / dt)));
  double allowance = part * std::abs(start) + 1e-3;
  for (std::size_t i = 0; i + lasting < std::min(run.frames.size(), twin.frames.size()); ++i) {
    allowance = std::max(
        allowance, part * std::abs(start) + 1e-3 + 2.0 * (twin.frames[i].energy - twin.frames[0].energy));
    const double energy = lastingEnergy(run, i, lasting);
    if (energy - start > allowance)
      return Failure{"energy", frameText(i) + std::to_string(energy) + " J of " + std::to_string(start)};
  }
  return {};
}

/// In substeps a quarter as long, at least.
Story inShorterSubsteps(Story story) {
  for (Step& s : story.steps)
    if (s.kind == Kind::Soft) s.set("period", s["period"] / 16.0).set("budget", 0);
  return story;
}

/// Verlet keeps not this energy but one that differs by up to (omega dt)^2 / 4 of an oscillation's, which at
/// a period error (omega dt)^2 / 24 of 4 % is a quarter, and on the average half of that. So a hit that turns
/// most of what was fall into the fastest oscillations shows energy that is none. It falls with dt^2; what is
/// made stays.
std::optional<Failure> checkEnergy(const Story& story, const Run& run, const Run& twin) {
  auto failure = checkEnergy(story, run, twin, 0.02);
  if (!failure || checkEnergy(story, run, twin, 0.12)) return failure;
  const Story shorter = inShorterSubsteps(story);
  const Run again = play(shorter);
  return again.failure ? again.failure : checkEnergy(shorter, again, twin, 0.02);
}

/// m: the floor's own margins, and what the edge of a box may cut into a segment whose ends lie on it.
const double kCut = 0.03;

/// No point of a soft body that starts above the floor is below it, as long as the body is over it. Bodies
/// without continuous collision are left out.
std::optional<Failure> checkFloor(const Story& story, const Run& run) {
  const Step floor = story.first(Kind::Floor);
  if (floor.id == 0) return {};
  const double extent = floor["extent"] - 0.2;
  std::map<int, bool> away;
  for (const Step& s : story.steps)
    if (s.kind == Kind::Soft) away[s.id] = s["ccd"] == 0.0;
  for (std::size_t i = 0; i < run.frames.size(); ++i)
    for (const auto& [id, points] : run.frames[i].soft) {
      if (points.size() == 0) continue;
      const Eigen::Matrix3Xd local = points.colwise() - floor.vec("position");
      away[id] = away[id] || local.row(0).cwiseAbs().maxCoeff() > extent ||
                 local.row(2).cwiseAbs().maxCoeff() > extent;
      const double lowest = local.row(1).minCoeff();
      if (i == 0 && lowest < 0.0) away[id] = true;
      if (!away[id] && lowest < -kCut)
        return Failure{"floor", frameText(i) + "soft body " + std::to_string(id) + " is " +
                                    std::to_string(-lowest) + " m below the floor"};
    }
  return {};
}

Eigen::AlignedBox3d boxOf(const Eigen::Matrix3Xd& points) {
  return {points.rowwise().minCoeff(), points.rowwise().maxCoeff()};
}

/// Whether all soft bodies start above the floor and clear of each other: what overlaps has to be parted, and
/// how is nobody's law.
bool startsClear(const Story& story, const Frame& start) {
  const bool floor = story.first(Kind::Floor).id != 0;
  // m, more than any point's radius
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

/// Closed and gentle stories have no source of energy.
std::optional<Failure> checkClosed(const Story& story, const Run& run, const Run& twin, const Lawbook& laws) {
  if (!startsClear(story, run.frames.front())) return {};
  if (auto failure = checkFloor(story, run)) return failure;
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
  const Run run = play(story);
  PlayOptions withoutSoft;
  withoutSoft.softBodies = false;
  if (run.failure) {
    // where Bullet alone does the same nothing is learned
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

// SPDX-License-Identifier: Zlib
// Variants of a scene that must give the same result: moved, rotated, mirrored, in other units, on a floor in
// pieces, ...
#include "fuzz/bullet_shapes.h"
#include "fuzz/laws.h"

#include <Eigen/Geometry>

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

namespace limber::fuzz {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// x' = length * rotation x + shift; `rotation` is orthogonal and may mirror.
struct Motion {
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d shift = Vector3d::Zero();
  double length = 1.0;  ///< factor of units

  Vector3d operator()(const Vector3d& x) const { return length * (rotation * x) + shift; }
};

/// A variant of a story, and the motion of its points relative to the original.
struct Law {
  std::string name;
  Story story;
  Motion motion;
  int framesPerFrame = 1;
  double allowance = 0.0;  ///< m, in addition to the growth of round-off; explained where it is set
  double allowancePerFrame = 0.0;
  double extent = HUGE_VAL;  ///< m, half the side of the floor; beyond it the results may differ
};

Matrix3d rotationMatrix(const Vector3d& axial) {
  const double angle = axial.norm();
  return angle == 0.0 ? Matrix3d(Matrix3d::Identity())
                      : Eigen::AngleAxisd(angle, axial / angle).toRotationMatrix();
}

Vector3d movedField(const Field& field, const Vector3d& v, const Motion& by) {
  switch (field.role) {
    case Role::Place:
      return by(v);
    case Role::Vector:
      return by.rotation * v;
    case Role::Axial:
      return by.rotation.determinant() * (by.rotation * v);
    case Role::Rotation: {
      Matrix3d rotated = by.rotation * rotationMatrix(v);
      // a mirrored body has a mirrored scale
      if (by.rotation.determinant() < 0.0) rotated = rotated * Vector3d(-1, 1, 1).asDiagonal();
      const Eigen::AngleAxisd angle(rotated);
      return angle.angle() * angle.axis();
    }
    default:
      return v;
  }
}

Story moved(Story story, const Motion& by) {
  for (Step& s : story.steps) {
    for (const Field& field : fieldsOf(s.kind)) {
      if (field.size() != 3 || field.role == Role::Sizes) continue;
      const Vector3d v = Vector3d::Map(s.values.data() + field.offset);
      s.set(field.name.c_str(), movedField(field, v, by));
    }
    if (by.rotation.determinant() < 0.0 && s.kind == Kind::Soft)
      s.set("scale", Vector3d(-s.vec("scale").x(), s.vec("scale").y(), s.vec("scale").z()));
  }
  return story;
}

/// Converts to other units: `kg` units of mass in a kilogram, `m` of length in a metre, `s` of time in a
/// second.
Story rescaled(Story story, double kg, double m, double s) {
  for (Step& step : story.steps) {
    for (const Field& field : fieldsOf(step.kind)) {
      const double factor =
          std::pow(kg, field.unit.kg) * std::pow(m, field.unit.m) * std::pow(s, field.unit.s);
      for (std::size_t i = 0; i < field.size(); ++i) {
        double& value = step.values[field.offset + i];
        // a negative volume modulus means "automatic"
        if (field.role != Role::Choice && value >= 0.0)
          value *= factor;
        else if (field.role >= Role::Place)
          value *= factor;
      }
    }
    if (step.kind == Kind::Soft) step.set("scale", step.vec("scale") * m);
  }
  return story;
}

template <class Change>
Story changed(Story story, Change change) {
  for (Step& s : story.steps) change(s);
  return story;
}

std::vector<Step>::iterator firstSoft(Story& story) {
  return std::find_if(story.steps.begin(), story.steps.end(),
                      [](const Step& s) { return s.kind == Kind::Soft; });
}

Story inOtherOrder(Story story) {
  std::stable_partition(story.steps.begin(), story.steps.end(),
                        [](const Step& s) { return s.kind != Kind::Soft; });
  const auto first = firstSoft(story);
  std::reverse(first, story.steps.end());
  return story;
}

Story withFarObjects(Story story) {
  Step soft(Kind::Soft);
  soft.id = 901;
  soft.set("position", Vector3d(70, 40, 0));
  Step rigid(Kind::Rigid);
  rigid.id = 902;
  rigid.set("position", Vector3d(0, 40, 70)).set("spin", Vector3d(1, 2, 3));
  const auto first = firstSoft(story);
  story.steps.insert(story.steps.insert(first, soft), rigid);
  return story;
}

Story withQueries(Story story) {
  const int frames = story.first(Kind::Time).whole("frames");
  std::vector<int> softs;
  for (const Step& s : story.steps)
    if (s.kind == Kind::Soft) softs.push_back(s.id);
  for (int i = 0; i < frames; i += 3) {
    Step ray(Kind::Ray, i);
    ray.set("from", Vector3d(0, 5, 0))
        .set("to", Vector3d(0.1 * i, 0, 0))
        .choose("what", "all")
        .set("of", softs[0]);
    Step look(Kind::Look, i);
    look.set("of", softs[static_cast<std::size_t>(i) % softs.size()]).set("fraction", 0.5);
    Step draw(Kind::Look, i);
    draw.choose("what", "draw");
    for (const Step& step : {ray, look, draw}) story.steps.push_back(step);
  }
  return story;
}

std::size_t softBodies(const Story& story) {
  return static_cast<std::size_t>(std::count_if(story.steps.begin(), story.steps.end(),
                                                [](const Step& s) { return s.kind == Kind::Soft; }));
}

void addMotions(const Story& story, std::vector<Law>& laws) {
  Motion shift;
  shift.shift = Vector3d(3, 0, -5);
  laws.push_back({"moved", moved(story, shift), shift});
  Motion rotation;
  rotation.rotation = rotationMatrix(Vector3d(0, 0.5 * 3.14159265358979323846, 0)).array().round().matrix();
  laws.push_back({"rotated", moved(story, rotation), rotation});
  Motion mirror;
  mirror.rotation = Vector3d(-1, 1, 1).asDiagonal();
  laws.push_back({"mirrored", moved(story, mirror), mirror});
  Motion units;
  units.length = 2.0;
  // powers of two change no mantissa; Bullet's absolute margins have no effect here, as a box's margin is
  // inside it
  laws.push_back({"units", rescaled(story, 4.0, 2.0, 1.0), units});
}

void addFloors(const Story& story, std::vector<Law>& laws) {
  const std::string kind = story.first(Kind::Floor).choice("kind");
  const char* const kinds[] = {"plane", "box",      "mesh",  "height-field",
                               "boxes", "compound", "hulls", "scaled-mesh"};
  const auto seed = static_cast<std::size_t>(story.seed);
  // two kinds for each seed; over the seeds all kinds are used
  for (const std::size_t i : {seed % 8, (seed / 8 + 3) % 8}) {
    if (kinds[i] == kind) continue;
    const Story other = changed(story, [&](Step& s) {
      if (s.kind == Kind::Floor) s.choose("kind", kinds[i]);
    });
    // m: convex margins and the float precision of the narrowphase
    Law law{std::string("floor-of-") + kinds[i], other, Motion(), 1, 1e-3};
    law.extent = story.first(Kind::Floor)["extent"];
    laws.push_back(law);
  }
}

/// Returns the largest distance (m) of a point from its expected position. It is infinite if the other frame
/// lacks a body or has it with another number of points.
double distance(const Frame& frame, const Frame& other, const Motion& motion) {
  double worst = 0.0;
  for (const auto& [id, points] : frame.soft) {
    const auto it = other.soft.find(id);
    if (it == other.soft.end() || it->second.cols() != points.cols()) return HUGE_VAL;
    for (Eigen::Index i = 0; i < points.cols(); ++i)
      worst = std::max(worst, (it->second.col(i) - motion(points.col(i))).norm() / motion.length);
  }
  return worst;
}

/// Returns the highest speed (m/s) of any point.
double highestSpeed(const Run& run, double dt) {
  double maxDistance = 0.0;
  for (std::size_t i = 1; i < run.frames.size(); ++i)
    maxDistance = std::max(maxDistance, distance(run.frames[i], run.frames[i - 1], Motion()));
  return maxDistance / dt;
}

/// Returns the story with 30 or more substeps per period of the stiffest oscillation, because the errors that
/// tolerances allow differ from tick to tick. Continuous collision is on: without it, a contact that was not
/// predicted at the start of a tick is found only at the start of the next one. With `shorter` as factor
/// there are so many times as many, also of soft bodies, which have no more than the least number.
Story withFineSubsteps(Story story, double shorter = 1.0) {
  return changed(std::move(story), [=](Step& s) {
    if (s.kind != Kind::Soft) return;
    s.set("period", 2e-3 / (shorter * shorter)).set("at-least", shorter * s["at-least"]);
    s.set("tolerance", 0).set("relative", 0).set("budget", 0).set("search", 0.05).set("ccd", 1);
  });
}

Story inHalfTicks(Story story) {
  return changed(std::move(story), [](Step& s) {
    if (s.kind == Kind::Time)
      s.set("dt", s["dt"] / 2).set("fixed", s["fixed"] / 2).set("frames", s["frames"] * 2);
  });
}

/// Adds the steps that laws change, with standard values, if the story lacks them.
Story complete(Story story) {
  for (const Kind kind : {Kind::Time, Kind::World})
    if (std::none_of(story.steps.begin(), story.steps.end(), [&](const Step& s) { return s.kind == kind; }))
      story.steps.insert(story.steps.begin(), Step(kind));
  return story;
}

std::vector<Law> lawsFor(const Story& story) {
  std::vector<Law> laws;
  addMotions(story, laws);
  if (story.first(Kind::Floor).id) {
    addFloors(story, laws);
    // m: objects that touch it never sleep, as in "awake" below
    laws.push_back({"kinematic-floor",
                    changed(story,
                            [](Step& s) {
                              if (s.kind == Kind::Floor) s.choose("motion", "kinematic");
                            }),
                    Motion(), 1, 2e-3});
  }
  if (softBodies(story) > 1) {
    laws.push_back({"order", inOtherOrder(story), Motion()});
    bool second = false;
    laws.push_back({"two-systems",
                    changed(story,
                            [&](Step& s) {
                              if (s.kind == Kind::World) s.set("systems", 2);
                              if (s.kind != Kind::Soft) return;
                              s.set("system", second);
                              second = !second;
                            }),
                    Motion()});
  }
  laws.push_back({"far-others", withFarObjects(story), Motion()});
  laws.push_back({"looked-at", withQueries(story), Motion()});
  laws.push_back({"awake",
                  changed(story,
                          [](Step& s) {
                            if (s.kind == Kind::Soft) s.set("sleeping-speed", 0);
                          }),
                  Motion(), 1, 2e-3});
  return laws;
}

/// Whether all points are over a floor around `middle`.
bool isOver(const Frame& frame, const Eigen::Vector3d& middle, double extent) {
  // m, the width of the rim where the floor's edge may be touched
  const double margin = 0.2;
  for (const auto& [id, points] : frame.soft)
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const Vector3d offset = (points.col(i) - middle).cwiseAbs();
      if (std::max(offset.x(), offset.z()) > extent - margin) return false;
    }
  return true;
}

/// m, displacement of every body at the start, which shows how differences grow in this story.
const double kNudge = 1e-6;
/// Number of nudges, each in other directions: a single one may miss the direction to which the story is
/// sensitive. Before a law counts as broken, more nudges are tried.
const int kNudges = 3, kMoreNudges = 16;
/// Round-off and the order of sums cause smaller differences than the nudge, but at other points. So the
/// growth of a nudge is only a sample, and is multiplied by a factor. Above kVisible results are not compared
/// any more.
const double kNudgeFactor = 100.0, kSubstepFactor = 10.0, kVisible = 1e-4;

std::optional<Failure> compare(const Law& law, const Run& run, const Run& other,
                               const std::vector<double>& allowed) {
  const std::string name = "law-" + law.name;
  if (other.failure) return Failure{name, other.failure->law + ", " + other.failure->detail};
  const auto step = static_cast<std::size_t>(law.framesPerFrame);
  const Vector3d middle = law.story.first(Kind::Floor).vec("position");
  for (std::size_t i = 0; i < run.frames.size() && i * step < other.frames.size(); ++i) {
    if (!isOver(run.frames[i], middle, law.extent)) return {};
    const double error = distance(run.frames[i], other.frames[i * step], law.motion);
    if (error > law.allowance + double(i) * law.allowancePerFrame + allowed[i])
      return Failure{name, "frame " + std::to_string(static_cast<long>(i) - 1) + ": " +
                               std::to_string(error) + " m off, round-off may make " +
                               std::to_string(1e6 * allowed[i]) + "e-6"};
  }
  return {};
}

/// Returns for each frame the largest distance (m) between the two runs so far.
std::vector<double> growth(const Run& run, const Run& other) {
  std::vector<double> growthSoFar;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const double error =
        i < other.frames.size() ? distance(run.frames[i], other.frames[i], Motion()) : HUGE_VAL;
    growthSoFar.push_back(std::max(error, growthSoFar.empty() ? 0.0 : growthSoFar.back()));
  }
  return growthSoFar;
}

/// What round-off may cause in a story.
class Sensitivity {
 public:
  Sensitivity(const Story& story, const Run& run) : story_(story), run_(run), grown_(run.frames.size(), 0.0) {
    nudge(kNudges);
  }

  /// Returns the failure of a law, if more nudges do not show that round-off may cause it.
  std::optional<Failure> check(const Law& law, const Run& other) {
    auto failure = compare(law, run_, other, allowed());
    if (!failure || nudges_ > kNudges) return failure;
    nudge(kMoreNudges);
    return compare(law, run_, other, allowed());
  }

 private:
  void nudge(int more) {
    PlayOptions options;
    options.nudge = kNudge;
    for (const int end = nudges_ + more; nudges_ < end; ++nudges_) {
      options.nudgeNumber = nudges_;
      const std::vector<double> growthSoFar = growth(run_, play(story_, options));
      for (std::size_t i = 0; i < grown_.size(); ++i) grown_[i] = std::max(grown_[i], growthSoFar[i]);
    }
  }

  /// Returns for each frame a distance in m.
  std::vector<double> allowed() const {
    std::vector<double> allowed = grown_;
    for (double& error : allowed) error = error < kVisible ? kNudgeFactor * (error + kNudge) : HUGE_VAL;
    return allowed;
  }

  const Story& story_;
  const Run& run_;
  std::vector<double> grown_;  ///< m, per frame
  int nudges_ = 0;
};

/// Checks that half the tick gives the same result. The tick determines when impacts are seen, with an error
/// of up to a substep, and so the speed after them, to 1 %. The change with shorter substeps shows how much
/// such errors grow in this story.
std::optional<Failure> checkHalfTicks(const Story& story) {
  const Story fine = withFineSubsteps(story);
  const Run run = play(fine), finer = play(withFineSubsteps(story, 2.0));
  for (const Run* r : {&run, &finer})
    if (r->failure) return Failure{"law-finely", r->failure->law + ", " + r->failure->detail};
  const double dt = story.first(Kind::Time)["dt"];
  Law law{"half-ticks", inHalfTicks(fine), Motion(), 2};
  law.allowance = 0.1 * dt * highestSpeed(run, dt);
  law.allowancePerFrame = 0.1 * law.allowance;
  std::vector<double> allowed = growth(run, finer);
  for (double& error : allowed) error *= kSubstepFactor;
  return compare(law, run, play(law.story), allowed);
}

/// Plays the story with another program, through files.
Run playWith(const std::string& program, const Story& story) {
  const std::string name =
      std::filesystem::temp_directory_path() / ("limber_fuzz_" + std::to_string(getpid()));
  std::ofstream(name + ".story") << toText(story);
  const std::string call =
      "'" + program + "' --replay " + name + ".story --here --once --frames " + name + ".frames";
  if (std::system((call + " > /dev/null 2>&1").c_str()) != 0)
    std::fprintf(stderr, "%s fails\n", call.c_str());
  const Run run = readFrames(name + ".frames");
  for (const char* end : {".story", ".frames"}) std::filesystem::remove(name + end);
  return run;
}

std::optional<Failure> checkPrecisions(const Story& story, const Run& run, const std::string& beside,
                                       Sensitivity& sensitivity) {
  // m: float precision of Bullet's shapes and narrowphase
  const Law law{"precision", story, Motion(), 1, 1e-4};
  const Run other = playWith(beside, story);
  if (other.frames.size() != run.frames.size())
    return Failure{"law-precision",
                   "the other build stops after " + std::to_string(other.frames.size()) + " frames"};
  return sensitivity.check(law, other);
}

}  // namespace

std::optional<Failure> checkInvariance(const Story& story, const Run& run, const Lawbook& laws) {
  if (softBodies(story) == 0) return {};
  const Story whole = complete(story);
  Sensitivity sensitivity(story, run);
  for (const Law& law : lawsFor(whole))
    if (auto failure = sensitivity.check(law, play(law.story))) return failure;
  if (!laws.beside.empty())
    if (auto failure = checkPrecisions(whole, run, laws.beside, sensitivity)) return failure;
  return checkHalfTicks(whole);
}

// --- files -------------------------------------------------------------------------------------------------

namespace {

template <class T>
void put(std::ostream& file, const T& value) {
  file.write(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
T get(std::istream& file) {
  T value{};
  file.read(reinterpret_cast<char*>(&value), sizeof value);
  return value;
}

}  // namespace

void writeFrames(const Run& run, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  for (const Frame& frame : run.frames) {
    put(file, frame.soft.size());
    for (const auto& [id, points] : frame.soft) {
      put(file, id);
      put(file, points.cols());
      file.write(reinterpret_cast<const char*>(points.data()),
                 points.size() * std::streamsize{sizeof(double)});
    }
  }
}

Run readFrames(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  Run run;
  while (file.peek() != std::char_traits<char>::eof()) {
    Frame& frame = run.frames.emplace_back();
    for (auto bodies = get<std::size_t>(file); bodies > 0 && file; --bodies) {
      Eigen::Matrix3Xd& points = frame.soft[get<int>(file)];
      points.resize(3, get<Eigen::Index>(file));
      file.read(reinterpret_cast<char*>(points.data()), points.size() * std::streamsize{sizeof(double)});
    }
  }
  return run;
}

}  // namespace limber::fuzz

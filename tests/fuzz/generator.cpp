// SPDX-License-Identifier: Zlib
#include "fuzz/generator.h"

#include "fuzz/bullet_shapes.h"
#include "fuzz/dice.h"
#include "fuzz/networks.h"

#include "solver/volumes.h"

#include <algorithm>

namespace limber::fuzz {
namespace {

using Eigen::Vector3d;

/// Generates the story of one seed.
class Writer {
 public:
  explicit Writer(std::uint64_t seed) : dice_(seed) { story_.seed = seed; }
  Story write();

 private:
  Step& add(Kind kind, int at = -1) {
    story_.steps.emplace_back(kind, at);
    return story_.steps.back();
  }
  Step& addObject(Kind kind, int at = -1) {
    Step& step = add(kind, at);
    step.id = ++lastId_;
    return step;
  }
  bool wild() const { return promise_ == "wild"; }
  void chooseAny(Step& step, const char* field);

  void world();
  void time();
  void floor();
  void rigid(int at = -1);
  void soft(int at = -1);
  void softMaterial(Step& step);
  void gas(Step& step);
  void softStepping(Step& step);
  void otherObjects();
  void joint(int at = -1);
  void user(int frames);
  void surroundings(int frames);
  void changes(int frames);
  void joins(int frames);
  void surfaceJoints();
  void studs();
  void userStep(int at);
  bool mayBePulled(int soft) const;
  void userOnPoints(Step& step);
  void userOnRigid(Step& step);
  Kind userKind();
  void spring(int at);
  Vector3d freePosition(double radius, double lowest);
  Vector3d randomRotation() { return dice_.chance(0.5) ? Vector3d(0, 0, 0) : dice_.ball(2.0); }
  int randomId(const std::vector<int>& ids) {
    return ids.empty() ? 0 : ids[static_cast<std::size_t>(dice_.below(static_cast<int>(ids.size())))];
  }
  int randomBody() { return dice_.chance(0.6) ? randomId(softs_) : randomId(rigids_); }

  struct Ball {
    Vector3d centre;
    double radius;
  };

  Dice dice_;
  Story story_;
  std::string promise_;
  int lastId_ = 0, systems_ = 1, frames_ = 60;
  std::vector<int> rigids_, softs_, otherIds_, springs_;
  std::vector<Ball> occupied_;
};

void Writer::chooseAny(Step& step, const char* field) {
  for (const Field& f : fieldsOf(step.kind))
    if (f.name == field) step.set(field, dice_.below(static_cast<int>(f.choices.size())));
}

/// Returns a position that is apart from all others so far, if one is found within 50 tries.
Vector3d Writer::freePosition(double radius, double lowest) {
  Vector3d position;
  const bool anywhere = wild() && dice_.chance(0.1);
  for (int attempt = 0; attempt < 50; ++attempt) {
    const double halfWidth = 1.0 + 0.05 * attempt;
    position = dice_.box({-halfWidth, lowest, -halfWidth}, {halfWidth, lowest + 2.0 * halfWidth, halfWidth});
    const bool clear = std::all_of(occupied_.begin(), occupied_.end(), [&](const Ball& other) {
      return (other.centre - position).norm() > other.radius + radius;
    });
    if (anywhere || clear) break;
  }
  occupied_.push_back({position, radius});
  return position;
}

void Writer::world() {
  Step& s = add(Kind::World);
  promise_ = dice_.of<std::string>({"wild", "wild", "wild", "wild", "closed", "closed", "gentle", "gentle"});
  s.choose("promise", promise_).set("gravity", Vector3d(0, -9.81, 0));
  chooseAny(s, "teardown");
  if (promise_ == "gentle") return;
  chooseAny(s, "broadphase");
  if (dice_.chance(0.2)) chooseAny(s, "kind");
  if (dice_.chance(0.2)) chooseAny(s, "solver");
  if (dice_.chance(0.2)) s.set("systems", systems_ = 2);
  if (!wild()) return;
  if (dice_.chance(0.15)) s.set("gravity", dice_.ball(10));
  if (dice_.chance(0.1)) s.set("manual", 1);
  if (dice_.chance(0.2)) s.set("action-first", 1);
  if (dice_.chance(0.4)) s.set("listener", 1);
  if (dice_.chance(0.3)) s.set("report", 1);
  if (dice_.chance(0.3)) s.set("tick", 1);
  if (dice_.chance(0.2)) s.set("fast-spheres", 1);
  if (dice_.chance(0.2)) s.set("no-latency", 1);
  if (dice_.chance(0.2)) s.set("split-impulse", 0);
  if (dice_.chance(0.2)) s.set("ordered-pairs", 1);
}

void Writer::time() {
  Step& s = add(Kind::Time);
  frames_ = dice_.between(15, 70);
  const double dt = dice_.of({0.0166667, 0.0166667, 0.0166667, 0.0333333, 0.0666667, 0.00833333, 0.00416667});
  // more of the shorter ticks, for the same time
  if (dt < 0.01) frames_ *= 2;
  s.set("frames", frames_).set("dt", dt).set("fixed", dt);
  if (!wild()) return;
  if (dice_.chance(0.3)) {
    s.set("sub-steps", dice_.of({1, 3, 10}));
    s.set("fixed", dice_.of({dt, 0.0166667, 0.01, 0.00416667}));
  }
  if (dice_.chance(0.2)) s.set("jitter", dice_.number(0.1, 0.9));
}

void Writer::floor() {
  if (wild() && dice_.chance(0.15)) return;
  Step& s = addObject(Kind::Floor);
  chooseAny(s, "kind");
  if (promise_ == "gentle" && s.choice("kind") == "gimpact") s.choose("kind", "plane");
  s.set("cell", dice_.of({1.0, 1.0, 0.5, 2.0, 6.0})).set("friction", dice_.of({0.5, 0.5, 0.0, 1.0}));
  if (dice_.chance(0.2)) s.set("restitution", dice_.number(0, 1));
  if (wild() && dice_.chance(0.15)) s.set("rotation", dice_.ball(0.4));
  if (wild()) rigids_.push_back(s.id);
}

// --- objects -----------------------------------------------------------------------------------------------

void Writer::rigid(int at) {
  Step& s = addObject(Kind::Rigid, at);
  chooseAny(s, "shape");
  if (!wild() && s.choice("shape") == "gimpact") s.choose("shape", "box");
  const Vector3d size = dice_.box({0.1, 0.1, 0.1}, {0.6, 0.6, 0.6});
  s.set("size", size).set("variant", dice_.below(60));
  const std::string motion = wild()
                                 ? dice_.of<std::string>({"dynamic", "dynamic", "dynamic", "static",
                                                          "kinematic", "kinematic-kept", "kinematic-state"})
                                 : dice_.of<std::string>({"dynamic", "dynamic", "static"});
  s.choose("motion", motion);
  const OwnedShape shape = makeShape(s.choice("shape"), size, s.whole("variant"));
  s.set("mass", dice_.decades(0.1, wild() ? 100 : 10));
  s.set("position", freePosition(std::min(shape.radius, 2.0), std::min(shape.radius, 2.0) + 0.05));
  if (!wild() && shape.fixed) s.set("position", Vector3d(0, -0.6, 0));
  const Vector3d rotation = randomRotation();
  // a tilted terrain would reach into the bodies above it
  s.set("rotation", !wild() && shape.fixed ? Vector3d(0, rotation.y(), 0) : rotation);
  if (motion != "static") s.set("velocity", dice_.ball(motion == "dynamic" ? 5 : 3));
  if (motion != "static" && dice_.chance(0.4)) s.set("spin", dice_.ball(5));
  // objects on a rotating plane are accelerated without limit, which is correct
  if (s.choice("shape") == "plane") s.set("spin", Vector3d(0, 0, 0));
  s.set("friction", dice_.of({0.5, 0.0, 1.0}));
  if (dice_.chance(0.2)) s.set("restitution", dice_.number(0, 1));
  rigids_.push_back(s.id);
  if (!wild()) return;
  if (dice_.chance(0.1)) s.set("rolling", dice_.number(0, 0.5));
  if (dice_.chance(0.1)) s.set("ccd", 1);
  if (dice_.chance(0.07)) s.set("no-response", 1);
  if (dice_.chance(0.2)) s.set("no-sleep", 1);
  if (dice_.chance(0.1)) s.set("damping", dice_.number(0, 0.9));
  if (dice_.chance(0.1)) s.set("group", dice_.of({1, 2, 4, 64})).set("mask", dice_.of({-1, 1, 3, 66}));
}

/// Returns the radius (m) of a bounding sphere around the origin.
double networkRadius(const SpringNetwork& network, const Vector3d& scale) {
  double radius = 0.0;
  for (const Vector3d& p : network.restPoints) radius = std::max(radius, p.cwiseProduct(scale).norm());
  return radius;
}

void Writer::soft(int at) {
  Step& s = addObject(Kind::Soft, at);
  chooseAny(s, "network");
  const bool rigidEnough = promise_ != "gentle" || s.choice("network") != "points";
  if (!rigidEnough) s.choose("network", "cube");
  double size = dice_.of({1.0, 1.0, 0.5, 0.7});
  if (wild() && dice_.chance(0.05)) size = dice_.decades(0.01, 5);
  Vector3d scale = Vector3d::Constant(size);
  if (dice_.chance(0.2)) {
    const Vector3d stretch = dice_.box({0.6, 0.6, 0.6}, {1.2, 1.2, 1.2});
    scale = Dice::rounded(Vector3d(scale.cwiseProduct(stretch)));
  }
  if (dice_.chance(0.15)) scale[dice_.below(3)] *= -1;
  s.set("scale", scale);
  const double radius = networkRadius(*networkNamed(s.choice("network")), scale) + 0.05;
  s.set("position", freePosition(radius, radius));
  s.set("rotation", randomRotation());
  if (dice_.chance(0.7)) s.set("velocity", dice_.ball(dice_.of({1.0, 5.0, 10.0})));
  if (dice_.chance(0.3)) s.set("spin", dice_.ball(6));
  if (systems_ == 2) s.set("system", dice_.below(2));
  if (dice_.chance(0.25))
    s.choose("collision", "points");
  else if (dice_.chance(0.25))
    s.set("self", 1);
  softMaterial(s);
  softStepping(s);
  softs_.push_back(s.id);
  if (!wild()) return;
  if (dice_.chance(0.1)) s.set("group", dice_.of({1, 2, 64})).set("mask", dice_.of({-1, 3, 66}));
  if (dice_.chance(0.3)) s.set("shared", 1);
}

/// Rolls dice of its own, so that the rest of the story does not depend on the air.
void Writer::gas(Step& s) {
  Dice dice(story_.seed + static_cast<std::uint64_t>(s.id));
  if (dice.chance(0.5)) s.set("ambient", dice.decades(10, 101325));
}

/// Whether the network has a volume for the modulus and the gas of the step.
bool enclosesVolume(const Step& s) {
  SoftBodySettings settings;
  settings.scale = s.vec("scale");
  settings.volumeModulus = std::max(s["volume"], 0.0);
  settings.pressure = s["pressure"];
  return checkVolume(*networkNamed(s.choice("network")), settings).empty();
}

void Writer::softMaterial(Step& s) {
  const double stiffness = dice_.decades(50, wild() && dice_.chance(0.1) ? 1e8 : 2e4);
  s.set("extension", stiffness).set("compression", stiffness);
  if (dice_.chance(0.15)) s.set("compression", dice_.of({0.0, Dice::rounded(0.1 * stiffness)}));
  s.set("damping", dice_.chance(0.3) ? 0.0 : dice_.decades(0.01, wild() ? 100 : 10));
  s.set("mass", dice_.decades(0.1, 10));
  if (dice_.chance(0.25)) s.set("volume", dice_.chance(0.5) ? 0.0 : dice_.decades(10, 1e5));
  if (dice_.chance(0.1)) gas(s.set("pressure", dice_.decades(1, 1000)));
  if (!enclosesVolume(s)) s.set("volume", -1).set("pressure", 0).set("ambient", 0);
  s.set("friction", dice_.of({0.5, 0.5, 0.0, 1.0}));
  if (dice_.chance(0.25)) s.set("restitution", dice_.number(0, 1));
  if (dice_.chance(0.15)) s.set("ccd", 0);
  if (dice_.chance(0.15)) s.set("radius", dice_.number(0.01, 0.08));
  if (!wild()) return;
  if (dice_.chance(0.1)) s.set("stiffen", dice_.number(0.05, 0.3)).set("stiffen-factor", dice_.number(1, 20));
  if (dice_.chance(0.1)) s.set("yield", dice_.number(0.05, 0.3));
  if (dice_.chance(0.1)) s.set("break", dice_.number(0.1, 1));
}

void Writer::softStepping(Step& s) {
  if (dice_.chance(0.2)) chooseAny(s, "stepper");
  // Verlet at any stiffness, or with stiffening springs, which only it can step, is slow: the stiffness is
  // limited
  if (s.choice("stepper") == "verlet" || s["stiffen"] > 0)
    for (const char* stiffness : {"extension", "compression"}) s.set(stiffness, std::min(s[stiffness], 2e4));
  if (dice_.chance(0.15)) s.set("at-least", dice_.of({1, 2, 10, 20}));
  if (dice_.chance(0.1)) s.set("period", dice_.of({1e-3, 0.01, 0.2}));
  if (dice_.chance(0.05)) s.set("tolerance", dice_.decades(1e-3, 0.1));
  if (dice_.chance(0.05)) s.set("relative", dice_.decades(1e-2, 0.1));
  if (dice_.chance(0.15)) s.set("budget", dice_.of({1, 4, 16, 64}));
  if (s["budget"] > 4) s.set("search", 0.25);
}

void Writer::joint(int at) {
  if (rigids_.size() < 2) return;
  Step& s = addObject(Kind::Joint, at);
  chooseAny(s, "kind");
  s.set("a", randomId(rigids_))
      .set("b", dice_.chance(0.3) ? 0 : randomId(rigids_))
      .set("pivot-a", dice_.ball(0.5));
  if (dice_.chance(0.2)) s.set("collide", 1);
  if (dice_.chance(0.2)) s.set("motor", dice_.number(-5, 5));
  if (dice_.chance(0.3)) s.set("low", dice_.number(-1, 0)).set("high", dice_.number(0, 1));
  if (dice_.chance(0.1)) s.set("break", dice_.number(0.1, 5));
  otherIds_.push_back(s.id);
}

/// Adds the objects of a scene that are neither rigid nor soft bodies.
void Writer::otherObjects() {
  if (dice_.chance(0.25)) {
    story_.steps[0].choose("kind", "multi-body").choose("solver", "sequential");
    Step& s = addObject(Kind::MultiBody);
    chooseAny(s, "joint");
    s.set("links", dice_.between(1, 3))
        .set("fixed-base", dice_.below(2))
        .set("position", freePosition(0.8, 0.8));
    s.set("rotation", randomRotation()).set("mass", dice_.decades(0.1, 10));
  }
  if (dice_.chance(0.1)) {
    Step& s = addObject(Kind::Ghost);
    s.set("position", dice_.box({-1, 0, -1}, {1, 2, 1})).set("pairs", dice_.below(2));
    otherIds_.push_back(s.id);
  }
  if (dice_.chance(0.12)) {
    Step& s = addObject(Kind::Character);
    s.set("position", freePosition(0.7, 0.75))
        .set("walk", Vector3d(dice_.number(-2, 2), 0, dice_.number(-2, 2)));
    otherIds_.push_back(s.id);
  }
  if (dice_.chance(0.08)) {
    Step& s = addObject(Kind::Vehicle);
    s.set("size", Vector3d(0.4, 0.2, 0.7))
        .set("position", freePosition(0.9, 0.9))
        .set("engine", dice_.number(-20, 20));
    s.set("velocity", Vector3d(0, 0, dice_.number(-5, 5)));
    rigids_.push_back(s.id);
  }
  for (int i = dice_.chance(0.3) ? dice_.between(1, 3) : 0; i > 0; --i) joint();
}

// --- the user ----------------------------------------------------------------------------------------------

void Writer::spring(int at) {
  Step& s = addObject(Kind::Spring, at);
  s.set("a", randomBody()).set("b", dice_.chance(0.2) ? 0 : randomBody());
  s.set("point-a", dice_.below(200)).set("point-b", dice_.below(200));
  s.set("pivot-a", dice_.ball(0.3)).set("pivot-b", dice_.chance(0.5) ? dice_.ball(0.3) : Vector3d(0, 2, 0));
  s.set("stiffness", dice_.decades(1e-3, 1e5))
      .set("damping", dice_.chance(0.5) ? 0.0 : dice_.decades(0.01, 100));
  if (dice_.chance(0.3)) s.set("rest", dice_.of({0.0, 0.5, 1.0}));
  chooseAny(s, "action");
  if (systems_ == 2) s.set("system", dice_.below(2));
  springs_.push_back(s.id);
}

Kind Writer::userKind() {
  // kinds that are listed more often are more likely
  return dice_.of({Kind::ChangeSpring, Kind::Attach,        Kind::Attach,   Kind::Attach,   Kind::Detach,
                   Kind::Forget,       Kind::Pin,           Kind::Pin,      Kind::MovePin,  Kind::MovePin,
                   Kind::Unpin,        Kind::Push,          Kind::Push,     Kind::Push,     Kind::Velocity,
                   Kind::Velocity,     Kind::Teleport,      Kind::Teleport, Kind::Teleport, Kind::Destroy,
                   Kind::Destroy,      Kind::Destroy,       Kind::Destroy,  Kind::Leave,    Kind::Leave,
                   Kind::Enter,        Kind::Flags,         Kind::Flags,    Kind::Mass,     Kind::Material,
                   Kind::Filter,       Kind::OverlapFilter, Kind::Shape,    Kind::Shape,    Kind::Scaling,
                   Kind::Scaling,      Kind::Gravity,       Kind::Listener, Kind::Report,   Kind::Look,
                   Kind::Look,         Kind::Ray,           Kind::Sleep,    Kind::Sync,     Kind::Hook,
                   Kind::Clock,        Kind::System});
}

/// Whether a point of the body may be attached to a pivot. The point jumps to the pivot on a static body at
/// once, which stretches its springs by metres. A stiff and light body then explodes: its speed is that
/// distance times sqrt(k / m), and its light points are several times faster.
bool Writer::mayBePulled(int soft) const {
  constexpr double kMaxStiffnessPerMass = 2.5e5;  // 1/s^2: 2 km/s after a stretch of 4 m
  for (const Step& s : story_.steps)
    if (s.kind == Kind::Soft && s.id == soft)
      return std::max(s["extension"], s["compression"]) < kMaxStiffnessPerMass * s["mass"];
  return true;
}

void Writer::userOnPoints(Step& s) {
  const int point = dice_.below(200);
  switch (s.kind) {
    case Kind::Attach:
      s.set("of", randomId(softs_)).set("to", randomId(rigids_)).set("point", point);
      if (dice_.chance(0.2)) s.set("pivoted", mayBePulled(s.whole("of"))).set("pivot", dice_.ball(0.3));
      break;
    case Kind::Detach:
    case Kind::Pin:
    case Kind::Unpin:
      s.set("of", randomId(softs_)).set("point", point);
      break;
    case Kind::MovePin:
      s.set("of", randomId(softs_)).set("point", point).set("by", dice_.ball(0.3));
      break;
    case Kind::Push:
      s.set("of", randomBody()).set("push", dice_.ball(5)).set("off", dice_.ball(0.3));
      chooseAny(s, "kind");
      if (dice_.chance(0.6)) s.set("point", point);
      break;
    case Kind::Velocity:
      s.set("of", randomBody()).set("velocity", dice_.ball(8)).set("spin", dice_.ball(5));
      if (dice_.chance(0.5)) s.set("point", point);
      break;
    default:
      s.set("of", randomBody())
          .set("by", dice_.ball(dice_.of({0.1, 1.0, 3.0})))
          .set("rotation", randomRotation());
      if (dice_.chance(0.2)) s.set("point", point);
      chooseAny(s, "how");
  }
}

void Writer::userOnRigid(Step& s) {
  switch (s.kind) {
    case Kind::Flags:
      chooseAny(s, "flag");
      s.set("of", randomBody()).set("on", dice_.chance(0.7));
      break;
    case Kind::Mass:
      s.set("of", randomId(rigids_)).set("mass", dice_.decades(0.1, 100));
      break;
    case Kind::Material:
      s.set("of", randomBody()).set("friction", dice_.number(0, 1)).set("restitution", dice_.number(0, 1));
      break;
    case Kind::Filter:
      s.set("of", randomBody()).set("group", dice_.of({1, 2, 64})).set("mask", dice_.of({-1, 0, 1, 66}));
      s.set("in-place", dice_.below(2));
      break;
    case Kind::Shape:
      chooseAny(s, "shape");
      s.set("of", randomId(rigids_)).set("size", dice_.box({0.1, 0.1, 0.1}, {0.6, 0.6, 0.6}));
      s.set("variant", dice_.below(60));
      break;
    case Kind::Scaling:
      s.set("of", randomId(rigids_))
          .set("scale", dice_.chance(0.5) ? Vector3d(Vector3d::Constant(dice_.number(0.5, 1.5)))
                                          : dice_.box({0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}));
      break;
    default:
      break;
  }
}

void Writer::userStep(int at) {
  if (dice_.chance(0.12)) return spring(at);
  if (dice_.chance(0.05)) return rigid(at);
  if (dice_.chance(0.05)) return soft(at);
  if (dice_.chance(0.03)) return joint(at);
  Step s(userKind(), at);
  if (s.kind >= Kind::Attach && s.kind <= Kind::Teleport && s.kind != Kind::Forget)
    userOnPoints(s);
  else if (s.kind >= Kind::Flags && s.kind <= Kind::Scaling)
    userOnRigid(s);
  else if (s.kind == Kind::ChangeSpring)
    s.set("of", randomId(springs_)).set("stiffness", dice_.decades(1, 1e5));
  else if (s.kind == Kind::Forget || s.kind == Kind::Enter)
    s.set("of", randomId(rigids_));
  else if (s.kind == Kind::Destroy || s.kind == Kind::Leave)
    s.set("of", dice_.chance(0.8) || otherIds_.empty() ? randomBody() : randomId(otherIds_));
  if (s.kind == Kind::Destroy && dice_.chance(0.1) && !springs_.empty()) s.set("of", randomId(springs_));
  if (s.kind == Kind::Destroy) chooseAny(s, "how");
  if (s.kind == Kind::Leave && dice_.chance(0.2)) s.set("point", dice_.below(200));
  if (s.kind == Kind::OverlapFilter) s.set("on", dice_.chance(0.8)).set("parity", dice_.chance(0.4));
  if (s.kind == Kind::Gravity)
    s.set("gravity", dice_.ball(12)).set("of", dice_.chance(0.3) ? randomId(rigids_) : 0);
  if (s.kind == Kind::Listener || s.kind == Kind::Report) s.set("on", dice_.below(2));
  if (s.kind == Kind::Look || s.kind == Kind::Ray || s.kind == Kind::Sync || s.kind == Kind::Hook)
    chooseAny(s, "what");
  if (s.kind == Kind::Look) s.set("of", randomId(softs_)).set("fraction", dice_.of({0.0, 0.5, 1.0, 1.4}));
  if (s.kind == Kind::Ray) s.set("of", randomBody()).set("from", dice_.ball(4)).set("to", dice_.ball(2));
  if (s.kind == Kind::Sleep) s.set("of", randomBody()), chooseAny(s, "state");
  if (s.kind == Kind::System) s.set("system", dice_.below(2)), chooseAny(s, "what");
  if (s.kind == Kind::Clock)
    s.set("dt", dice_.of({0.0166667, 0.0333333, 0.00416667, 0.001})).set("sub-steps", dice_.of({0, 1, 5}));
  if (dice_.chance(0.35)) s.phase = dice_.of({Phase::PreTick, Phase::Tick, Phase::Listener, Phase::Action});
  if (s.phase == Phase::Tick) story_.steps[0].set("tick", 1);
  if (s.phase == Phase::Listener) story_.steps[0].set("listener", 1);
  story_.steps.push_back(s);
}

void Writer::user(int frames) {
  const int count = dice_.chance(0.2) ? 0 : dice_.between(1, 14);
  std::vector<int> when;
  for (int i = 0; i < count; ++i) when.push_back(dice_.chance(0.15) ? 0 : dice_.below(frames));
  std::sort(when.begin(), when.end());
  for (const int at : when) userStep(at);
  surroundings(frames);
  changes(frames);
  joins(frames);
}

/// Has dice of its own, so that the rest of a story does not depend on it.
void Writer::surroundings(int frames) {
  Dice dice(story_.seed + 0x5a17);
  for (int i = dice.of({0, 0, 1, 2, 3}); i > 0; --i) {
    Step s(Kind::Surround, dice.chance(0.5) ? 0 : dice.below(frames));
    s.choose("what", dice.of({"air", "gusts", "vacuum", "water", "water", "dry", "field", "no-field"}));
    s.set("system", systems_ == 2 ? dice.below(2) : 0)
        .set("of", dice.chance(0.5) ? softs_[static_cast<std::size_t>(dice.below(int(softs_.size())))] : 0);
    s.set("flow", dice.ball(dice.of({1.0, 10.0, 60.0}))).set("level", dice.number(-1.0, 3.0));
    story_.steps.push_back(s);
  }
}

/// Has dice of its own, too.
void Writer::changes(int frames) {
  Dice dice(story_.seed + 0xc4a6);
  for (Step& s : story_.steps)
    if (s.kind == Kind::Soft && s["break"] > 0.0 && dice.chance(0.6))
      s.set("tear", 1);
    else if (s.kind == Kind::Attach && dice.chance(0.3))
      s.set("break", dice.decades(0.1, 1e4));
  for (int i = dice.of({0, 0, 2, 4, 8}); i > 0; --i) {
    Step s(Kind::Change, dice.chance(0.2) ? 0 : dice.below(frames));
    s.choose("what", dice.of({"settings", "settings", "settings", "place", "motion", "reset", "push", "push",
                              "pin", "save", "restore", "clone", "cut", "blade", "bones", "bones", "bones",
                              "release", "present"}));
    s.set("of", softs_[static_cast<std::size_t>(dice.below(int(softs_.size())))])
        .set("variant", dice.below(500))
        .set("factor", dice.decades(0.1, 10));
    s.set("by", dice.ball(dice.of({0.1, 1.0, 4.0})))
        .set("spin", dice.ball(5.0))
        .set("rotation", dice.ball(3.0));
    // a copy within its original has thousands of contacts
    if (s.choice("what") == "clone") s.set("by", Vector3d(0, 4, 0) + dice.ball(1.0));
    if (dice.chance(0.3)) s.phase = dice.of({Phase::Action, Phase::PreTick, Phase::Listener});
    story_.steps.push_back(s);
  }
}

/// Has dice of its own, too.
void Writer::joins(int frames) {
  Dice dice(story_.seed + 0x901d);
  for (int i = dice.of({0, 0, 0, 1, 2, 4}); i > 0; --i) {
    Step s(Kind::Change, dice.chance(0.3) ? 0 : dice.below(frames));
    s.choose("what", dice.of({"weld", "grab", "grab", "load", "filter", "filter"}));
    s.set("of", softs_[static_cast<std::size_t>(dice.below(int(softs_.size())))])
        .set("variant", dice.below(500))
        .set("factor", dice.decades(0.1, 10));
    s.set("by", dice.ball(dice.of({0.1, 1.0, 4.0})));
    if (dice.chance(0.3)) s.phase = dice.of({Phase::Action, Phase::PreTick, Phase::Listener});
    story_.steps.push_back(s);
  }
}

/// Joints of soft bodies with others and with the world. In closed stories none drives. Has dice of its own,
/// too. Rigid boxes on such joints explode in Bullet's NNCG solver and, where they are over-constrained, in
/// its MLCP solver.
void Writer::surfaceJoints() {
  Dice dice(story_.seed + 0x301e);
  const std::string& solver = story_.steps[0].choice("solver");
  if (solver == "nncg" || solver == "mlcp") return;
  std::vector<int> others = {0};
  for (const Step& s : story_.steps)
    if (s.kind == Kind::Soft || s.kind == Kind::Rigid) others.push_back(s.id);
  for (int i = dice.of({0, 0, 0, 1, 2}); i > 0; --i) {
    Step& s = addObject(Kind::Joint, wild() && dice.chance(0.3) ? dice.below(frames_) : -1);
    s.choose("kind", dice.of<std::string>({"point", "point", "hinge", "fixed"}));
    if (wild()) s.choose("kind", dice.of<std::string>({"point", "hinge", "slider", "fixed", "dof6"}));
    s.set("a", softs_[static_cast<std::size_t>(dice.below(int(softs_.size())))])
        .set("b", others[static_cast<std::size_t>(dice.below(int(others.size())))])
        .set("pivot-a", dice.ball(1.0));
    if (!wild()) continue;
    if (dice.chance(0.2)) s.set("motor", dice.number(-5, 5));
    if (dice.chance(0.3)) s.set("low", dice.number(-1, 0)).set("high", dice.number(0, 1));
    if (dice.chance(0.2)) s.set("break", dice.number(0.1, 5));
    if (dice.chance(0.2)) s.set("collide", 1);
  }
}

/// Puts small static objects of every shape under the soft bodies, where their points, edges and faces come
/// down. Has dice of its own, too.
void Writer::studs() {
  Dice dice(story_.seed + 0x57d5);
  if (dice.chance(0.6)) return;
  const std::size_t count = story_.steps.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (story_.steps[i].kind != Kind::Soft) continue;
    const Vector3d above = story_.steps[i].vec("position"), scale = story_.steps[i].vec("scale");
    const std::string network = story_.steps[i].choice("network");
    for (int n = dice.between(1, 3); n > 0; --n) {
      Step& s = addObject(Kind::Rigid);
      s.choose("shape", dice.of<std::string>({"box", "sphere", "capsule-x", "capsule-y", "cylinder-y",
                                              "cone-y", "hull", "triangle-hull", "scaled", "tetrahedron",
                                              "multi-sphere", "hull"}))
          .choose("motion", "static")
          .set("size", dice.chance(0.5) ? Vector3d(Vector3d::Constant(dice.decades(0.01, 0.2)))
                                        : dice.box({0.02, 0.02, 0.02}, {0.2, 0.2, 0.2}))
          .set("variant", dice.below(60));
      const Vector3d aside = dice.chance(0.5)
                                 ? Vector3d(dice.of({0.0, 0.25, 0.5}), 0, dice.of({0.0, 0.25, 0.5}))
                                 : dice.box({-0.5, 0, -0.5}, {0.5, 0, 0.5});
      Vector3d at = above + aside.cwiseProduct(scale);
      // apart from the body; a floor may cover a part of it
      const OwnedShape shape = makeShape(s.choice("shape"), s.vec("size"), s.whole("variant"));
      const double lowest = above.y() - networkRadius(*networkNamed(network), scale);
      at.y() = std::min(dice.of({0.0, 0.1, 0.2}), lowest - shape.radius - 0.15);
      s.set("position", at).set("friction", dice.of({0.5, 0.0, 1.0}));
      if (dice.chance(0.5)) s.set("margin", dice.of({0.0, 0.002, 0.01, 0.04}));
      if (dice.chance(0.3)) s.set("rotation", dice.ball(2.0));
    }
    // half of the bodies come down exactly as they are placed
    if (dice.chance(0.5))
      story_.steps[i].set("velocity", Vector3d(0, dice.number(-3, 0), 0)).set("spin", Vector3d(0, 0, 0));
    if (dice.chance(0.5)) story_.steps[i].set("rotation", Vector3d(0, 0, 0));
  }
}

Story Writer::write() {
  world();
  time();
  floor();
  const bool gentle = promise_ == "gentle";
  for (int i = gentle ? 0 : dice_.below(6); i > 0; --i) rigid();
  for (int i = dice_.of({1, 1, 1, 2, 2, 3}); i > 0; --i) soft();
  if (wild()) otherObjects();
  if (wild()) user(frames_);
  if (promise_ == "closed") studs();
  if (promise_ != "gentle") surfaceJoints();
  return std::move(story_);
}

}  // namespace

Story makeStory(std::uint64_t seed) { return Writer(seed).write(); }

}  // namespace limber::fuzz

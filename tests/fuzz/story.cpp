// SPDX-License-Identifier: Zlib
#include "fuzz/story.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

namespace limber::fuzz {
namespace {

constexpr Unit kLength{0, 1, 0}, kMass{1, 0, 0}, kTime{0, 0, 1}, kSpeed{0, 1, -1}, kSpin{0, 0, -1},
    kAcceleration{0, 1, -2}, kStiffness{1, 0, -2}, kDamping{1, 0, -1}, kPressure{1, -1, -2},
    kImpulse{1, 1, -1}, kNone{};

Field number(const char* name, double standard = 0.0, Unit unit = kNone) {
  return {name, Role::Number, unit, {standard, 0, 0}, {}, 0};
}
Field reference(const char* name) { return {name, Role::Reference, kNone, {}, {}, 0}; }
Field choice(const char* name, const char* choices) {
  Field field{name, Role::Choice, kNone, {}, {}, 0};
  std::istringstream words(choices);
  for (std::string word; words >> word;) field.choices.push_back(word);
  return field;
}
Field place(const char* name) { return {name, Role::Place, kLength, {}, {}, 0}; }
Field vector(const char* name, Unit unit) { return {name, Role::Vector, unit, {}, {}, 0}; }
Field axial(const char* name, Unit unit) { return {name, Role::Axial, unit, {}, {}, 0}; }
Field rotation(const char* name) { return {name, Role::Rotation, kNone, {}, {}, 0}; }
Field sizes(const char* name, double standard, Unit unit = kNone) {
  return {name, Role::Sizes, unit, {standard, standard, standard}, {}, 0};
}

const char* const kShapes =
    "box sphere capsule-x capsule-y capsule-z cylinder-x cylinder-y cylinder-z cone-x cone-y cone-z hull "
    "multi-sphere compound nested triangle-hull scaled tetrahedron plane mesh scaled-mesh height-field "
    "gimpact";
const char* const kMotions = "dynamic static kinematic kinematic-kept kinematic-state";
const char* const kNetworks =
    "cube full-cube cube-mesh ball rope cloth torus l-shape material pair chain rod ball-fine cloth-fine "
    "triangle "
    "islands tetrahedron points cube-fine";

struct KindInfo {
  std::string name;
  std::vector<Field> fields;
};

std::vector<KindInfo> sceneKinds() {
  return {
      {"world",
       {choice("promise", "wild closed gentle"), choice("kind", "discrete multi-body"),
        choice("broadphase", "dbvt axis-sweep simple"), choice("solver", "sequential nncg mlcp"),
        vector("gravity", kAcceleration), number("systems", 1), number("manual"), number("tick"),
        number("action-first"), number("listener"), number("report"), number("fast-spheres"),
        number("no-latency"), number("split-impulse", 1), number("ordered-pairs"),
        choice("teardown", "system world remove-all hello-world hello-system one-by-one broadphase")}},
      {"time",
       {number("frames", 60), number("dt", 0.0166667, kTime), number("fixed", 0.0166667, kTime),
        number("sub-steps"), number("jitter")}},
      {"floor",
       {choice("kind", "plane box mesh height-field boxes compound hulls scaled-mesh gimpact"),
        choice("motion", "static kinematic"), place("position"), number("cell", 1, kLength),
        number("extent", 6, kLength), rotation("rotation"), number("friction", 0.5), number("restitution")}},
      {"rigid",
       {choice("shape", kShapes), sizes("size", 0.5, kLength), number("variant"), choice("motion", kMotions),
        number("mass", 1, kMass), place("position"), rotation("rotation"), vector("velocity", kSpeed),
        axial("spin", kSpin), number("friction", 0.5), number("restitution"), number("rolling"),
        number("group"), number("mask", -1), number("ccd"), number("no-response"), number("no-sleep"),
        number("damping"), number("margin", -1, kLength)}},
      {"soft",
       {choice("network", kNetworks),
        number("system"),
        place("position"),
        rotation("rotation"),
        sizes("scale", 1),
        vector("velocity", kSpeed),
        axial("spin", kSpin),
        number("extension", 1000, kStiffness),
        number("compression", 1000, kStiffness),
        number("damping", 1, kDamping),
        number("mass", 1, kMass),
        number("volume", -1, kPressure),
        number("pressure", 0, kPressure),
        number("ambient", 0, kPressure),
        choice("collision", "surface points"),
        number("self"),
        number("radius", 0, kLength),
        number("friction", 0.5),
        number("restitution"),
        number("group", 1),
        number("mask", -1),
        number("ccd", 1),
        number("sleeping-speed", 0.1, kSpeed),
        choice("stepper", "auto verlet implicit newton"),
        number("at-least", 5),
        number("period", 0.04),
        number("tolerance", 0, kSpeed),
        number("relative"),
        number("budget"),
        number("search", 0.05),
        number("stiffen"),
        number("stiffen-factor", 10),
        number("yield"),
        number("yield-maximum", 0.5),
        number("break"),
        number("tear"),
        number("shared")}},
      {"joint",
       {choice("kind", "point hinge slider cone-twist dof6 dof6-spring2 fixed gear"), reference("a"),
        reference("b"), sizes("pivot-a", 0, kLength), sizes("pivot-b", 0, kLength), number("collide"),
        number("motor", 0, kSpin), number("low", 1), number("high", -1), number("break", 0, kImpulse)}},
      {"multi-body",
       {number("links", 2), choice("joint", "revolute prismatic spherical fixed"), number("fixed-base"),
        place("position"), rotation("rotation"), number("mass", 1, kMass), sizes("size", 0.2, kLength)}},
      {"ghost", {place("position"), sizes("size", 1, kLength), number("pairs"), number("group", 16)}},
      {"character",
       {place("position"), number("radius", 0.3, kLength), number("height", 0.8, kLength),
        vector("walk", kSpeed), number("jump-at", -1)}},
      {"vehicle",
       {place("position"), sizes("size", 0.5, kLength), number("mass", 5, kMass), number("engine", 5),
        number("steering", 0.1), vector("velocity", kSpeed)}}};
}

std::vector<KindInfo> userKinds() {
  const auto spring = [](std::vector<Field> first) {
    for (Field field : {number("rest", -1, kLength), number("stiffness", 1000, kStiffness),
                        number("damping", 0, kDamping), choice("action", "both extension compression")})
      first.push_back(field);
    return first;
  };
  return {
      {"spring", spring({reference("a"), reference("b"), number("point-a"), number("point-b"),
                         sizes("pivot-a", 0, kLength), sizes("pivot-b", 0, kLength), number("system")})},
      {"change-spring", spring({reference("of")})},
      {"attach",
       {reference("of"), number("point"), reference("to"), number("pivoted"), sizes("pivot", 0, kLength),
        number("break", 0, kStiffness)}},
      {"detach", {reference("of"), number("point")}},
      {"forget", {reference("of")}},
      {"pin", {reference("of"), number("point")}},
      {"move-pin", {reference("of"), number("point"), vector("by", kLength)}},
      {"unpin", {reference("of"), number("point")}},
      {"push",
       {reference("of"), number("point", -1), choice("kind", "impulse force torque torque-impulse"),
        vector("push", kImpulse), vector("off", kLength)}},
      {"velocity", {reference("of"), number("point", -1), vector("velocity", kSpeed), axial("spin", kSpin)}},
      {"teleport",
       {reference("of"), number("point", -1), vector("by", kLength), rotation("rotation"),
        choice("how", "points surface motion-state both-poses")}},
      {"destroy", {reference("of"), choice("how", "properly delete-object delete-point")}},
      {"leave", {reference("of"), number("point", -1)}},
      {"enter", {reference("of")}},
      {"flags",
       {reference("of"), choice("flag", "no-response kinematic static kinematic-kept"), number("on", 1)}},
      {"mass", {reference("of"), number("point", -1), number("mass", 1, kMass)}},
      {"material", {reference("of"), number("friction", 0.5), number("restitution"), number("rolling")}},
      {"filter", {reference("of"), number("group", 1), number("mask", -1), number("in-place")}},
      {"overlap-filter", {number("on", 1), number("parity")}},
      {"shape", {reference("of"), choice("shape", kShapes), sizes("size", 0.5, kLength), number("variant")}},
      {"scaling", {reference("of"), sizes("scale", 1)}},
      {"gravity", {reference("of"), vector("gravity", kAcceleration)}},
      {"listener", {number("on", 1)}},
      {"report", {number("on", 1)}},
      {"look",
       {reference("of"), number("fraction", 1), choice("what", "positions places contacts measures draw")}},
      {"ray", {place("from"), place("to"), choice("what", "ray sweep contact all"), reference("of")}},
      {"sleep", {reference("of"), choice("state", "wake sleep never-sleep force-wake")}},
      {"sync", {choice("what", "motion-states clear-forces apply-gravity no-step aabbs reset-caches")}},
      {"hook", {choice("what", "overwrite rehook")}},
      {"clock", {number("dt", 0.0166667, kTime), number("fixed", 0.0166667, kTime), number("sub-steps")}},
      {"system", {choice("what", "remove-all destroy add"), number("system")}},
      {"surround",
       {choice("what", "air gusts vacuum water dry field no-field"), number("system"), vector("flow", kSpeed),
        number("level", 0, kLength), reference("of")}},
      {"change",
       {reference("of"),
        choice("what",
               "settings place motion reset push pin save restore clone cut blade bones release present weld "
               "grab load "
               "filter"),
        number("variant"), number("factor", 1), vector("by", kLength), axial("spin", kSpin),
        rotation("rotation")}}};
}

const std::vector<KindInfo>& kinds() {
  static const std::vector<KindInfo> all = [] {
    std::vector<KindInfo> made = sceneKinds();
    for (KindInfo& kind : userKinds()) made.push_back(std::move(kind));
    for (KindInfo& kind : made) {
      std::size_t offset = 0;
      for (Field& field : kind.fields) {
        field.offset = offset;
        offset += field.size();
      }
    }
    return made;
  }();
  return all;
}

const std::vector<std::string> kPhaseNames = {"between", "pre-tick", "tick", "listener", "action"};

const Field& fieldOf(Kind kind, const std::string& name) {
  for (const Field& field : fieldsOf(kind))
    if (field.name == name) return field;
  throw std::runtime_error("a step " + nameOf(kind) + " has no field " + name);
}

}  // namespace

const std::string& nameOf(Kind kind) { return kinds()[static_cast<std::size_t>(kind)].name; }
const std::string& nameOf(Phase phase) { return kPhaseNames[static_cast<std::size_t>(phase)]; }
const std::vector<Field>& fieldsOf(Kind kind) { return kinds()[static_cast<std::size_t>(kind)].fields; }

Step::Step(Kind of, int frame) : kind(of), at(frame) {
  for (const Field& field : fieldsOf(of))
    for (std::size_t i = 0; i < field.size(); ++i) values.push_back(field.standard[i]);
}

double Step::operator[](const char* field) const { return values[fieldOf(kind, field).offset]; }

int Step::whole(const char* field) const { return static_cast<int>(std::lround((*this)[field])); }

Eigen::Vector3d Step::vec(const char* field) const {
  return Eigen::Vector3d::Map(values.data() + fieldOf(kind, field).offset);
}

const std::string& Step::choice(const char* field) const {
  const Field& found = fieldOf(kind, field);
  const auto i = static_cast<std::size_t>(values[found.offset]);
  return found.choices.at(i);
}

Step& Step::set(const char* field, double value) {
  values[fieldOf(kind, field).offset] = value;
  return *this;
}

Step& Step::set(const char* field, const Eigen::Vector3d& value) {
  Eigen::Vector3d::Map(values.data() + fieldOf(kind, field).offset) = value;
  return *this;
}

Step& Step::choose(const char* field, const std::string& chosen) {
  const Field& found = fieldOf(kind, field);
  for (std::size_t i = 0; i < found.choices.size(); ++i)
    if (found.choices[i] == chosen) return set(field, static_cast<double>(i));
  throw std::runtime_error("no choice " + chosen + " for " + field);
}

Step Story::first(Kind kind) const {
  for (const Step& step : steps)
    if (step.kind == kind) return step;
  return Step(kind);
}

// --- text --------------------------------------------------------------------------------------------------

namespace {

/// Returns the shortest text that is read back as the same number.
std::string shortest(double value) {
  char text[40];
  for (int digits = 1; digits <= 17; ++digits) {
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    if (std::strtod(text, nullptr) == value) break;
  }
  return text;
}

std::string valueText(const Step& step, const Field& field) {
  if (field.role == Role::Choice)
    return field.choices.at(static_cast<std::size_t>(step.values[field.offset]));
  std::string text = shortest(step.values[field.offset]);
  for (std::size_t i = 1; i < field.size(); ++i) text += "," + shortest(step.values[field.offset + i]);
  return text;
}

bool isStandard(const Step& step, const Field& field) {
  for (std::size_t i = 0; i < field.size(); ++i)
    if (step.values[field.offset + i] != field.standard[i]) return false;
  return true;
}

void readValue(Step& step, const Field& field, const std::string& text) {
  if (field.role == Role::Choice) {
    step.choose(field.name.c_str(), text);
    return;
  }
  std::istringstream parts(text);
  std::string part;
  for (std::size_t i = 0; i < field.size(); ++i) {
    if (!std::getline(parts, part, ',')) throw std::runtime_error("too few numbers");
    step.values[field.offset + i] = std::strtod(part.c_str(), nullptr);
  }
}

Kind kindNamed(const std::string& name) {
  for (std::size_t i = 0; i < kKinds; ++i)
    if (kinds()[i].name == name) return static_cast<Kind>(i);
  throw std::runtime_error("no kind of step is called " + name);
}

Phase phaseNamed(const std::string& name) {
  for (std::size_t i = 0; i < kPhases; ++i)
    if (kPhaseNames[i] == name) return static_cast<Phase>(i);
  throw std::runtime_error("no phase is called " + name);
}

Step readStep(const std::string& line) {
  std::istringstream words(line);
  std::string word;
  words >> word;
  Step step(kindNamed(word));
  while (words >> word) {
    const std::size_t equals = word.find('=');
    if (word[0] == '#') {
      step.id = std::atoi(word.c_str() + 1);
    } else if (word[0] == '@') {
      step.at = std::atoi(word.c_str() + 1);
      if (const std::size_t slash = word.find('/'); slash != std::string::npos)
        step.phase = phaseNamed(word.substr(slash + 1));
    } else if (equals != std::string::npos) {
      readValue(step, fieldOf(step.kind, word.substr(0, equals)), word.substr(equals + 1));
    } else {
      throw std::runtime_error("not understood: " + word);
    }
  }
  return step;
}

}  // namespace

std::string toText(const Story& story) {
  std::string text = "story " + std::to_string(story.seed) + "\n";
  for (const Step& step : story.steps) {
    text += nameOf(step.kind);
    if (step.id) text += " #" + std::to_string(step.id);
    if (step.at >= 0) text += " @" + std::to_string(step.at);
    if (step.phase != Phase::Between) text += "/" + nameOf(step.phase);
    for (const Field& field : fieldsOf(step.kind))
      if (!isStandard(step, field)) text += " " + field.name + "=" + valueText(step, field);
    text += "\n";
  }
  return text;
}

Story fromText(const std::string& text) {
  Story story;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.rfind("//", 0) == 0) continue;
    if (line.rfind("story ", 0) == 0) {
      story.seed = std::strtoull(line.c_str() + 6, nullptr, 10);
      continue;
    }
    try {
      story.steps.push_back(readStep(line));
    } catch (const std::exception& error) {
      throw std::runtime_error(std::string(error.what()) + " in: " + line);
    }
  }
  return story;
}

}  // namespace limber::fuzz

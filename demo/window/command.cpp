// SPDX-License-Identifier: Zlib
#include "window/command.h"

#include "number_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace limber::demo {
namespace {

/// How an action is written.
struct ActionInfo {
  Action action;
  const char* name;
  bool hasWord;
  std::size_t numbers;
};

constexpr ActionInfo kActions[] = {
    {Action::Camera, "camera", false, 6}, {Action::Grab, "grab", false, 6},
    {Action::Drag, "drag", false, 6},     {Action::Release, "release", false, 0},
    {Action::Shoot, "shoot", false, 6},   {Action::Cut, "cut", false, 9},
    {Action::Pin, "pin", false, 6},       {Action::Set, "set", true, 1},
    {Action::Show, "show", true, 1},      {Action::Restart, "restart", false, 0},
    {Action::Scene, "scene", true, 0},    {Action::Pause, "pause", false, 1},
    {Action::Tick, "tick", false, 0},     {Action::Speed, "speed", false, 1},
    {Action::Wait, "wait", false, 1}};

const ActionInfo& infoOf(Action action) {
  return *std::find_if(std::begin(kActions), std::end(kActions),
                       [action](const ActionInfo& info) { return info.action == action; });
}

const ActionInfo* findAction(const std::string& name) {
  const auto* found = std::find_if(std::begin(kActions), std::end(kActions),
                                   [&name](const ActionInfo& info) { return name == info.name; });
  return found == std::end(kActions) ? nullptr : found;
}

template <class List>
bool hasName(const List& list, const std::string& name) {
  return std::any_of(list.begin(), list.end(), [&name](const auto& info) { return name == info.name; });
}

/// Returns the reason why a number is not from `low` to `high`, or an empty string.
std::string rangeProblem(const std::string& name, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  std::ostringstream reason;
  reason << name << " is " << value << ", must be from " << low << " to " << high;
  return reason.str();
}

/// Returns the reason why the word or a number does not suit the action, or an empty string.
std::string valueProblem(const Command& command) {
  constexpr double kSlowest = 1e-3, kLongest = 1e9;
  if (command.action == Action::Speed) return rangeProblem("speed", command.numbers[0], kSlowest, 1.0);
  if (command.action == Action::Wait) return rangeProblem("wait", command.numbers[0], 1.0, kLongest);
  if (command.action == Action::Show && !hasName(layerList(), command.word))
    return "there is no layer " + command.word;
  if (command.action != Action::Set) return {};
  for (const SettingInfo& info : settingList()) {
    if (command.word != info.name) continue;
    const double value = command.numbers[0];
    if (info.whole && value != std::round(value)) return std::string(info.name) + " must be a whole number";
    return rangeProblem(info.name, value, info.low, info.high);
  }
  return "there is no setting " + command.word;
}

}  // namespace

std::string textOf(const Command& command) {
  const ActionInfo& info = infoOf(command.action);
  std::string text = info.name;
  if (info.hasWord) text += " " + command.word;
  for (const double number : command.numbers) {
    char digits[40];
    std::snprintf(digits, sizeof digits, " %.17g", number);
    text += digits;
  }
  return text;
}

Result<Command> parseCommand(const std::string& text) {
  std::istringstream words(text);
  std::string name;
  words >> name;
  const ActionInfo* info = findAction(name);
  if (!info) return Error{"there is no command \"" + name + "\""};
  Command command{info->action, {}, {}};
  if (info->hasWord && !(words >> command.word)) return Error{name + " needs a name"};
  for (std::string word; words >> word;) {
    const std::optional<double> number = finiteNumber(word);
    if (!number) return Error{word + " is not a finite number"};
    command.numbers.push_back(*number);
  }
  if (command.numbers.size() != info->numbers)
    return Error{name + " has " + std::to_string(info->numbers) + " numbers, not " +
                 std::to_string(command.numbers.size())};
  if (const std::string reason = valueProblem(command); !reason.empty()) return Error{reason};
  return command;
}

const std::array<SettingInfo, kSettingCount>& settingList() {
  static const std::array<SettingInfo, kSettingCount> list = {
      {{"stiffness", "stiffness x", 0.01, 100.0, 1.0, true, false},
       {"damping", "damping x", 0.01, 100.0, 1.0, true, false},
       {"pressure", "pressure Pa", 0.0, 10000.0, 0.0, true, false},
       {"gravity", "gravity m/s2", 0.0, 30.0, 9.81, false, false},
       {"wind", "wind m/s", 0.0, 30.0, 0.0, false, false},
       {"wind-direction", "wind to deg", -180.0, 180.0, 0.0, false, false},
       {"max-substeps", "max substeps", 0.0, 200.0, 0.0, false, true},
       {"tolerance", "tolerance 1/s", 0.0, 1.0, 0.0, true, false},
       {"bt-iterations", "piterations", 1.0, 100.0, 10.0, true, true},
       {"bt-stiffness", "kLST, 0: of k", 0.0, 1.0, 0.0, false, false},
       {"bt-damping", "kDP, added", 0.0, 1.0, 0.0, true, false},
       {"bt-pressure", "kPR/V0 Pa", 0.0, 10000.0, 0.0, true, false},
       {"bt-friction", "kDF x", 0.0, 10.0, 1.0, false, false},
       {"bt-margin", "margin x", 0.1, 10.0, 1.0, true, false}}};
  return list;
}

Settings::Settings() {
  for (std::size_t i = 0; i < kSettingCount; ++i) values[i] = settingList()[i].start;
}

const std::array<LayerInfo, kLayerCount>& layerList() {
  static const std::array<LayerInfo, kLayerCount> list = {{{"strain", '1', false},
                                                           {"contacts", '2', false},
                                                           {"boxes", '3', false},
                                                           {"velocities", '4', false},
                                                           {"constraints", '5', false},
                                                           {"shadows", '6', true},
                                                           {"islands", '7', false},
                                                           {"gallery", 'G', false},
                                                           {"panel", 'H', true},
                                                           {"split", 'S', false}}};
  return list;
}

Command rayCommand(Action action, const Ray& ray) {
  const Eigen::Vector3d &o = ray.origin, &d = ray.direction;
  return {action, {o.x(), o.y(), o.z(), d.x(), d.y(), d.z()}, {}};
}

Ray rayOf(const Command& command) {
  const std::vector<double>& n = command.numbers;
  return {{n[0], n[1], n[2]}, Eigen::Vector3d(n[3], n[4], n[5])};
}

}  // namespace limber::demo

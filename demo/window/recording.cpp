// SPDX-License-Identifier: Zlib
// Writes, reads and plays recordings, and says how to get to the state of a session.

#include "window/recording.h"

#include "number_checks.h"
#include "output_files.h"
#include "scenes/scene_list.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace limber::demo {
namespace {

constexpr const char* kFirstLine = "limber-recording 1";

std::string digits(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

const std::string& nameOf(scenes::Feel feel) {
  return std::find_if(scenes::feels().begin(), scenes::feels().end(),
                      [feel](const auto& one) { return one.second == feel; })
      ->first;
}

// --- reading -----------------------------------------------------------------------------------------------

/// Returns false for a text that is not a number from `low` to `high`.
bool readNumber(const std::string& text, double low, double high, double& value) {
  const std::optional<double> number = finiteNumber(text);
  value = number.value_or(0.0);
  return number && value >= low && value <= high;
}

bool readWhole(const std::string& text, double low, double high, std::int64_t& value) {
  double number = 0.0;
  if (!readNumber(text, low, high, number) || number != std::floor(number)) return false;
  value = static_cast<std::int64_t>(number);
  return true;
}

bool readOptional(const std::string& text, double low, double high, std::optional<double>& value) {
  double number = 0.0;
  if (!readNumber(text, low, high, number)) return false;
  value = number;
  return true;
}

bool readFeel(const std::string& text, scenes::Feel& feel) {
  const auto found = scenes::feels().find(text);
  if (found != scenes::feels().end()) feel = found->second;
  return found != scenes::feels().end();
}

bool readSize(const std::string& text, WindowSize& size) {
  std::istringstream words(text);
  return bool(words >> size.width >> size.height) && std::clamp(size.width, 16, 8192) == size.width &&
         std::clamp(size.height, 16, 8192) == size.height;
}

/// Reads a number and stores it in a field of another type.
template <class Value>
bool readWholeInto(const std::string& text, double low, double high, Value& value) {
  std::int64_t number = 0;
  if (!readWhole(text, low, high, number)) return false;
  value = static_cast<Value>(number);
  return true;
}

/// Returns the reason why a line before "begin" is wrong, or an empty string.
std::string readOption(const std::string& name, const std::string& value, Recording& recording) {
  scenes::SceneOptions& o = recording.choice.options;
  bool good = true;
  if (name == "scene") {
    recording.choice.name = value;
    good = scenes::findScene(value) != nullptr;
  } else if (name == "size") {
    good = readSize(value, recording.size);
  } else if (name == "seed") {
    good = readWholeInto(value, 0, 1e15, o.seed);
  } else if (name == "count") {
    good = readWholeInto(value, 1, 10000, o.count);
  } else if (name == "stiffness") {
    good = readOptional(value, 0.0, 1e9, o.stiffness);
  } else if (name == "damping") {
    good = readOptional(value, 0.0, 1e6, o.damping);
  } else if (name == "mass") {
    good = readOptional(value, 1e-6, 1e6, o.mass);
  } else if (name == "scale") {
    good = readOptional(value, 1e-6, 1e6, o.scale);
  } else if (name == "mesh") {
    o.meshFile = value;
  } else if (name == "feel") {
    good = readFeel(value, o.feel);
  } else if (name == "points") {
    good = readWholeInto(value, 0, 100000, o.cook.points);
  } else if (name == "braces") {
    o.cook.mode = CookMode::Braces;
  } else if (name == "connect") {
    o.cook.pieces = PieceRule::Connected;
  } else {
    return "there is no option \"" + name + "\"";
  }
  return good ? std::string() : name + " cannot be \"" + value + "\"";
}

bool readHash(const std::string& text, std::uint64_t& hash) {
  if (text.size() != 16 || text.find_first_not_of("0123456789abcdef") != std::string::npos) return false;
  hash = std::strtoull(text.c_str(), nullptr, 16);
  return true;
}

/// The same for a line after "begin".
std::string readCommand(const std::string& first, const std::string& rest, Recording& recording) {
  std::int64_t tick = 0;
  if (!recording.states.empty() && recording.states.back().end) return "there is a line behind the end";
  if (!readWhole(first, 0, 1e15, tick)) return "\"" + first + "\" is not a number of ticks";
  if (tick < recording.ticks()) return "the ticks go back";
  std::istringstream words(rest);
  std::string name, hash;
  words >> name >> hash;
  if (name == "state" || name == "end") {
    recording.states.push_back({tick, 0, name == "end"});
    return readHash(hash, recording.states.back().hash) ? "" : "\"" + hash + "\" is not a hash of 16 digits";
  }
  Result<Command> command = parseCommand(rest);
  if (!command) return command.error();
  recording.commands.push_back({tick, std::move(*command)});
  return {};
}

/// A line without what counts for nothing, in two parts at its first space.
struct SplitLine {
  std::string first, rest;

  explicit SplitLine(const std::string& line) {
    std::istringstream words(line);
    words >> first >> std::ws;
    std::getline(words, rest);
    if (!rest.empty() && rest.back() == '\r') rest.pop_back();
    if (!first.empty() && first[0] == '#') first.clear();
  }
};

}  // namespace

Result<Recording> parseRecording(const std::string& text, const std::string& name) {
  Recording recording;
  bool known = false, begun = false;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const SplitLine split(line);
    if (split.first.empty()) continue;
    std::string reason;
    if (!known)
      reason =
          split.first + " " + split.rest == kFirstLine ? "" : "a recording begins with limber-recording 1";
    else if (!begun && split.first == "begin")
      begun = true;
    else
      reason = begun ? readCommand(split.first, split.rest, recording)
                     : readOption(split.first, split.rest, recording);
    known = true;
    if (!reason.empty()) return Error{name + ":" + std::to_string(number) + ": " + reason};
  }
  if (!known) return Error{name + ": it is empty"};
  if (!begun) return Error{name + ": there is no line \"begin\""};
  if (recording.choice.name == "mesh" && recording.choice.options.meshFile.empty())
    return Error{name + ": the scene mesh needs a line \"mesh FILE\""};
  return recording;
}

Result<Recording> readRecording(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream.is_open() || stream.bad()) return Error{"cannot read " + file + ": " + std::strerror(errno)};
  return parseRecording(text, file);
}

std::int64_t Recording::ticks() const {
  return std::max(commands.empty() ? 0 : commands.back().tick, states.empty() ? 0 : states.back().tick);
}

// --- writing -----------------------------------------------------------------------------------------------

std::string headerOf(const SceneChoice& choice, const WindowSize& size) {
  const scenes::SceneOptions& o = choice.options;
  std::string text = std::string(kFirstLine) + "\nscene " + choice.name + "\n";
  const auto add = [&text](const char* name, const std::string& value) {
    text += std::string(name) + " " + value + "\n";
  };
  add("seed", std::to_string(o.seed));
  if (o.count) add("count", std::to_string(*o.count));
  if (o.stiffness) add("stiffness", digits(*o.stiffness));
  if (o.damping) add("damping", digits(*o.damping));
  if (o.mass) add("mass", digits(*o.mass));
  if (o.scale) add("scale", digits(*o.scale));
  if (!o.meshFile.empty()) {
    add("mesh", std::filesystem::absolute(o.meshFile).string());  // a replay may begin in another folder
    add("feel", nameOf(o.feel));
    add("points", std::to_string(o.cook.points));
    if (o.cook.mode == CookMode::Braces) text += "braces\n";
    if (o.cook.pieces == PieceRule::Connected) text += "connect\n";
  }
  add("size", std::to_string(size.width) + " " + std::to_string(size.height));
  return text + "begin\n";
}

std::string lineOf(const RecordedCommand& command) {
  return std::to_string(command.tick) + " " + textOf(command.command) + "\n";
}

std::string lineOf(const RecordedState& state) {
  return std::to_string(state.tick) + (state.end ? " end " : " state ") + hashText(state.hash) + "\n";
}

RecordedState stateOf(const Session& session, bool end) {
  return {session.ticks(), session.stateHash(), end};
}

Result<LineFile> LineFile::create(const std::string& file) {
  if (const std::string reason = checkWritable(file); !reason.empty()) return Error{reason};
  LineFile lines;
  lines.file_.reset(std::fopen(file.c_str(), "w"));
  if (!lines.file_) return Error{"cannot write " + file + ": " + std::strerror(errno)};
  return lines;
}

bool LineFile::write(const std::string& lines) {
  return std::fwrite(lines.data(), 1, lines.size(), file_.get()) == lines.size() &&
         std::fflush(file_.get()) == 0;
}

// --- playing -----------------------------------------------------------------------------------------------

/// Performs the next command before the next tick. Returns false if there is none.
bool Replay::performOne(Session& session) {
  const std::vector<RecordedCommand>& commands = recording_.commands;
  if (nextCommand_ >= commands.size() || commands[nextCommand_].tick > session.ticks()) return false;
  const Command& command = commands[nextCommand_++].command;
  session.perform(command);
  if (command.action == Action::Wait) waits_ = static_cast<std::int64_t>(command.numbers[0]);
  return true;
}

bool Replay::prepare(Session& session) {
  compare(session, false);
  while (performOne(session)) {
  }
  compare(session, true);
  return session.ticks() < recording_.ticks();
}

ReplayStep Replay::nextFrame(Session& session) {
  compare(session, false);
  while (waits_ == 0 && performOne(session)) {
  }
  if (waits_ > 0) {
    --waits_;
    return ReplayStep::Wait;
  }
  const bool ended = session.ticks() >= recording_.ticks();
  const bool slow = !session.pace().paused && session.pace().speed < 1.0;
  if (!ended && slow && session.ticksDue(1.0 / double(scenes::kTicksPerSecond)) == 0) return ReplayStep::Wait;
  compare(session, true);
  return ended ? ReplayStep::End : ReplayStep::Tick;
}

void Replay::compare(const Session& session, bool end) {
  const std::vector<RecordedState>& states = recording_.states;
  if (nextState_ >= states.size()) return;
  const RecordedState &expected = states[nextState_], now = stateOf(session, end);
  if (expected.tick != now.tick || expected.end != end) return;
  ++nextState_;
  if (now.hash == expected.hash || !problem_.empty()) return;
  problem_ =
      "after " + std::to_string(now.tick) + " ticks the bodies are in another state than the recorded one";
}

// --- the command line of a session -------------------------------------------------------------------------

namespace {

/// Returns a word as a shell reads it: in quotes, unless all its characters stand for themselves.
std::string quoted(const std::string& word) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || std::strchr("/._-+=:,@%", c) != nullptr || c >= 128;
  };
  if (std::all_of(word.begin(), word.end(), plain)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

void addMesh(std::ostream& out, const scenes::SceneOptions& options) {
  out << " --mesh " << quoted(options.meshFile);
  if (options.feel != scenes::Feel::Rubber) out << " --feel " << nameOf(options.feel);
  if (options.cook.points > 0) out << " --points " << options.cook.points;
  if (options.cook.mode == CookMode::Braces) out << " --braces";
  if (options.cook.pieces == PieceRule::Connected) out << " --connect";
}

void addSceneOptions(std::ostream& out, const SceneChoice& choice) {
  const scenes::SceneOptions& o = choice.options;
  if (o.meshFile.empty())
    out << " --scene " << choice.name;
  else
    addMesh(out, o);
  if (o.seed != 1) out << " --seed " << o.seed;
  if (o.count) out << " --count " << *o.count;
  if (o.stiffness) out << " --stiffness " << *o.stiffness;
  if (o.damping) out << " --damping " << *o.damping;
  if (o.mass) out << " --mass " << *o.mass;
  if (o.scale) out << " --scale " << *o.scale;
}

void addSettings(std::ostream& out, const Session& session) {
  for (std::size_t i = 0; i < kSettingCount; ++i) {
    const double value = session.settings().values[i];
    if (value != session.startSettings().values[i]) out << " --set " << settingList()[i].name << "=" << value;
  }
}

void addLayers(std::ostream& out, const Session& session) {
  if (session.shows(Layer::Strain)) out << " --mode wireframe";
  if (session.shows(Layer::Gallery)) out << " --quality gallery";
  if (session.shows(Layer::Split)) out << " --split";
  const char* before = " --overlay ";
  for (const Layer layer :
       {Layer::Contacts, Layer::Boxes, Layer::Velocities, Layer::Constraints, Layer::Islands}) {
    if (!session.shows(layer)) continue;
    out << before << layerList()[static_cast<std::size_t>(layer)].name;
    before = ",";
  }
}

void addCamera(std::ostream& out, const OrbitCamera& camera) {
  const Eigen::Vector3d eye = camera.eye(), &at = camera.target;
  out << " --camera " << eye.x() << "," << eye.y() << "," << eye.z() << "," << at.x() << "," << at.y() << ","
      << at.z();
}

}  // namespace

std::string titleOf(const Session& session) {
  const Pace& pace = session.pace();
  std::ostringstream out;
  out.precision(10);
  out << "limber-demo --window";
  addSceneOptions(out, session.choice());
  addSettings(out, session);
  addLayers(out, session);
  out.precision(4);
  addCamera(out, session.camera());
  out << " - tick " << session.ticks();
  if (pace.paused) out << ", paused";
  if (!pace.paused && pace.speed != 1.0) out << ", speed " << pace.speed;
  return out.str();
}

}  // namespace limber::demo

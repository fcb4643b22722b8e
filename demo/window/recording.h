// SPDX-License-Identifier: Zlib
#pragma once

#include "window/command.h"
#include "window/orbit_camera.h"
#include "window/session.h"

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace limber::demo {

/// A command and the number of ticks before it.
struct RecordedCommand {
  std::int64_t tick = 0;
  Command command;
};

/// The state of the bodies after so many ticks.
struct RecordedState {
  std::int64_t tick = 0;
  std::uint64_t hash = 0;  ///< scenes::stateHash()
  bool end = false;        ///< of the run
};

/// Ticks from one recorded state to the next.
constexpr std::int64_t kStateTicks = 30;

/// A run of a Session. As a file it is text of one fact a line:
///
///     limber-recording 1
///     scene cubes
///     count 4
///     size 1280 720
///     begin
///     12 grab 0 2 6 0.1 -0.2 -0.97
///     60 end 1f2e3d4c5b6a7988
///
/// "wait 45" stands for 45/60 s of a pause before the next command; without a window it counts for nothing.
/// First the scene and its options, which have the names of the command line without dashes, then the
/// commands behind the number of ticks before them. Empty lines and lines that begin with # count for
/// nothing. A run that was killed has no end; the rest can be replayed.
struct Recording {
  SceneChoice choice;
  WindowSize size;
  std::vector<RecordedCommand> commands;  ///< by tick
  std::vector<RecordedState> states;      ///< by tick; before the commands of the same tick, except the end

  /// Returns the number of ticks of the run.
  std::int64_t ticks() const;
};

/// Errors name the file and the line.
Result<Recording> readRecording(const std::string& file);
/// The same for a text; `name` is for errors.
Result<Recording> parseRecording(const std::string& text, const std::string& name);

/// Returns the lines before the first command.
std::string headerOf(const SceneChoice& choice, const WindowSize& size);
std::string lineOf(const RecordedCommand& command);
std::string lineOf(const RecordedState& state);
/// Returns the state of the session as it is now.
RecordedState stateOf(const Session& session, bool end);

/// Returns the command line that opens a window with the scene, settings, layers and camera of this one, and
/// behind it the tick, so that a screenshot tells how to get there.
std::string titleOf(const Session& session);

/// Writes lines to a file at once, so that they stay if the program dies.
class LineFile {
 public:
  /// Error: the reason why the file cannot be written, with its name.
  static Result<LineFile> create(const std::string& file);

  /// Returns false if the disk is full, or the like.
  bool write(const std::string& lines);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
};

/// What a frame of a replay does.
enum class ReplayStep { Tick, Wait, End };

/// Plays a recording, one tick at a time.
class Replay {
 public:
  explicit Replay(const Recording& recording) : recording_(recording) {}

  /// Compares the state and performs the commands before the next tick. Returns false at the end of the
  /// recording.
  bool prepare(Session& session);
  /// The same for a frame of 1/60 s in a window: pauses and slow motion take their time.
  ReplayStep nextFrame(Session& session);
  /// Returns the first state that was not the recorded one, in words, or an empty string.
  const std::string& problem() const { return problem_; }

 private:
  void compare(const Session& session, bool end);
  bool performOne(Session& session);

  Recording recording_;
  std::int64_t waits_ = 0;  // frames of a pause that are still to be shown
  std::size_t nextCommand_ = 0, nextState_ = 0;
  std::string problem_;
};

}  // namespace limber::demo

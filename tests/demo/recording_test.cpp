// SPDX-License-Identifier: Zlib
#include "window/recording.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace limber::demo {
namespace {

const std::string kHead = "limber-recording 1\nscene cubes\ncount 2\nbegin\n";

std::string errorOf(const std::string& text) { return parseRecording(text, "a.rec").error(); }

TEST(Command, textsAreReadToTheSameBits) {
  const Command command =
      rayCommand(Action::Grab, {{0.1, 1.0 / 3.0, -7e-9}, Eigen::Vector3d(1, 2, 3).normalized()});
  const Result<Command> read = parseCommand(textOf(command));
  ASSERT_TRUE(read) << read.error();
  EXPECT_EQ(read->action, Action::Grab);
  EXPECT_EQ(read->numbers, command.numbers);
  const Result<Command> set = parseCommand("set wind 4.5");
  ASSERT_TRUE(set) << set.error();
  EXPECT_EQ(set->word, "wind");
}

TEST(Command, wrongOnesAreRefusedWithTheReason) {
  EXPECT_EQ(parseCommand("jump 3").error(), "there is no command \"jump\"");
  EXPECT_EQ(parseCommand("grab 1 2").error(), "grab has 6 numbers, not 2");
  EXPECT_EQ(parseCommand("drag 1 2 3 4 5 nan").error(), "nan is not a finite number");
  EXPECT_EQ(parseCommand("drag 1 2 3 4 5 6x").error(), "6x is not a finite number");
  EXPECT_EQ(parseCommand("set").error(), "set needs a name");
  EXPECT_EQ(parseCommand("set wobble 1").error(), "there is no setting wobble");
  EXPECT_EQ(parseCommand("set gravity 31").error(), "gravity is 31, must be from 0 to 30");
  EXPECT_EQ(parseCommand("show ghosts 1").error(), "there is no layer ghosts");
  EXPECT_EQ(parseCommand("release 1").error(), "release has 0 numbers, not 1");
  EXPECT_EQ(parseCommand("speed 2").error(), "speed is 2, must be from 0.001 to 1");
  EXPECT_EQ(parseCommand("wait 0").error(), "wait is 0, must be from 1 to 1e+09");
}

TEST(Recording, isReadAsItWasWritten) {
  SceneChoice choice;
  choice.name = "mesh";
  choice.options.meshFile = "a folder/a mesh.obj";
  choice.options.count = 3;
  choice.options.stiffness = 0.1;
  choice.options.feel = scenes::Feel::Foam;
  choice.options.cook.mode = CookMode::Braces;
  const RecordedCommand command{12, {Action::Set, {2.0}, "stiffness"}};
  const std::string text = headerOf(choice, {640, 480}) + lineOf(command) +
                           lineOf(RecordedState{30, 0x1f, false}) + lineOf(RecordedState{45, 0xabcdef, true});
  const Result<Recording> read = parseRecording(text, "a.rec");
  ASSERT_TRUE(read) << read.error();
  EXPECT_EQ(read->choice.options.meshFile, std::filesystem::absolute("a folder/a mesh.obj"));
  EXPECT_EQ(read->choice.options.stiffness, 0.1);
  EXPECT_EQ(headerOf(read->choice, read->size), headerOf(choice, {640, 480}));
  ASSERT_EQ(read->commands.size(), 1u);
  EXPECT_EQ(read->commands[0].tick, 12);
  ASSERT_EQ(read->states.size(), 2u);
  EXPECT_EQ(read->states[1].hash, 0xabcdefu);
  EXPECT_EQ(read->ticks(), 45);
}

TEST(Recording, emptyLinesAndCommentsCountForNothing) {
  const Result<Recording> read = parseRecording("# mine\n\n" + kHead + "\n# pull\r\n7 release\r\n", "a.rec");
  ASSERT_TRUE(read) << read.error();
  EXPECT_EQ(read->commands.size(), 1u);
}

TEST(Recording, errorsNameFileAndLine) {
  EXPECT_EQ(errorOf(""), "a.rec: it is empty");
  EXPECT_EQ(errorOf("hello\n"), "a.rec:1: a recording begins with limber-recording 1");
  EXPECT_EQ(errorOf("limber-recording 1\nscene cubes\n"), "a.rec: there is no line \"begin\"");
  EXPECT_EQ(errorOf("limber-recording 1\nscene jelly\n"), "a.rec:2: scene cannot be \"jelly\"");
  EXPECT_EQ(errorOf("limber-recording 1\ncount 0\n"), "a.rec:2: count cannot be \"0\"");
  EXPECT_EQ(errorOf("limber-recording 1\nsize 640\n"), "a.rec:2: size cannot be \"640\"");
  EXPECT_EQ(errorOf("limber-recording 1\ncolour red\n"), "a.rec:2: there is no option \"colour\"");
  EXPECT_EQ(errorOf(kHead + "x release\n"), "a.rec:5: \"x\" is not a number of ticks");
  EXPECT_EQ(errorOf(kHead + "-1 release\n"), "a.rec:5: \"-1\" is not a number of ticks");
  EXPECT_EQ(errorOf(kHead + "5 release\n4 release\n"), "a.rec:6: the ticks go back");
  EXPECT_EQ(errorOf(kHead + "5 jump\n"), "a.rec:5: there is no command \"jump\"");
  EXPECT_EQ(errorOf(kHead + "5 end 12\n"), "a.rec:5: \"12\" is not a hash of 16 digits");
  EXPECT_EQ(errorOf(kHead + "5 end 0123456789abcdef\n6 release\n"),
            "a.rec:6: there is a line behind the end");
  EXPECT_EQ(errorOf("limber-recording 1\nscene mesh\nbegin\n"),
            "a.rec: the scene mesh needs a line \"mesh FILE\"");
  EXPECT_NE(readRecording("no_such.rec").error().find("cannot read no_such.rec"), std::string::npos);
}

/// Plays a recording to its end and returns the hash.
std::uint64_t played(const Recording& recording, std::string& problem) {
  Result<std::unique_ptr<Session>> session = Session::create(recording.choice, recording.size);
  EXPECT_TRUE(session) << session.error();
  Replay replay(recording);
  while (replay.prepare(**session)) (*session)->tick();
  problem = replay.problem();
  return stateOf(**session, true).hash;
}

TEST(Recording, replaysEndInTheSameStateAndTellWhereAnotherBegins) {
  Result<Recording> recording = parseRecording(kHead +
                                                   "10 grab 0 0.9 6 0 0 -1\n12 drag 1 2 6 0 0 -1\n"
                                                   "20 set stiffness 0.5\n25 shoot 0 1 6 0 -0.1 -1\n"
                                                   "30 release\n40 restart\n45 set gravity 3\n60 release\n",
                                               "a.rec");
  ASSERT_TRUE(recording) << recording.error();
  std::string problem;
  const std::uint64_t hash = played(*recording, problem);
  EXPECT_EQ(problem, "");
  recording->states = {{60, hash, true}};
  EXPECT_EQ(played(*recording, problem), hash);
  EXPECT_EQ(problem, "");
  recording->states = {{30, 1, false}, {60, hash, true}};
  played(*recording, problem);
  EXPECT_EQ(problem, "after 30 ticks the bodies are in another state than the recorded one");
}

// The user pauses after tick 2 for 3 frames, makes one tick, waits 2 frames, and goes on in slow motion.
const std::string kPauses =
    "2 pause 1\n2 wait 3\n2 set stiffness 2\n2 tick\n3 wait 2\n3 speed 0.25\n3 pause 0\n5 release\n";

TEST(Recording, pausesAndSlowMotionTakeTheirTimeInTheWindow) {
  const Result<Recording> recording = parseRecording(kHead + kPauses, "a.rec");
  ASSERT_TRUE(recording) << recording.error();
  Result<std::unique_ptr<Session>> session = Session::create(recording->choice, recording->size);
  ASSERT_TRUE(session) << session.error();
  Replay replay(*recording);
  std::string frames;  // t: a tick, w: waits
  for (ReplayStep step; (step = replay.nextFrame(**session)) != ReplayStep::End;) {
    frames += step == ReplayStep::Tick ? 't' : 'w';
    if (step == ReplayStep::Tick) (*session)->tick();
  }
  EXPECT_EQ(frames, "ttwwwtwwtwwt");
  EXPECT_FALSE((*session)->pace().paused);
  EXPECT_EQ((*session)->pace().speed, 0.25);
  std::string problem;
  EXPECT_EQ(stateOf(**session, true).hash, played(*recording, problem));
}

TEST(Recording, theSplitIsPartOfTheStateAndIsReplayedToTheBit) {
  const std::string commands = "0 show split 1\n5 set bt-iterations 4\n10 shoot 0 1 6 0 -0.1 -1\n";
  const Result<Recording> split = parseRecording(kHead + commands + "60 release\n", "a.rec");
  const Result<Recording> without =
      parseRecording(kHead + commands + "20 show split 0\n60 release\n", "a.rec");
  ASSERT_TRUE(split && without);
  std::string problem;
  const std::uint64_t hash = played(*split, problem);
  EXPECT_EQ(played(*split, problem), hash);
  EXPECT_NE(played(*without, problem), hash);
}

TEST(LineFile, unwritableOnesAreRefusedByName) {
  EXPECT_NE(LineFile::create("/dev/null/a.rec").error().find("/dev/null/a.rec"), std::string::npos);
  Result<LineFile> full = LineFile::create("/dev/full");
  ASSERT_TRUE(full) << full.error();
  EXPECT_FALSE(full->write("a line\n"));
}

}  // namespace
}  // namespace limber::demo

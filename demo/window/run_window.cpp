// SPDX-License-Identifier: Zlib
#include "window/run_window.h"

#include "output_files.h"
#include "progress.h"
#include "run_demo.h"
#include "window/panel.h"
#include "window/recording.h"
#include "window/stage.h"
#include "window/window.h"

#include <limber/render/png_file.h>

#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <thread>

namespace limber::demo {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kTitleFrames = 10, kLoggedFrames = 10;

/// Opens a file of lines if it has a name.
std::optional<LineFile> openLines(const std::string& file) {
  if (file.empty()) return std::nullopt;
  Result<LineFile> lines = LineFile::create(file);
  if (!lines) throw std::runtime_error(lines.error());
  return std::move(*lines);
}

std::optional<Recording> openReplay(const std::string& file) {
  if (file.empty()) return std::nullopt;
  Result<Recording> recording = readRecording(file);
  if (!recording) throw std::runtime_error(recording.error());
  return std::move(*recording);
}

/// Fails before the scene is made, which may take long, and before an old file is emptied.
void checkFiles(const WindowOptions& options) {
  for (const std::string& file : {options.record, options.log, options.picture}) {
    if (file.empty()) continue;
    if (const std::string reason = checkWritable(file); !reason.empty()) throw std::runtime_error(reason);
  }
}

/// A window in which a session is played.
class Play {
 public:
  explicit Play(const DemoOptions& options);

  ExitCode run();

 private:
  void logLine(const char* format, ...) __attribute__((format(printf, 2, 3)));
  void listen();
  void record(const std::string& line);
  void recordWait();
  void frame();
  void measure(double seconds);
  void advance(double seconds);
  void tick();
  double tickFraction() const;
  void draw(double fraction);
  void drawCutLine() const;
  void waitForNextFrame();
  void logFrame();
  void logHand();
  void logStatus();
  void writePicture();
  long long ticks() const { return static_cast<long long>(session_->ticks()); }
  bool ends() const;
  ExitCode finish();

  DemoOptions options_;
  std::optional<Recording> recording_;
  std::optional<Replay> replay_;
  std::unique_ptr<Session> session_;
  Window window_;  // is destroyed after stage_
  Stage stage_;
  std::optional<LineFile> record_, log_;
  Controls controls_;
  Panel panel_;
  History history_;
  FrameFigures figures_;
  Clock::time_point start_, frameStart_;  // of the first frame, of the present one
  std::int64_t frames_ = 0;
  int sceneNumber_ = 0;  // that history_ is of
  double waited_ = 0.0;  // 1/60 s, of the present pause, since the last command
  bool wasPaused_ = false;
  bool replayed_ = false;  // the recording has been played to its end
};

Play::Play(const DemoOptions& options)
    : options_(options),
      recording_(openReplay(options.window.replay)),
      session_(createSession(options, recording_ ? &*recording_ : nullptr)),
      window_(recording_ ? recording_->size : WindowSize{options.width, options.height}, "limber-demo"),
      stage_(Window::functionAddress, window_.framebufferSize()),
      record_(openLines(options.window.record)),
      log_(openLines(options.window.log)),
      controls_(*session_, window_.size()) {
  if (recording_) replay_.emplace(*recording_);
  record(headerOf(session_->choice(), window_.size()));
  listen();
  if (!replay_) performOptions(*session_, options);
}

void Play::logLine(const char* format, ...) {
  if (!log_) return;
  char text[512];
  va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof text - 1, format, values);
  va_end(values);
  log_->write(std::string(text) + "\n");
}

void Play::listen() {
  session_->setListener([this](const Command& command, const std::string& outcome) {
    recordWait();
    record(lineOf(RecordedCommand{session_->ticks(), command}));
    if (!outcome.empty()) panel_.setMessage(outcome);
    logLine("tick %lld: %s%s%s", ticks(), textOf(command).c_str(), outcome.empty() ? "" : ": ",
            outcome.c_str());
  });
}

void Play::record(const std::string& line) {
  if (record_ && !record_->write(line))
    throw std::runtime_error("cannot write " + options_.window.record + ": the disk may be full");
}

/// Records how long the user has looked at a pause, for replays in a window.
void Play::recordWait() {
  const double frames = std::round(waited_);
  waited_ = 0.0;
  if (frames >= 1.0) record(lineOf(RecordedCommand{session_->ticks(), {Action::Wait, {frames}, {}}}));
}

ExitCode Play::run() {
  start_ = frameStart_ = Clock::now();
  logLine("opened %d x %d, %s", window_.size().width, window_.size().height, stage_.driver().c_str());
  while (!ends()) {
    if (stopSignal != 0) {
      finish();
      throw Stopped{};
    }
    frame();
  }
  return finish();
}

bool Play::ends() const {
  const bool over = options_.window.seconds > 0.0 &&
                    double(session_->ticks()) >= options_.window.seconds * double(scenes::kTicksPerSecond);
  return over || replayed_ || controls_.wantsToQuit() || window_.closed();
}

// --- one frame ---------------------------------------------------------------------------------------------

void Play::frame() {
  const Clock::time_point now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - frameStart_).count();
  frameStart_ = now;
  ++frames_;
  measure(seconds);
  window_.beginFrame(controls_, !replay_);
  advance(seconds);
  draw(tickFraction());
  window_.show();
  if (frames_ % kTitleFrames == 0 || session_->pace().paused) window_.setTitle(titleOf(*session_));
  logFrame();
  waitForNextFrame();
}

/// Keeps a mean of the last frames.
void Play::measure(double seconds) {
  constexpr double kNewShare = 0.05;
  const double old = figures_.framesPerSecond > 0.0 ? 1.0 / figures_.framesPerSecond : seconds;
  figures_.framesPerSecond = 1.0 / std::max(old + kNewShare * (seconds - old), 1e-6);
}

void Play::advance(double seconds) {
  if (!replay_) {
    if (session_->pace().paused) waited_ += seconds * double(scenes::kTicksPerSecond);
    for (int due = session_->ticksDue(seconds); due > 0 && !ends(); --due) tick();
    return;
  }
  const ReplayStep step = replay_->nextFrame(*session_);
  if (step == ReplayStep::Tick) tick();
  replayed_ = step == ReplayStep::End;
}

void Play::tick() {
  const scenes::TickTimes times = session_->tick();
  if (record_ && session_->ticks() % kStateTicks == 0) record(lineOf(stateOf(*session_, false)));
  if (session_->sceneNumber() != sceneNumber_) history_.clear();
  sceneNumber_ = session_->sceneNumber();
  TickSample sample =
      sampleOf(times, session_->shows(Layer::Panel) ? session_->diagnostics() : Diagnostics{});
  if (const auto* twin = session_->bulletTwin()) sample.twinMs = static_cast<float>(twin->tickMs());
  history_.add(sample);
}

/// A replay has a tick in every frame, except in slow motion.
double Play::tickFraction() const {
  const Pace& pace = session_->pace();
  return replay_ && pace.speed == 1.0 ? 1.0 : pace.tickFraction();
}

/// Draws the scene and the panel; the window does not show them yet.
void Play::draw(double fraction) {
  const Clock::time_point start = Clock::now();
  if (session_->shows(Layer::Panel)) panel_.draw(*session_, controls_, history_, figures_, !replay_);
  drawCutLine();
  drawSplitLabels(*session_, history_, window_.size());
  const WindowSize pixels = window_.framebufferSize();
  stage_.draw(*session_, fraction, pixels, double(pixels.width) / window_.size().width);
  window_.drawPanel();
  figures_.drawMs += 0.05 * (1000.0 * secondsSince(start) - figures_.drawMs);
}

void Play::drawCutLine() const {
  const auto line = controls_.cutLine();
  if (!line) return;
  const auto corner = [](const Pixel& p) { return ImVec2(static_cast<float>(p.x), static_cast<float>(p.y)); };
  ImGui::GetForegroundDrawList()->AddLine(corner((*line)[0]), corner((*line)[1]), IM_COL32(200, 30, 20, 255),
                                          2.0f);
}

/// Software rasterisers do not wait for the screen.
void Play::waitForNextFrame() {
  constexpr std::chrono::microseconds kFrame(16000);
  std::this_thread::sleep_until(frameStart_ + kFrame);
}

// --- the log -----------------------------------------------------------------------------------------------

void Play::logFrame() {
  if (!log_) return;
  for (const SliderPlace& slider : panel_.takeMovedSliders())
    logLine("slider %s at %.0f %.0f, %.0f x %.0f", slider.name.c_str(), slider.x, slider.y, slider.width,
            slider.height);
  const bool paused = session_->pace().paused;
  if (paused != wasPaused_) logLine("tick %lld: %s", ticks(), paused ? "paused" : "goes on");
  wasPaused_ = paused;
  if (session_->hand().holds()) logHand();
  if (frames_ % kLoggedFrames == 0) logStatus();
}

void Play::logHand() {
  const Eigen::Vector3d held = session_->hand().held(), place = session_->hand().place();
  logLine("tick %lld: held at %.3f %.3f %.3f, pulled to %.3f %.3f %.3f", ticks(), held.x(), held.y(),
          held.z(), place.x(), place.y(), place.z());
}

void Play::logStatus() {
  logLine("tick %lld: %.1f frames/s, draw %.2f ms, tick %.2f ms", ticks(), figures_.framesPerSecond,
          figures_.drawMs, history_.meanMs());
  if (session_->scene().soft->bodyCount() == 0) return;
  const SoftBody& body = *session_->scene().soft->body(0);
  const Eigen::Vector3d centre = body.centerOfMass();
  if (const auto* twin = session_->bulletTwin()) {
    const Eigen::Vector3d other = twin->center(0);
    logLine("tick %lld: btSoftBody's body 0 at %.3f %.3f %.3f, tick %.2f ms", ticks(), other.x(), other.y(),
            other.z(), history_.meanTwinMs());
  }
  const ViewLayout layout = session_->layout(window_.size());
  const std::optional<Pixel> pixel = session_->camera().pixelOf(centre, layout.view);
  if (!pixel) return;
  logLine("tick %lld: body 0 at %.3f %.3f %.3f, pixel %.0f %.0f, stiffness %.6g", ticks(), centre.x(),
          centre.y(), centre.z(), pixel->x + layout.left, pixel->y, body.settings().extensionStiffness);
}

// --- the end -----------------------------------------------------------------------------------------------

ExitCode Play::finish() {
  recordWait();
  const std::string end = lineOf(stateOf(*session_, true));
  record(end);
  if (!options_.window.picture.empty()) writePicture();
  const double seconds = secondsSince(start_);
  logLine("closed after %lld frames in %.2f s, %.1f frames/s", static_cast<long long>(frames_), seconds,
          double(frames_) / seconds);
  std::printf("%s", end.c_str());
  const std::string problem = replay_ ? replay_->problem() : std::string();
  if (problem.empty()) return kSuccess;
  std::fprintf(stderr, "limber-demo: %s: %s\n", options_.window.replay.c_str(), problem.c_str());
  return kWrongEnd;
}

void Play::writePicture() {
  window_.beginFrame(controls_, false);
  draw(1.0);
  render::writePng(options_.window.picture, stage_.readWindow(window_.framebufferSize()));
}

}  // namespace

ExitCode runWindow(const DemoOptions& options) {
  checkFiles(options.window);
  return Play(options).run();
}

}  // namespace limber::demo

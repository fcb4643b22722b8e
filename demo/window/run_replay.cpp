// SPDX-License-Identifier: Zlib
#include "progress.h"
#include "run_demo.h"
#include "window/run_window.h"

#include <cstdio>
#include <memory>
#include <stdexcept>

namespace limber::demo {
void performOptions(Session& session, const DemoOptions& options) {
  const auto show = [&session](Layer layer) {
    session.perform({Action::Show, {1.0}, layerList()[static_cast<std::size_t>(layer)].name});
  };
  if (options.window.split) show(Layer::Split);
  if (options.mode == PictureMode::Wireframe) show(Layer::Strain);
  if (options.overlay.contacts) show(Layer::Contacts);
  if (options.overlay.boxes) show(Layer::Boxes);
  if (options.overlay.velocities) show(Layer::Velocities);
  if (options.overlay.constraints) show(Layer::Constraints);
  if (options.overlay.islands) show(Layer::Islands);
  if (options.quality == render::Quality::Gallery) show(Layer::Gallery);
  if (options.camera.path == CameraPath::Fixed)
    session.perform(cameraCommand(orbitOf(options.camera.eye, options.camera.target)));
  for (const Command& command : options.window.settings) session.perform(command);
}

std::unique_ptr<Session> createSession(const DemoOptions& options, const Recording* recording) {
  SceneChoice choice{options.scene, options.sceneOptions};
  WindowSize size{options.width, options.height};
  if (recording) {
    choice = recording->choice;
    choice.options.cacheFolder = options.sceneOptions.cacheFolder;
    size = recording->size;
  }
  constexpr double kPatience = 0.5;  // s
  const auto bars = std::make_shared<StageProgress>(stderr, isTerminal(stderr), kPatience);
  choice.options.cook.progress = [bars](const char* what, double done) {
    bars->show(what, done);
    return stopSignal == 0;
  };
  Result<std::unique_ptr<Session>> session = Session::create(choice, size);
  bars->finish();
  if (stopSignal != 0) throw Stopped{};
  if (!session) throw std::runtime_error(session.error());
  for (const std::string& note : (*session)->scene().notes) std::fprintf(stderr, "%s\n", note.c_str());
  return std::move(*session);
}

ExitCode runReplay(const DemoOptions& options) {
  const Result<Recording> recording = readRecording(options.window.replay);
  if (!recording) throw std::runtime_error(recording.error());
  const std::unique_ptr<Session> session = createSession(options, &*recording);
  Replay replay(*recording);
  while (replay.prepare(*session)) {
    if (stopSignal != 0) throw Stopped{};
    session->tick();
  }
  std::printf("%s", lineOf(stateOf(*session, true)).c_str());
  const std::string& problem = replay.problem();
  if (!problem.empty())
    std::fprintf(stderr, "limber-demo: %s: %s\n", options.window.replay.c_str(), problem.c_str());
  return problem.empty() ? kSuccess : kWrongEnd;
}

}  // namespace limber::demo

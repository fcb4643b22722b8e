// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"
#include "window/command.h"

#include <limber/render/gl_context.h>
#include <limber/render/renderer.h>

#include <string>
#include <variant>
#include <vector>

namespace limber::demo {

enum class PictureMode { Shaded, Wireframe, None };

enum class CameraPath {
  Auto,   ///< fixed, frames View::box of the scene
  Orbit,  ///< orbits View::box once
  Fixed   ///< is at `eye` and looks at `target`
};

struct CameraChoice {
  CameraPath path = CameraPath::Auto;
  Eigen::Vector3d eye = Eigen::Vector3d::Zero(), target = Eigen::Vector3d::Zero();  ///< m, if Fixed
};

/// Lines drawn over the pictures; islands are colours of the bodies.
struct OverlayChoice {
  bool contacts = false, velocities = false, boxes = false, constraints = false, islands = false;
};

/// The interactive window.
struct WindowOptions {
  bool open = false;
  std::string record, replay;     ///< files of all commands; empty: none
  std::string log;                ///< file of what happens; empty: none
  std::string picture;            ///< PNG of the window when it closes; empty: none
  bool split = false;             ///< with btSoftBody beside it
  double seconds = 0.0;           ///< of simulated time, after which it closes; 0: the user closes it
  std::vector<Command> settings;  ///< to begin with
};

/// The scene of a run, and its output.
struct DemoOptions {
  std::string scene = "cubes";
  scenes::SceneOptions sceneOptions;
  double seconds = 0.0;  ///< of simulated time; the default is that of the scene
  int framesPerSecond = 30;
  int width = 960;
  int height = 540;
  PictureMode mode = PictureMode::Shaded;
  render::Quality quality = render::Quality::Gallery;
  CameraChoice camera;
  OverlayChoice overlay;
  render::ContextDesc context;
  std::string outFolder;  ///< of pictures
  std::string statsFile;  ///< empty: none
  bool video = true;      ///< if ffmpeg is installed
  bool preview = true;
  WindowOptions window;
};

/// 1: the input cannot be used or something failed; 2: the command line is wrong; 3: the end check failed.
enum ExitCode : int { kSuccess = 0, kFailure = 1, kUsage = 2, kWrongEnd = 3 };

/// The options, or an exit code after --help, --list, or an error that has been printed.
using ParsedOptions = std::variant<DemoOptions, ExitCode>;
ParsedOptions parseOptions(int argc, char** argv);

/// These parse the value of an option. They return the reason why it is invalid, or an empty string.

/// auto, orbit, or six numbers with commas: position of the eye and of its target.
std::string parseCamera(const std::string& text, CameraChoice& choice);

/// none, or some of contacts, velocities, boxes, constraints and islands with commas.
std::string parseOverlay(const std::string& text, OverlayChoice& choice);

/// NAME=VALUE of a setting of the window; appends the command that sets it.
std::string parseSetting(const std::string& text, std::vector<Command>& commands);

/// auto, osmesa, egl, egl:N for the Nth EGL device, or surfaceless for EGL without devices.
std::string parseContext(const std::string& text, render::ContextDesc& desc);

}  // namespace limber::demo

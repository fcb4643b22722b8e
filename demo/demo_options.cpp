// SPDX-License-Identifier: Zlib
#include "demo_options.h"

#include "number_checks.h"
#include "scenes/networks.h"
#include "scenes/scene_list.h"
#include "window/command.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <map>
#include <sstream>
#include <vector>

namespace limber::demo {
namespace {

constexpr double kMaxSeconds = 3600.0;
constexpr const char* kWindowSize = "1280x720";

std::vector<std::string> sceneNames() {
  std::vector<std::string> names;
  for (const scenes::SceneEntry& entry : scenes::sceneList()) names.push_back(entry.name);
  return names;
}

void printList() {
  for (const scenes::SceneEntry& entry : scenes::sceneList())
    std::printf("%-8s  %s\n", entry.name, entry.about);
}

/// The values that CLI11 sets; some need others.
struct CommandLine {
  DemoOptions options;
  bool list = false;
  bool noVideo = false;
  bool noPreview = false;
  std::string size = "960x540";
  std::string mode = "shaded", quality;
  std::string camera, overlay, context;
  std::string feel = "rubber";
  std::vector<std::string> settings;
  bool braces = false, connect = false, noCache = false;
  const CLI::App* app = nullptr;
  CLI::Option* scene = nullptr;
};

/// Accepts the texts that `parse` accepts, and stores its result in `value`.
template <class Value>
CLI::Validator choice(std::string (*parse)(const std::string&, Value&), Value& value, const char* name) {
  return CLI::Validator([parse, &value](std::string& text) { return parse(text, value); }, name);
}

void addSceneOptions(CLI::App& app, CommandLine& line) {
  scenes::SceneOptions& scene = line.options.sceneOptions;
  line.scene = app.add_option("--scene", line.options.scene, "what to run (default cubes)")
                   ->check(CLI::IsMember(sceneNames()));
  app.add_option("--mesh", scene.meshFile,
                 "run the scene mesh with this file: BODY.limber or any format assimp reads");
  app.add_option("--feel", line.feel, "of the mesh: jelly, rubber (default), foam or stiff")
      ->check(CLI::IsMember(scenes::feels()));
  app.add_option(
         "--points", scene.cook.points,
         "of the mesh: about as many point masses for the largest piece (default: 150 to 400 by shape)")
      ->check(wholeNumber(8, 100000));
  app.add_flag("--braces", line.braces, "of the mesh: braces inside instead of tetrahedra, fewer springs");
  app.add_flag("--connect", line.connect,
               "of the mesh: rods hold its pieces together (default: far pieces are bodies of their own)");
  app.add_flag("--no-cache", line.noCache,
               "cook the mesh again (default: cooked bodies are kept in out/cooked)");
  app.add_option("--count", scene.count, "number of bodies, 1 to 10000")->check(wholeNumber(1, 10000));
  app.add_option("--stiffness", scene.stiffness, "N/m of each spring, 0 or more")->check(number(0.0, 1e9));
  app.add_option("--damping", scene.damping, "N s/m of each spring, 0 or more")->check(number(0.0, 1e6));
  app.add_option("--mass", scene.mass, "kg of each body, above 0")->check(number(1e-6, 1e6));
  app.add_option("--scale", scene.scale,
                 "times the size in the mesh file; the scene mesh makes meshes 1 m large without it")
      ->check(number(1e-6, 1e6));
  app.add_option("--seed", scene.seed, "of heights and rotations (default 1)")->check(wholeNumber(0, 1e15));
}

void addRunOptions(CLI::App& app, CommandLine& line) {
  DemoOptions& o = line.options;
  app.add_option("--seconds", o.seconds, "simulated time (default: until all lies still, 5 to 10)")
      ->check(number(0.1, kMaxSeconds));
  app.add_option("--fps", o.framesPerSecond, "pictures per simulated second, 1 to 240 (default 30)")
      ->check(wholeNumber(1, 240));
  app.add_option("--size", line.size, "of the pictures, WIDTHxHEIGHT (default 960x540)")
      ->check(pictureSize());
  app.add_option("--mode", line.mode, "shaded, wireframe (springs coloured by strain) or none (no pictures)")
      ->check(CLI::IsMember({"shaded", "wireframe", "none"}));
  app.add_option("--quality", line.quality, "gallery (default of pictures) or fast (default of the window)")
      ->check(CLI::IsMember({"gallery", "fast"}));
  app.add_option("--out", o.outFolder, "folder of the pictures (default out/SCENE)");
  app.add_option("--stats", o.statsFile, "write the figures of the run to this JSON file");
  app.add_option("--camera", line.camera, "auto (default), orbit, or EYEX,EYEY,EYEZ,ATX,ATY,ATZ in metres")
      ->check(choice(parseCamera, o.camera, "CAMERA"));
  app.add_option("--overlay", line.overlay,
                 "draw contacts, velocities, boxes, constraints, islands: some, with commas, or none")
      ->check(choice(parseOverlay, o.overlay, "LIST"));
  app.add_option("--context", line.context,
                 "what draws: auto (a GPU if there is one), osmesa, egl, egl:N or surfaceless")
      ->check(choice(parseContext, o.context, "CONTEXT"));
  app.add_flag("--no-video", line.noVideo, "leave out video.mp4, which is made when there is an ffmpeg");
  app.add_flag("--no-preview", line.noPreview, "leave out preview.png, an animated PNG for any browser");
  app.add_flag("--list", line.list, "list the scenes");
}

void addWindowOptions(CLI::App& app, CommandLine& line) {
  WindowOptions& w = line.options.window;
  CLI::Option* window = app.add_flag("--window", w.open, "play with the scene in a window");
  app.add_option("--set", line.settings, "NAME=VALUE of a setting of the window, as its title shows it")
      ->needs(window)
      ->allow_extra_args(false)
      ->check(choice(parseSetting, w.settings, "NAME=VALUE"));
  app.add_flag("--split", w.split, "begin with the same scene played by btSoftBody in the right half")
      ->needs(window);
  CLI::Option* record =
      app.add_option("--record", w.record, "write all that is done in the window to this file")
          ->needs(window);
  app.add_option("--replay", w.replay, "do it again; with --mode none without a window")->excludes(record);
  app.add_option("--log", w.log, "write what happens in the window to this file")->needs(window);
  app.add_option("--picture", w.picture, "write the window as PNG when it closes")->needs(window);
}

/// Returns an error for the first of the options that was given, or an empty string.
std::string without(const CommandLine& line, std::initializer_list<const char*> options, const char* reason) {
  for (const char* option : options)
    if (line.app->count(option) > 0) return std::string(option) + " has no meaning with " + reason;
  return {};
}

/// The same for the options of the window.
std::string windowConflict(const CommandLine& line) {
  const DemoOptions& o = line.options;
  const bool replay = !o.window.replay.empty();
  if (replay && !o.window.open && o.mode != PictureMode::None)
    return "--replay needs --window, or --mode none to run without one";
  std::string reason;
  if (replay)
    reason = without(line,
                     {"--scene", "--mesh", "--count", "--stiffness", "--damping", "--mass", "--scale",
                      "--seed", "--feel", "--points", "--set", "--split", "--camera", "--overlay", "--size"},
                     "--replay: the recording has the scene and the view");
  if (replay && !o.window.open && reason.empty())
    reason =
        without(line, {"--stats", "--seconds", "--fps", "--out", "--context"}, "--replay and --mode none");
  if (!o.window.open || !reason.empty()) return reason;
  if (o.mode == PictureMode::None) return "--mode none has no meaning with --window";
  if (o.camera.path == CameraPath::Orbit) return "--camera orbit has no meaning with --window";
  return without(line, {"--fps", "--out", "--stats", "--context", "--no-video", "--no-preview"}, "--window");
}

/// Returns the reason why valid options do not fit together, or an empty string.
std::string conflict(const CommandLine& line) {
  const DemoOptions& o = line.options;
  const bool meshScene = o.scene == "mesh";
  if (meshScene && o.sceneOptions.meshFile.empty()) return "the scene mesh needs --mesh FILE";
  if (!meshScene && !o.sceneOptions.meshFile.empty())
    return "--mesh goes with the scene mesh, not " + o.scene;
  for (const char* option : {"--feel", "--points", "--braces", "--connect", "--no-cache"})
    if (!meshScene && line.app->count(option) > 0) return std::string(option) + " goes with --mesh";
  if (meshScene && scenes::isLimberFile(o.sceneOptions.meshFile))
    if (std::string reason = without(line, {"--points", "--braces", "--connect", "--no-cache"},
                                     "a .limber file, which is cooked already");
        !reason.empty())
      return reason;
  if (o.sceneOptions.scale && !scenes::findScene(o.scene)->takesScale) {
    return "--scale has no meaning in the scene " + o.scene;
  }
  if (const std::uint32_t bodies = scenes::findScene(o.scene)->bodies; o.sceneOptions.count && bodies > 0)
    return "--count has no meaning in the scene " + o.scene + ", which always has as many bodies";
  if (o.mode == PictureMode::None)
    if (std::string reason =
            without(line, {"--out", "--camera", "--overlay", "--quality", "--context"}, "--mode none");
        !reason.empty())
      return reason;
  return windowConflict(line);
}

/// Sets the values that depend on other options.
void complete(CommandLine& line) {
  DemoOptions& o = line.options;
  const std::map<std::string, PictureMode> modes = {
      {"shaded", PictureMode::Shaded}, {"wireframe", PictureMode::Wireframe}, {"none", PictureMode::None}};
  o.mode = modes.at(line.mode);
  if (line.quality.empty()) line.quality = o.window.open ? "fast" : "gallery";
  o.quality = line.quality == "fast" ? render::Quality::Fast : render::Quality::Gallery;
  o.sceneOptions.feel = scenes::feels().at(line.feel);
  if (line.braces) o.sceneOptions.cook.mode = CookMode::Braces;
  if (line.connect) o.sceneOptions.cook.pieces = PieceRule::Connected;
  if (!line.noCache) o.sceneOptions.cacheFolder = "out/cooked";
  o.video = !line.noVideo;
  o.preview = !line.noPreview;
  if (!o.sceneOptions.meshFile.empty() && line.scene->count() == 0) o.scene = "mesh";
  if (o.window.open) {
    o.window.seconds = o.seconds;
    if (line.app->count("--size") == 0) line.size = kWindowSize;
  }
  parseSize(line.size, o.width, o.height);
  if (o.seconds == 0.0) o.seconds = scenes::findScene(o.scene)->seconds;
  if (o.outFolder.empty()) o.outFolder = "out/" + o.scene;
}

}  // namespace

ParsedOptions parseOptions(int argc, char** argv) {
  CLI::App app("Soft bodies in a Bullet world, drawn without a window, or in one with --window.",
               "limber-demo");
  app.footer(
      "Exit codes: 0 fine, 1 something failed, 2 wrong command line, 3 the scene did not end as it should.");
  CommandLine line;
  line.app = &app;
  addSceneOptions(app, line);
  addRunOptions(app, line);
  addWindowOptions(app, line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kSuccess : kUsage;
  }
  if (line.list) {
    printList();
    return kSuccess;
  }
  complete(line);
  const std::string reason = conflict(line);
  if (!reason.empty()) {
    std::fprintf(stderr, "%s\nRun with --help for more information.\n", reason.c_str());
    return kUsage;
  }
  return line.options;
}

namespace {

std::vector<std::string> splitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

}  // namespace

std::string parseCamera(const std::string& text, CameraChoice& choice) {
  choice = {};
  if (text == "auto") return {};
  choice.path = text == "orbit" ? CameraPath::Orbit : CameraPath::Fixed;
  if (text == "orbit") return {};
  const std::vector<std::string> parts = splitAtCommas(text);
  std::vector<double> values;
  for (const std::string& part : parts)
    if (const std::optional<double> value = finiteNumber(part)) values.push_back(*value);
  if (parts.size() != 6 || values.size() != 6)
    return text + " is neither auto nor orbit nor six numbers EYEX,EYEY,EYEZ,ATX,ATY,ATZ";
  choice.eye = {values[0], values[1], values[2]};
  choice.target = {values[3], values[4], values[5]};
  return choice.eye == choice.target ? text + " has the eye where it looks" : std::string();
}

std::string parseOverlay(const std::string& text, OverlayChoice& choice) {
  choice = {};
  if (text == "none") return {};
  for (const std::string& part : splitAtCommas(text)) {
    if (part == "contacts")
      choice.contacts = true;
    else if (part == "velocities")
      choice.velocities = true;
    else if (part == "boxes")
      choice.boxes = true;
    else if (part == "constraints")
      choice.constraints = true;
    else if (part == "islands")
      choice.islands = true;
    else
      return "\"" + part + "\" is not one of contacts, velocities, boxes, constraints, islands";
  }
  return text.empty() ? "nothing is asked for: say none" : std::string();
}

std::string parseSetting(const std::string& text, std::vector<Command>& commands) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return text + " is not of the form NAME=VALUE";
  const Result<Command> command =
      parseCommand("set " + text.substr(0, equals) + " " + text.substr(equals + 1));
  if (command) commands.push_back(*command);
  return command.error();
}

std::string parseContext(const std::string& text, render::ContextDesc& desc) {
  desc = {};
  if (text == "auto") return {};
  desc.backend = render::Backend::Egl;
  if (text == "osmesa") desc.backend = render::Backend::OSMesa;
  if (text == "surfaceless") desc.backend = render::Backend::EglSurfaceless;
  if (text == "osmesa" || text == "egl" || text == "surfaceless") return {};
  const bool digits =
      text.size() > 4 && text.size() < 7 && text.find_first_not_of("0123456789", 4) == std::string::npos;
  if (text.rfind("egl:", 0) != 0 || !digits)
    return text + " is not one of auto, osmesa, egl, egl:N, surfaceless";
  desc.eglDevice = std::atoi(text.c_str() + 4);
  return {};
}

}  // namespace limber::demo

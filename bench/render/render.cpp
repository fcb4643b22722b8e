// SPDX-License-Identifier: Zlib
#include "render/frames.h"
#include "scene_renderer.h"
#include "scenes/scene_list.h"
#include "timing.h"

#include <limber/render/png_writer_thread.h>

#include <sys/wait.h>
#include <unistd.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <array>
#include <cstdio>
#include <exception>
#include <fstream>
#include <optional>
#include <set>
#include <thread>

namespace limber::bench {
namespace {

// --- frames ---

std::vector<FrameScene> scenesOf(const Options& options) {
  std::vector<FrameScene> scenes;
  for (const std::size_t count :
       options.quick ? std::vector<std::size_t>{64, 1024} : std::vector<std::size_t>{64, 128, 1024, 4096})
    scenes.push_back(makeCubeScene(count));
  scenes.push_back(makeBallScene(options.quick));
  return scenes;
}

std::vector<FrameCase> casesOf(const std::vector<FrameScene>& scenes, const Options& options) {
  std::vector<FrameCase> cases;
  for (const FrameScene& scene : scenes) {
    for (const bool shadows : {false, true}) {
      cases.push_back({&scene, 1280, 720, shadows});
      if (!options.quick) cases.push_back({&scene, 1920, 1080, shadows});
    }
  }
  return cases;
}

std::string describe(const FrameCase& frameCase) {
  const FrameScene& scene = *frameCase.scene;
  const std::string what = scene.bodies() > 1 ? format("%zu %s", scene.bodies(), scene.name.c_str())
                                              : format("%s of %zu triangles", scene.name.c_str(),
                                                       scene.shape.triangles.size() / 3);
  return format("%s, %dx%d, %s", what.c_str(), frameCase.width, frameCase.height,
                frameCase.shadows ? "shadows" : "no shadows");
}

struct Run {
  std::unique_ptr<FrameStage> stage;
  std::vector<FrameTimes> samples;
};

std::vector<Run> openAll(const FrameCase& frameCase, const std::vector<DrawContext>& contexts,
                         const Options& options) {
  std::vector<Run> runs;
  Eigen::Matrix3Xf points;
  for (const DrawContext& context : contexts) {
    for (const DrawPath& path : drawPaths()) {
      if (!options.wantsEngine(path.name, context.name)) continue;
      runs.push_back({std::make_unique<FrameStage>(frameCase, path, context), {}});
      runs.back().stage->addBodies(frameCase.scene->bodies());
      for (int frame = 0; frame < kWarmUp; ++frame) {
        pose(*frameCase.scene, frame, points);
        runs.back().stage->play(points);
      }
    }
  }
  return runs;
}

void playBlock(Run& run, const FrameScene& scene, int firstFrame, int frames) {
  Eigen::Matrix3Xf points;
  for (int i = 0; i < frames; ++i) {
    pose(scene, firstFrame + i, points);
    const FrameTimes times = run.stage->play(points);
    if (i > 0) run.samples.push_back(times);
  }
}

void addRows(const Run& run, const FrameCase& frameCase, Results& results) {
  const FrameScene& scene = *frameCase.scene;
  const Subject subject{scene.name, describe(frameCase), run.stage->path().name, run.stage->context().name};
  results.add(subject, "bodies", "", double(scene.bodies()));
  // that are written in a frame, the floor's 4 included; of the triangles the floor has 2
  results.add(subject, "points", "", double(scene.points()));
  results.add(subject, "triangles", "", double(scene.triangles()));
  addTimes(subject, run.samples, results);
  results.add(subject, "sent per frame", "B", double(run.stage->lastFrame().bytesStreamed));
  results.add(subject, "buffers", "B", double(run.stage->bufferBytes()));
  results.add(subject, "draw calls", "", double(run.stage->lastFrame().drawCalls));
  results.note(subject, "driver", run.stage->driver());
}

/// All contexts and paths are open at once and take turns block by block, in an order that rotates, over the
/// same poses.
void measureFrames(const FrameCase& frameCase, const std::vector<DrawContext>& contexts, const Turns& turns,
                   const Options& options, Results& results) {
  std::vector<Run> runs = openAll(frameCase, contexts, options);
  for (int block = 0; block < turns.blocks; ++block)
    for (std::size_t i = 0; i < runs.size(); ++i)
      playBlock(runs[(i + static_cast<std::size_t>(block)) % runs.size()], *frameCase.scene,
                block * turns.framesPerBlock, turns.framesPerBlock);
  for (const Run& run : runs) addRows(run, frameCase, results);
}

// --- memory of the paths ---

/// What a child process tells its parent.
struct Finding {
  double buffers = 0.0, grown = 0.0;  ///< bytes
};

/// The second number of /proc/self/statm counts pages. 0 where there is no such file.
double residentBytes() {
#if defined(__GLIBC__)
  malloc_trim(0);  // what compiling shaders has left over would hide what comes after
#endif
  std::ifstream file("/proc/self/statm");
  double all = 0.0, resident = 0.0;
  file >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void playFrames(FrameStage& stage, const Eigen::Matrix3Xf& points) {
  constexpr int kFrames = 8;
  for (int frame = 0; frame < kFrames; ++frame) stage.play(points);
}

Finding drawAndMeasure(std::size_t bodies, const DrawPath& path, const DrawContext& context) {
  const FrameScene scene = makeCubeScene(bodies);
  Eigen::Matrix3Xf points;
  pose(scene, 0, points);
  FrameStage stage({&scene, 1280, 720, true}, path, context);
  stage.addBodies(1);
  playFrames(stage, points);
  const double before = residentBytes();
  stage.addBodies(bodies - 1);
  playFrames(stage, points);
  return {static_cast<double>(stage.bufferBytes()), before > 0.0 ? residentBytes() - before : 0.0};
}

[[noreturn]] void runChild(int pipe, std::size_t bodies, const DrawPath& path, const DrawContext& context) {
  try {
    const Finding finding = drawAndMeasure(bodies, path, context);
    const bool told = write(pipe, &finding, sizeof finding) == sizeof finding;
    _exit(told ? 0 : 1);
  } catch (const std::exception&) {
    _exit(1);
  }
}

/// In a process of its own; empty if that fails.
std::optional<Finding> measureInChild(std::size_t bodies, const DrawPath& path, const DrawContext& context) {
  int ends[2];
  if (pipe(ends) != 0) return std::nullopt;
  std::fflush(nullptr);  // or the child would write it once more
  const pid_t child = fork();
  if (child == 0) runChild(ends[1], bodies, path, context);
  close(ends[1]);
  Finding finding;
  const bool told = child > 0 && read(ends[0], &finding, sizeof finding) == sizeof finding;
  close(ends[0]);
  if (child > 0) waitpid(child, nullptr, 0);
  return told ? std::optional<Finding>(finding) : std::nullopt;
}

/// To be called before this process has made any context or thread: it forks.
void measureMemory(std::size_t bodies, const std::vector<DrawContext>& contexts, const Options& options,
                   Results& results) {
  for (const DrawContext& context : contexts)
    for (const DrawPath& path : drawPaths()) {
      if (!options.wantsEngine(path.name, context.name)) continue;
      const std::optional<Finding> finding = measureInChild(bodies, path, context);
      if (!finding) continue;
      const Subject subject{"memory", format("%zu cubes", bodies), path.name, context.name};
      results.add(subject, "buffers per cube", "B", finding->buffers / double(bodies));
      // what a process that has drawn one cube grows by: staging, and with a software driver all of its
      // memory
      if (finding->grown > 0.0)
        results.add(subject, "process per cube", "B", finding->grown / double(bodies));
    }
}

// --- pictures as files ---

demo::DemoOptions demoOptions() {
  demo::DemoOptions options;
  options.width = 1920;
  options.height = 1080;
  return options;
}

/// Times with or without files, ms.
struct Samples {
  std::vector<double> tickWall, tickOwn;    // a sample per tick
  std::vector<double> frameWall, frameOwn;  // a mean per block
};

/// One drop, whose blocks of frames become files or not.
class Drop {
 public:
  explicit Drop(const std::string& folder)
      : folder_(folder), scene_(valueOf(scenes::createCubes({}))), renderer_(*scene_, demoOptions()) {
    renderer_.draw({}, image_);  // the first frame compiles shaders
  }
  ~Drop() {
    for (const std::string& file : files_) std::remove(file.c_str());
  }

  void play(int frames, bool writes) {
    Samples& samples = samples_[writes];
    const Stopwatch watch;
    for (int i = 0; i < frames; ++i) playFrame(i, writes, samples);
    if (writes) writer_.finish();
    const WorkTime block = watch.time();
    samples.frameWall.push_back(block.wallMs / frames);
    samples.frameOwn.push_back(block.cpuMs / frames);
  }

  const Samples& samples(bool writes) const { return samples_[writes]; }

 private:
  void playFrame(int i, bool writes, Samples& samples) {
    const Stopwatch watch;
    scenes::tick(*scene_);
    const WorkTime tick = watch.time();
    samples.tickWall.push_back(tick.wallMs);
    samples.tickOwn.push_back(tick.cpuMs);
    if (writes) image_ = writer_.takeSpare();
    renderer_.draw({}, image_);
    if (!writes) return;
    const std::string file = folder_ + "/render_" + std::to_string(i) + ".png";
    files_.insert(file);
    writer_.submit(file, std::move(image_));
  }

  std::string folder_;
  std::set<std::string> files_;
  std::unique_ptr<scenes::Scene> scene_;
  demo::SceneRenderer renderer_;
  render::Image image_;
  std::array<Samples, 2> samples_;  // without and with files
  render::PngWriterThread writer_;
};

/// Compares the drop of 64 cubes with and without files, block by block of one drop. The files go into the
/// results' folder and are removed again.
void measurePng(const Turns& turns, Results& results) {
  Drop drop(results.folder());
  for (int pair = 0; pair < turns.blocks; ++pair)
    // first without, then with files, then in reverse, so that changes of the drop itself cancel
    for (const bool second : {false, true}) drop.play(turns.framesPerBlock, second != (pair % 2 == 1));
  for (const bool writes : {false, true}) {
    const Subject subject{"files", "64 cubes dropped, 1920x1080", "Limber",
                          writes ? "PNG files" : "no files"};
    const Samples& samples = drop.samples(writes);
    results.add(subject, "tick, wall time", "ms", samples.tickWall);
    results.add(subject, "tick, own time", "ms", samples.tickOwn);
    results.add(subject, "tick and drawing, wall time", "ms", samples.frameWall);
    results.add(subject, "tick and drawing, own time", "ms", samples.frameOwn);
    results.add(subject, "cores", "", std::thread::hardware_concurrency());
  }
}

// --- the bench ---

std::vector<DrawContext> contextsOf(const Options& options) {
  const DrawContext all[] = {{"osmesa", render::Backend::OSMesa}, {"egl", render::Backend::Egl}};
  std::vector<DrawContext> chosen;
  for (const DrawContext& context : all)
    if (options.word("context", context.name) == context.name) chosen.push_back(context);
  return chosen;
}

/// Those that this machine can make; the others are complained about.
std::vector<DrawContext> workingContexts(const Options& options) {
  std::vector<DrawContext> working;
  for (const DrawContext& context : contextsOf(options)) {
    try {
      makeContext(context);
      working.push_back(context);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "limber-bench: without %s: %s\n", context.name, error.what());
    }
  }
  return working;
}

/// Returns the turns, or quick ones, or as many as --set blocks asks for.
Turns turnsOf(const Options& options, Turns turns) {
  if (options.quick) turns = {2, 3};
  turns.blocks = static_cast<int>(options.number("blocks", turns.blocks));
  return turns;
}

void runRender(const Options& options, Results& results) {
  const auto wants = [&](const char* part) { return options.hasWord("part", part, {part}); };
  // first, because it forks, and drivers start threads
  if (wants("memory")) measureMemory(options.quick ? 256 : 4096, contextsOf(options), options, results);
  const std::vector<DrawContext> contexts = workingContexts(options);
  Progress progress;
  if (wants("frames")) {
    const std::vector<FrameScene> scenes = scenesOf(options);
    for (const FrameCase& frameCase : casesOf(scenes, options)) {
      if (!options.wantsScene(describe(frameCase))) continue;
      measureFrames(frameCase, contexts, turnsOf(options, {5, 6}), options, results);
      progress.finish(describe(frameCase));
    }
  }
  if (wants("skins") && !contexts.empty()) {
    measureSkins(contexts[0], options.quick, turnsOf(options, {5, 4}), results);
    progress.finish("skins");
  }
  if (!wants("png")) return;
  measurePng(turnsOf(options, {10, 10}), results);
  progress.finish("frames as PNG");
}

std::vector<std::string> caseNames(const Options& options) {
  const std::vector<FrameScene> scenes = scenesOf(options);
  std::vector<std::string> names;
  for (const FrameCase& frameCase : casesOf(scenes, options))
    if (options.wantsScene(describe(frameCase))) names.push_back(describe(frameCase));
  return names;
}

}  // namespace

Bench renderBench() {
  return {"render",
          "drawing of many bodies, beside the method of the paper and of Bullet's example browser",
          "8 minutes",
          {{"part", "parts to measure", {"frames", "memory", "skins", "png"}, true},
           {"context", "kind of OpenGL context", {"osmesa", "egl"}},
           {"blocks", "turns of each path", 1, 1000}},
          &caseNames,
          &runRender};
}

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#include "results.h"

#include "timing.h"

#include <sys/resource.h>

#include <LinearMath/btScalar.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iomanip>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

namespace limber::bench {
namespace {

/// Returns the value of the first line of /proc/cpuinfo that starts with "model name".
std::string processorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

std::string buildText() {
#ifdef NDEBUG
  const char* kind = "optimised";
#else
  const char* kind = "with assertions: no build to measure with";
#endif
  return format("compiler %s, %s; Bullet %d in %s precision", __VERSION__, kind, BT_BULLET_VERSION,
                sizeof(btScalar) == sizeof(float) ? "single" : "double");
}

std::string numberText(double value) { return format("%.6g", value); }

}  // namespace

Results::Results(const std::string& folder, std::string bench, const std::string& options)
    : folder_(folder), bench_(std::move(bench)) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error("cannot use the folder " + folder + ": " + error.message());
  file_ = folder + "/" + bench_ + ".csv";
  stream_.open(file_);
  write({"bench", "group", "scene", "ticks_per_s", "engine", "setting", "measure", "unit", "value",
         "lower_quartile", "upper_quartile", "samples"});
  describeRun(options);
  rows_ = 0;
}

void Results::describeRun(const std::string& options) {
  const Subject run{"run", "", "", "", 0.0};
  note(run, "machine",
       processorName() + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads");
  note(run, "build", buildText());
  const char* commit = std::getenv("LIMBER_COMMIT");
  note(run, "commit", commit ? commit : "unknown");
  note(run, "options", options);
}

void Results::add(const Subject& subject, const std::string& measure, const std::string& unit, double value) {
  addRow(subject, {measure, unit, numberText(value), "", "", ""});
}

void Results::add(const Subject& subject, const std::string& measure, const std::string& unit,
                  const std::vector<double>& samples) {
  addRow(subject, {measure, unit, numberText(median(samples)), numberText(quantile(samples, 0.25)),
                   numberText(quantile(samples, 0.75)), std::to_string(samples.size())});
}

void Results::note(const Subject& subject, const std::string& measure, const std::string& text) {
  addRow(subject, {measure, "", text, "", "", ""});
}

void Results::addRow(const Subject& s, const std::vector<std::string>& values) {
  const std::string ticks = s.ticksPerSecond > 0.0 ? numberText(s.ticksPerSecond) : "";
  std::vector<std::string> cells = {bench_, s.group, s.scene, ticks, s.engine, s.setting};
  cells.insert(cells.end(), values.begin(), values.end());
  write(cells);
}

void Results::write(const std::vector<std::string>& cells) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    stream_ << (i ? "," : "");
    if (cells[i].find_first_of(",\"\n") == std::string::npos)
      stream_ << cells[i];
    else
      stream_ << std::quoted(cells[i], '"', '"');  // RFC 4180
  }
  stream_ << std::endl;
  if (!stream_) throw std::runtime_error("cannot write " + file_);
  ++rows_;
}

std::string hexText(std::uint64_t value) { return format("%016llx", static_cast<unsigned long long>(value)); }

double peakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace limber::bench

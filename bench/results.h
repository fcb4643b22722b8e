// SPDX-License-Identifier: Zlib
#pragma once

// The one table that all benches write. bench/report.py and bench/plot.py read it.

#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace limber::bench {

/// What was measured: the first columns of a row.
struct Subject {
  std::string group;  ///< of scenes that a table or plot shows together
  std::string scene, engine, setting;
  double ticksPerSecond = 0.0;  ///< 0: nothing is stepped
};

/// FOLDER/BENCH.csv. It grows row by row, so that a run that is stopped leaves its results behind. Throws
/// std::runtime_error with the reason if the file cannot be written.
class Results {
 public:
  /// Makes the folder. The first rows describe the machine, the build, the commit and the options of the run.
  Results(const std::string& folder, std::string bench, const std::string& options);

  void add(const Subject& subject, const std::string& measure, const std::string& unit, double value);
  /// Adds the median of samples, with their quartiles and number.
  void add(const Subject& subject, const std::string& measure, const std::string& unit,
           const std::vector<double>& samples);
  /// Adds a text in place of a value, such as the reason why there is none.
  void note(const Subject& subject, const std::string& measure, const std::string& text);

  bool empty() const { return rows_ == 0; }
  const std::string& folder() const { return folder_; }

 private:
  void describeRun(const std::string& options);
  void addRow(const Subject& subject, const std::vector<std::string>& values);
  void write(const std::vector<std::string>& cells);

  std::string folder_, bench_, file_;
  std::ofstream stream_;
  std::size_t rows_ = 0;
};

/// Returns 16 hexadecimal digits.
std::string hexText(std::uint64_t value);

/// Returns the most memory that the process has held so far, MB of 2^20 bytes.
double peakMegabytes();

/// As printf, up to 300 characters.
[[gnu::format(printf, 1, 2)]] inline std::string format(const char* pattern, ...) {
  char text[300];
  va_list values;
  va_start(values, pattern);
  std::vsnprintf(text, sizeof text, pattern, values);
  va_end(values);
  return text;
}

}  // namespace limber::bench

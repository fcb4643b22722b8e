// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace limber::bench {

/// A CSV file that grows row by row, so that a run that is stopped leaves behind what it has measured.
/// Cells hold no commas or quotes. Throws std::runtime_error with the reason when the file cannot be written.
class CsvTable {
 public:
  CsvTable(std::string file, const std::vector<std::string>& columns);
  void add(const std::vector<std::string>& cells);

 private:
  std::string file_;
  std::ofstream stream_;
};

std::string numberCell(double value);  ///< six digits
std::string countCell(std::uint64_t value);
std::string hexCell(std::uint64_t value);  ///< 16 digits

}  // namespace limber::bench

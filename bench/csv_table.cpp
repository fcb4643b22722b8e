// SPDX-License-Identifier: Zlib
#include "csv_table.h"

#include <cstdio>
#include <stdexcept>
#include <utility>

namespace limber::bench {

CsvTable::CsvTable(std::string file, const std::vector<std::string>& columns)
    : file_(std::move(file)), stream_(file_) {
  add(columns);
}

void CsvTable::add(const std::vector<std::string>& cells) {
  for (std::size_t i = 0; i < cells.size(); ++i) stream_ << (i ? "," : "") << cells[i];
  stream_ << std::endl;
  if (!stream_) throw std::runtime_error("cannot write " + file_);
}

std::string numberCell(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string countCell(std::uint64_t value) { return std::to_string(value); }

std::string hexCell(std::uint64_t value) {
  char text[24];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

}  // namespace limber::bench

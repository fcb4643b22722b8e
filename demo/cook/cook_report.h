// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_analysis.h>
#include <limber/spring_network.h>

#include <array>
#include <cstddef>
#include <string>

namespace limber::demo {

/// All that the reports say.
struct CookReport {
  std::string meshFile;  ///< empty: the body was there already
  std::string bodyFile;
  SharedNetwork network;
  AnalysisSettings settings;
  NetworkAnalysis analysis;
  double cookSeconds = 0.0;
  double analysisSeconds = 0.0;
};

/// For people: some twenty lines, the last of which are describe()'s.
std::string reportText(const CookReport& report);

/// For programs. Bytes of file names that are no UTF-8 are replaced, numbers that are not finite are null.
std::string reportJson(const CookReport& report);

/// Springs by kind.
std::array<std::size_t, 4> springCounts(const SpringNetwork& network);

double bracesPerPoint(const NetworkAnalysis& analysis);

}  // namespace limber::demo

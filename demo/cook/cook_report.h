// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_analysis.h>
#include <limber/spring_network.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace limber::demo {

/// The content of the reports.
struct CookReport {
  std::string meshFile;  ///< empty: the body was loaded, not cooked
  std::string bodyFile;
  SharedNetwork network;
  std::vector<std::string> choices;  ///< of cook() and the files of further bodies, or of the user
  AnalysisSettings settings;
  NetworkAnalysis analysis;
  double cookSeconds = 0.0;
  double analysisSeconds = 0.0;
};

/// Returns the report as text of some twenty lines; the last ones come from describe().
std::string reportText(const CookReport& report);

/// Returns the report as JSON. Bytes of file names that are not UTF-8 are replaced; numbers that are not
/// finite are null.
std::string reportJson(const CookReport& report);

/// Returns the number of springs of each kind.
std::array<std::size_t, 4> springCounts(const SpringNetwork& network);

double bracesPerPoint(const NetworkAnalysis& analysis);

}  // namespace limber::demo

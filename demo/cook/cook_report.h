// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_analysis.h>
#include <limber/spring_network.h>

#include <string>

namespace limber::demo {

/// All that the reports say.
struct CookReport {
  std::string meshFile;  ///< empty if the body was there already
  std::string bodyFile;
  SharedNetwork network;
  AnalysisSettings settings;
  NetworkAnalysis analysis;
  double cookSeconds = 0.0;
  double analysisSeconds = 0.0;
};

/// For people: some twenty lines.
std::string reportText(const CookReport& report);

/// For programs. Bytes of file names that are no UTF-8 are replaced.
std::string reportJson(const CookReport& report);

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_analysis.h>

namespace limber {

/// Mechanisms that every body in a plane (#points - 3 out of it) or on a line (2 #points - 4 across it) has,
/// however many springs join it: to first order nothing resists bending. 0 for solids.
std::size_t bendingMechanisms(NetworkKind kind, std::size_t points);

/// What people should know of a network with this analysis: what is unusual, what should be mended and how.
std::vector<std::string> remarksOn(const SpringNetwork& network, const AnalysisSettings& settings,
                                   const NetworkAnalysis& analysis);

}  // namespace limber

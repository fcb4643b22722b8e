// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <limber/material_network.h>
#include <limber/network_analysis.h>
#include <limber/network_builder.h>
#include <limber/skin.h>

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

namespace limber::demo {

/// What to cook, and what to say about it.
struct CookOptions {
  std::string meshFile;  ///< empty: `bodyFile` is there already and only analysed
  std::string bodyFile;
  bool material = false;  ///< tetrahedra instead of braces
  NetworkSettings network;
  MaterialMesh materialMesh;
  std::uint32_t points = 0;          ///< about as many point masses; 0: those of the mesh
  std::optional<SkinSettings> skin;  ///< asked for, or empty
  AnalysisSettings analysis;
  bool fewerRunsIfLarge = false;  ///< than analysis.runs, see runsFor()
  std::string jsonFile;           ///< empty: none
  std::string pictureFile;        ///< empty: none
  int width = 960;
  int height = 720;
  bool quiet = false;
};

/// Options, or the exit code of a run that is already over (--help or an error, which has been printed).
using ParsedCookOptions = std::variant<CookOptions, ExitCode>;
ParsedCookOptions parseCookOptions(int argc, char** argv);

/// Large deformations of each kind that a body of so many points is tried with: the time of a run grows with
/// points^1.5 and more.
std::uint32_t runsFor(const CookOptions& options, std::size_t points);

}  // namespace limber::demo

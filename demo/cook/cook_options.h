// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <limber/material_network.h>
#include <limber/network_analysis.h>
#include <limber/network_builder.h>
#include <limber/skin.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

// What the command line and the reports call the values of the library's enumerations, in their order.

namespace limber::demo {

template <class Enum, std::size_t count>
struct Names {
  std::array<const char*, count> names;

  const char* operator[](Enum value) const { return names[static_cast<std::size_t>(value)]; }
};

constexpr Names<BraceRule, 4> kBraceRules{{"none", "equal-length", "two-ring", "pipeline"}};
constexpr Names<MassRule, 3> kMassRules{{"equal", "area", "moments"}};
constexpr Names<SkinKind, 3> kSkinKinds{{"dense", "sparse", "barycentric"}};
constexpr Names<NetworkKind, 3> kNetworkKinds{{"rope", "cloth", "solid"}};
constexpr Names<SpringKind, 4> kSpringKinds{{"structural", "shear", "bending", "brace"}};
constexpr Names<Rigidity, 4> kRigidities{{"flexible", "nearly flexible", "soft", "rigid"}};
constexpr Names<Deformation, kDeformations> kDeformationNames{
    {"squash", "twist", "noise", "push", "mirror", "flatten", "inversion"}};

template <class Enum, std::size_t count>
std::vector<std::string> namesOf(const Names<Enum, count>& names) {
  return {names.names.begin(), names.names.end()};
}

/// The value of that name; there must be one.
template <class Enum, std::size_t count>
Enum valueOf(const Names<Enum, count>& names, const std::string& name) {
  std::size_t i = 0;
  while (i + 1 < count && name != names.names[i]) ++i;
  return static_cast<Enum>(i);
}

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

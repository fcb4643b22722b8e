// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <limber/cook.h>
#include <limber/network_analysis.h>
#include <limber/network_builder.h>
#include <limber/result.h>
#include <limber/spring_network.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

// Names of the values of the library's enumerations, in their order, for the command line and the reports.

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

/// Returns the value with this name, which must exist.
template <class Enum, std::size_t count>
Enum valueOf(const Names<Enum, count>& names, const std::string& name) {
  std::size_t i = 0;
  while (i + 1 < count && name != names.names[i]) ++i;
  return static_cast<Enum>(i);
}

/// The input and output of limber-cook.
struct CookOptions {
  std::string meshFile;  ///< empty: `bodyFile` exists already and is only analysed
  std::string bodyFile;
  std::optional<CookSettings> automatic;  ///< cook() chooses; empty: the choices below
  std::string byHand;                     ///< the option that replaced the automatic choice
  bool material = false;                  ///< tetrahedra instead of braces
  NetworkSettings network;
  MaterialMesh materialMesh;
  std::uint32_t points = 0;          ///< about as many point masses; 0: those of the mesh
  std::optional<SkinSettings> skin;  ///< empty: the default
  AnalysisSettings analysis;
  bool fewerRunsIfLarge = false;  ///< large bodies get fewer than analysis.runs, see runsFor()
  std::string jsonFile;           ///< empty: none
  std::string pictureFile;        ///< empty: none
  int width = 960;
  int height = 720;
  bool quiet = false;
};

/// The options, or an exit code after --help or an error that has been printed.
using ParsedCookOptions = std::variant<CookOptions, ExitCode>;
ParsedCookOptions parseCookOptions(int argc, char** argv);

/// Returns the number of large deformations of each kind for a body of so many points. The time of one grows
/// with points^1.5 or faster.
std::uint32_t runsFor(const CookOptions& options, std::size_t points);

/// Makes the body that the options describe. Errors begin with the mesh file's name.
Result<SharedNetwork> cookBody(const CookOptions& options);

/// Cooks or loads the body, then writes, draws and prints the output chosen by the options. Errors go to the
/// standard error stream. After any failure, each file is either complete or unchanged.
ExitCode runCook(const CookOptions& options);

}  // namespace limber::demo

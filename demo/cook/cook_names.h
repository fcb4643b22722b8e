// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_analysis.h>
#include <limber/network_builder.h>
#include <limber/skin.h>

#include <array>
#include <string>
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

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh.h>

#include <string>

namespace limber {

/// Cells along the longest side of a mesh, unless settings say otherwise; and the default of the other sizes,
/// in cells.
constexpr double kWrapCells = 64.0, kWrapWidths = 2.0;

/// Returns the first setting out of range, with the prefix before its name, and its rule; or an empty string.
std::string checkWrapSettings(const WrapSettings& settings, const std::string& prefix);

/// wrap() for functions whose settings contain its settings: errors name the fields with this prefix.
Result<WrappedMesh> wrapOfField(const TriangleMesh& mesh, const WrapSettings& settings,
                                const std::string& prefix);

}  // namespace limber

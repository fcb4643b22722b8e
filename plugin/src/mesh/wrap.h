// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh.h>

#include <string>

namespace limber {

/// Returns the first setting out of range, with the prefix before its name, and its rule; or an empty string.
std::string checkWrapSettings(const WrapSettings& settings, const std::string& prefix);

/// wrap() for functions whose settings contain its settings: errors name the fields with this prefix.
Result<WrappedMesh> wrapOfField(const TriangleMesh& mesh, const WrapSettings& settings,
                                const std::string& prefix);

}  // namespace limber

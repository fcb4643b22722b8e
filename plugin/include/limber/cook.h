// SPDX-License-Identifier: Zlib
#pragma once

// Makes soft bodies of any mesh and chooses what the user leaves open. Thread rule: any thread; calls are
// independent.

#include <limber/export.h>
#include <limber/mesh.h>
#include <limber/network_builder.h>
#include <limber/result.h>
#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace limber {

/// How solids are built.
enum class CookMode : std::uint8_t {
  Tetrahedra,  ///< filled with tetrahedra: buildMaterialNetwork()
  Braces       ///< the simplified surface with braces inside: buildNetwork(); fewer springs
};

/// What becomes of pieces that are farther from each other than `WrapSettings::join`.
enum class PieceRule : std::uint8_t {
  Separate,  ///< each is a body of its own
  Connected  ///< rods that are not drawn hold them together in one body
};

struct CookSettings {
  std::optional<double> size;  ///< m, above 0: longest side of the whole mesh; default: meshes of 0.2 to 5 m
                               ///< keep their size, all others become 1 m long
  std::uint32_t points = 0;    ///< about as many point masses for the largest body, 8 or more; up to half
                             ///< more or a third fewer if thin parts then keep their thickness, up to 150 if
                             ///< fewer miss much of the mesh; 0: 150 to 400, three across the thin parts if
                             ///< possible
  CookMode mode = CookMode::Tetrahedra;
  PieceRule pieces = PieceRule::Separate;
  std::optional<SkinKind> skin;  ///< default: Dense up to 5 000 vertices, else Sparse
  WrapSettings wrap;  ///< of meshes that are not one closed surface; sizes in metres of the resized mesh
  NetworkSettings network;  ///< of CookMode::Braces
  Progress progress;        ///< may be empty; false ends with an error
};

struct CookedMesh {
  /// The largest first, at least one. Their rest points are relative to the origin of the resized mesh.
  /// Sheets have a thickness, and ropes: the diameter, round and with the volume of a closed tube. Solids
  /// have the volume inside the mesh, unless it is not one closed surface or thin parts are thickened.
  std::vector<SharedNetwork> bodies;
  double scale = 1.0;                 ///< m per unit of the mesh
  std::array<std::string, 3> report;  ///< the mesh, the bodies, the drawing: what was chosen, and why
};

/// Makes soft bodies of a mesh: closed, open, of several pieces, intersecting itself, inside out, flat.
/// - One closed surface is filled with tetrahedra, a plate with flat ones. Parts that are too thin for them
/// are
///   thickened.
/// - Any other mesh is wrapped first, see wrap(). Pieces nearer than `wrap.join` are one body.
/// - Sheets (a single open piece with a long border, or flat) become cloths, thin tubes ropes.
/// - Crumbs are left out: pieces smaller than 0.5 % of the largest, and farther than `wrap.join` from all
///   larger ones.
/// - Meshes of more than 32 separate pieces, such as trees with leaves, are one body: rods join the pieces.
/// - The mesh is drawn by a skin. Sheets are drawn by their own points, ropes as tubes.
/// Deterministic. Takes seconds for 50 000 vertices. Errors: those of weld(), wrap() and of the builders;
/// settings out of range; progress that returned false.
LIMBER_API Result<CookedMesh> cook(const TriangleMesh& mesh, const CookSettings& settings = {});

}  // namespace limber

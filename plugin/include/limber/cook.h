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

/// The shape of a body. Rest points of all bodies of a mesh are relative to the origin of the resized mesh.
struct CookedBody {
  SharedNetwork network;
  double thickness = 0.0;  ///< m: of a sheet, or the diameter of a rope, round and with the volume of a
                           ///< closed tube; 0: a solid
  double volume = 0.0;     ///< m^3 inside the mesh, which gives the mass; 0: that of the network, because the
                           ///< mesh is not one closed surface or thin parts are thickened
};

struct CookedMesh {
  std::vector<CookedBody> bodies;     ///< the largest first, at least one
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

/// Returns the settings of a cooked body of this material: as withMaterial() for networks of tetrahedra, with
/// the mass of the mesh's volume, of which tetrahedra fill a few percent more or less. For
/// braces, spring constants follow from  E = sum k L^2 / (6 V)  with the volume V, the modulus of a random
/// isotropic network; for sheets from  E t = sum k L^2 / (3 A)  with the area A and the thickness t, which is
/// exact for a lattice of equilateral triangles, and up to a half too stiff for stretched cells; for ropes
/// from  E A = sum k l^2 / L  with the section A and the length L. Errors: no network; those of
/// withMaterial().
LIMBER_API Result<SoftBodySettings> withMaterial(const CookedBody& body, const Material& material,
                                                 SoftBodySettings settings = {});

}  // namespace limber

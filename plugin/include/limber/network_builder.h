// SPDX-License-Identifier: Zlib
#pragma once

// Builds spring networks. Thread rule: any thread; calls are independent.

#include <limber/export.h>
#include <limber/parallel_for.h>
#include <limber/result.h>
#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <cstdint>
#include <functional>
#include <optional>

namespace limber {

// --- networks from meshes, ropes and cloths ----------------------------------------------------------------

/// Rule for the springs that are added to the edges of the mesh so that the body keeps its shape.
enum class BraceRule : std::uint8_t {
  None,         ///< edges only
  EqualLength,  ///< a spring between any two points whose distance equals the length of some edge (C. Hart's
                ///< rule: on a cube it adds the second diagonal of each face; on a sphere it adds nothing)
  TwoRing,      ///< a spring between any two points that share a neighbour
  Pipeline      ///< chords through the inside, then springs against soft modes, then springs against folding.
                ///< Flat and wide open components have no inside and get the two-ring
};

/// Rule for the distribution of the body's mass among its points.
enum class MassRule : std::uint8_t {
  Equal,  ///< equal masses, as in C. Hart's paper
  Area,  ///< in proportion to a third of the area of the triangles around a point, limited to 0.2 to 10 times
         ///< the mean
  Moments  ///< mass, centre of mass and inertia match those of the solid as far as the points allow; each
           ///< point has at least 0.2 times the mean, points of the surface at most 10 times
};

/// Large deformations from which bodies are released: by BraceRule::Pipeline and by analyse()
/// (network_analysis.h).
enum class Deformation : std::uint8_t {
  Squash,    ///< compression to a tenth along a random direction
  Twist,     ///< by a quarter turn about a random axis
  Noise,     ///< every point is moved by up to half the size of the body
  Push,      ///< one point is moved to 0.2 of the size beyond the opposite side
  Mirror,    ///< the outer 30 % are mirrored through the plane that cuts them off
  Flatten,   ///< into a plane
  Inversion  ///< all points are mirrored through the centre
};
constexpr std::size_t kDeformations = 7;

/// Reports the progress of a long computation: its present part, and the fraction done of that part, 0 to 1.
/// The return value false requests an early end.
using Progress = std::function<bool(const char* what, double done)>;

struct NetworkSettings {
  double weldTolerance = 0.0;  ///< metres, see weld()
  BraceRule braces = BraceRule::Pipeline;
  std::optional<double> braceWeight;  ///< stiffnessScale of braces, above 0; default: 0.5 for Pipeline, 1
                                      ///< for the others
  double maxBracesPerPoint = 1.5;  ///< mean over the points of a piece, above 0; only for Pipeline and pieces
                                   ///< that have an inside: flat and open ones get the complete two-ring
  double timeLimit = 0.0;  ///< s; Pipeline adds no more springs after this time; 0: no limit. If the limit is
                           ///< reached, the network depends on the speed of the machine
  std::uint64_t seed = 1;  ///< of the random deformations of Pipeline
  MassRule masses = MassRule::Equal;
  Progress progress;     ///< may be empty; called on the calling thread
  ParallelFor parallel;  ///< may be empty; for Pipeline, whose springs do not depend on it
};

/// Builds a solid (or open surface) from a mesh: unique positions become point masses, unique triangle edges
/// become springs. Closed surfaces whose normals point inward are flipped, in the surface and in the render
/// surface. Deterministic. Errors: those of weld(); a setting out of range.
LIMBER_API Result<SharedNetwork> buildNetwork(const TriangleMesh& mesh, const NetworkSettings& settings = {});

struct RopeSettings {
  double length = 1.0;          ///< metres, along +x from the origin
  std::uint32_t segments = 16;  ///< at least 1; #points = segments + 1
  double bendingScale = 0.1;    ///< stiffness of the skip-one springs relative to the segments; 0 leaves them
                                ///< out
  double thickness = 0.0;       ///< m, the diameter, for withMaterial(); 0: unknown
};

/// Builds a chain of points along +x with the masses of a uniform rope: its ends have half of the mass of the
/// others. Errors: length not above 0, no segments, more than ten million points,
/// negative bending scale or thickness.
LIMBER_API Result<SharedNetwork> buildRope(const RopeSettings& settings = {});

struct ClothSettings {
  double width = 1.0;          ///< metres along x
  double depth = 1.0;          ///< metres along z
  std::uint32_t columns = 16;  ///< cells along x, at least 1; #points = (columns + 1) * (rows + 1)
  std::uint32_t rows = 16;     ///< cells along z, at least 1
  double shearScale = 0.5;     ///< both diagonals of each cell; 0 leaves them out
  double bendingScale = 0.1;   ///< skip-one springs along x and z; 0 leaves them out
  double thickness = 0.0;      ///< m, for withMaterial(); 0: unknown
  /// Area and Moments: of a uniform sheet, whose border points have half of the mass of the others, corners a
  /// quarter. With equal masses the border of a sheet that falls freely in air overtakes the middle.
  MassRule masses = MassRule::Area;
};

/// Builds a sheet in the plane y = 0, centred at the origin, normal +y. Point (column i, row j) has the
/// index j * (columns + 1) + i; i increases along +x, j along +z. Errors: sizes not above 0, no cells, more
/// than ten million points, negative scales or thickness.
///
///     o---o---o     structural: along x and z
///     | X | X |     shear:      both diagonals
///     o---o---o     bending:    o-------o  every second point along x and z
///
/// Springs along the border have half the stiffness of the others: like the masses, they stand for half a
/// cell.
LIMBER_API Result<SharedNetwork> buildCloth(const ClothSettings& settings = {});

// --- networks of a material --------------------------------------------------------------------------------

struct MaterialMesh {
  std::optional<double> spacing;  ///< m, above 0, of the lattice from which the tetrahedra are made; default:
                                  ///< chosen from `points`
  std::uint32_t points = 300;     ///< approximate number of point masses, 8 or more; used without a spacing
  Progress progress;  ///< when it returns false, the build ends with an error (there is no partial result)
};

/// Builds the network of a body that behaves like a material. The inside of a closed mesh is filled with
/// tetrahedra. Their edges become springs with constants near  k = E sum V / L^2,  the sum over the
/// tetrahedra around the edge (Van Gelder 1998). The constants are fitted to the solid: to its exact response
/// to uniform stresses and to linear ones, such as bending, and to its 20 slowest vibrations by quadratic
/// finite elements. So the body is equally stiff in all directions, and it and its limbs bend and twist as
/// they should. At last all constants are scaled so that the measured Young's modulus equals the requested
/// one (stiffnessPerModulus); plates of one or two cells, whose modulus differs with the direction, bend as
/// they should instead. A bar with two cells across bends within 13 % of beam theory, and
/// mostly twists within 20 %: of nine bars from 3 : 1 to 20 : 1 two are 1.3 and 1.4 times too stiff in
/// torsion (8 : 1 of 250 points, 10 : 1 of 300). Mass fractions follow the volume of the tetrahedra, with a
/// minimum of 0.2 of the mean. The render surface is the mesh with a skin. Concave surfaces are followed to
/// about half a spacing. Takes 1 to 3 s for 300 points, half a minute for 6 000. Errors: those of weld(); a
/// mesh that is not closed (with the number of its open edges; wrap() or cook() help) or encloses no volume;
/// a component that is too thin for the lattice; sizes out of range; progress that returned false.
LIMBER_API Result<SharedNetwork> buildMaterialNetwork(const TriangleMesh& mesh,
                                                      const MaterialMesh& settings = {});

struct Material {
  double youngsModulus = 1e5;  ///< Pa, above 0
  /// From 0.25 (about the value of springs alone) to below 0.5 (by the volume term). Bodies of one or two
  /// cells across get less, down to 0.3 for thin plates, where their volume term would stiffen bending by
  /// more than 1.3
  double poissonRatio = 0.25;
  double density = 1000.0;  ///< kg/m^3, above 0
  /// s, 0 or more: viscosity over modulus (Kelvin, Voigt). An oscillation of w rad/s is damped at the ratio
  /// w dampingTime / 2 within 15 %, on coarse and fine networks alike. Default: the damping in the settings
  /// stays
  std::optional<double> dampingTime = std::nullopt;

  LIMBER_API static Material jelly();   ///< 5e4 Pa, wobbles: a body of 1 m sags by a tenth
  LIMBER_API static Material rubber();  ///< 1.5e6 Pa, natural rubber
  LIMBER_API static Material foam();    ///< 1e5 Pa, light and strongly damped
  LIMBER_API static Material stiff();   ///< 1e7 Pa, hard rubber
};

/// Checks a material. The error is the first value that is out of range.
LIMBER_API Result<void> validate(const Material& material);

/// Returns the settings of a body of this material: spring constants, volume modulus, and the total mass at
/// the scale in `settings`, and the damping if the material has one. All other values are those of
/// `settings`. The mass is that of SpringNetwork::volume, if it has one.
/// - Networks of tetrahedra: modulus and ratio hold for small deformations. They are measured on the network
///   with a few linear solves, which take a second for 5 000 points. The modulus is the mean of those in
///   many directions: a bar has it along its length at a ratio of 0.25, and is too soft there the nearer the
///   ratio is to 0.5. With a ratio of 0.25 a cube that is
///   compressed by more than a fifth to a quarter pushes back no more than 0.17 to 0.18 E A, so a larger load
///   crushes it to half its height; with 0.4 that begins at 35 to 40 %, with 0.49 not below 70 %.
/// - Other solids: E = sum k L^2 / (6 V)  with the volume V, the modulus of a random isotropic network. They,
///   sheets and ropes have a Poisson ratio of their own.
/// - Sheets: E t = sum k L^2 / (3 A)  with the area A and the thickness t, which is exact for a lattice of
///   equilateral triangles, and up to a half too stiff for stretched cells.
/// - Ropes: E A = sum k l^2 / L  with the section A and the length L. Ropes and sheets also get a point
///   radius of half their thickness, if `settings` have none.
/// Errors: a rope or sheet without a thickness; a solid whose surface is open, or has triangles that face
/// different sides; a value out of range.
LIMBER_API Result<SoftBodySettings> withMaterial(const SpringNetwork& network, const Material& material,
                                                 SoftBodySettings settings = {});

// --- skins -------------------------------------------------------------------------------------------------

/// Method by which the vertices of a detailed mesh follow the points of a coarse network.
enum class SkinKind : std::uint8_t {
  Dense,       ///< radial basis functions over all points: smoothest
  Sparse,      ///< the same over the nearest points, distances measured through the body: cheaper, local
  Barycentric  ///< over the corners of the tetrahedron that contains the vertex or is next to it (material
               ///< mode), or those of the nearest triangle and a point on the opposite side of the body:
               ///< cheapest, piecewise linear
};

struct SkinSettings {
  SkinKind kind = SkinKind::Dense;
  std::uint32_t neighbours = 32;  ///< Sparse: maximum number of weights per vertex, 4 or more
  double weldTolerance = 0.0;     ///< m, see weld()
};

/// Returns the network with `mesh` as its render surface. The mesh keeps its position relative to the rest
/// points. Closed components whose normals point inward are flipped; open and inconsistent meshes are
/// oriented outward patch by patch. Affine motions are reproduced exactly, to the precision of the weights. A
/// point has little or no influence if the path to it through the inside of the body is much longer than the
/// straight line, so that parts that almost touch do not drag each other. Errors: those of weld(); a network
/// without a surface, or whose points lie in a plane; fewer than 4 neighbours; a dense skin of more than 20
/// million weights.
LIMBER_API Result<SharedNetwork> withSkin(const SpringNetwork& network, const TriangleMesh& mesh,
                                          const SkinSettings& settings = {});

/// Computes the positions of all skinned points of `skin` (xyz, #skinned points x 3) from the positions of
/// the points (xyz, #points x 3). `skinned` is written in order and never read.
LIMBER_API void applySkin(const Skin& skin, const float* points, float* skinned);

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

// Spring networks: the shapes of soft bodies, and their files. Thread rule: any thread; calls are
// independent.

#include <limber/export.h>
#include <limber/mesh.h>
#include <limber/result.h>

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace limber {

// --- networks ----------------------------------------------------------------------------------------------

/// The purpose of a spring.
enum class SpringKind : std::uint8_t { Structural, Shear, Bending, Brace };

/// The topology of a body: a line, a sheet, or a closed or open surface.
enum class NetworkKind : std::uint8_t { Rope, Cloth, Solid };

/// A spring between two different points, a < b.
struct NetworkSpring {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  SpringKind kind = SpringKind::Structural;
  double stiffnessScale = 1.0;  ///< factor of the body's spring constant and damping
};

/// Springs and points with a name, such as "arms" or "seam". The settings of a body have factors for them
/// (GroupSettings in soft_body_settings.h). Groups may overlap.
struct NamedGroup {
  std::string name;                    ///< not empty, unique in the network
  std::vector<std::uint32_t> springs;  ///< indices into SpringNetwork::springs, ascending
  std::vector<std::uint32_t> points;   ///< indices into SpringNetwork::restPoints, ascending
};

/// Four points of positive volume, (b - a) . ((c - a) x (d - a)) / 6 > 0.
using Tetrahedron = std::array<std::uint32_t, 4>;

/// Skinned points: positions that follow the point masses. Skinned point i is the sum of weights[w] times the
/// position of points[w] over w from firstWeight[i] to firstWeight[i + 1] - 1. The weights of a skinned point
/// sum to 1 and reproduce affine motions.
struct Skin {
  std::vector<std::uint32_t> firstWeight;  ///< #skinned points + 1, or empty: no skin
  std::vector<std::uint32_t> points;       ///< #weights
  std::vector<float> weights;              ///< #weights

  std::size_t size() const { return firstWeight.empty() ? 0 : firstWeight.size() - 1; }
};

/// The surface that is drawn. Each vertex of a mesh follows one point or, with a skin, one skinned
/// point.
struct RenderSurface {
  Skin skin;                                 ///< empty: the vertices follow the points themselves
  std::vector<std::uint32_t> vertexToPoint;  ///< #vertices; index of a point, or of a skinned point
  std::vector<Eigen::Vector2f> uvs;          ///< #vertices, or empty
  std::vector<Triangle> triangles;           ///< #triangles, vertex indices
};

/// Point masses and the springs between them: the shape of a soft body, independent of its size, stiffness
/// and pose. It is built once, never changed, and shared by all bodies of that shape (by shared_ptr<const>).
/// Rest lengths follow from the rest points and the scale of a body.
struct SpringNetwork {
  NetworkKind kind = NetworkKind::Solid;
  std::vector<Eigen::Vector3d> restPoints;  ///< #points, metres, coordinates to 1e9
  std::vector<double> massFractions;        ///< #points, fractions of the total mass, sum 1
  std::vector<NetworkSpring> springs;       ///< #springs, sorted by (a, b), each pair once
  std::vector<Triangle> surface;            ///< #triangles, point indices; empty for ropes
  std::vector<Tetrahedron> tetrahedra;      ///< #tetrahedra that fill the body in material mode, or empty
  double stiffnessPerModulus = 0.0;  ///< m; in material mode the required spring constant (N/m) per Pa of
                                     ///< Young's modulus (network_builder.h), else 0
  double thickness = 0.0;  ///< m, 0 or more: of a sheet, or the diameter of a rope, for its material; 0:
                           ///< unknown, or a solid
  double volume = 0.0;  ///< m^3, 0 or more: of the solid that the network stands for, for its mass; 0: as its
                        ///< tetrahedra, or as its surface encloses
  RenderSurface render;            ///< empty for ropes
  std::vector<NamedGroup> groups;  ///< #groups, in any order
  MeshReport report;               ///< from welding; zeros for ropes and cloths
};

using SharedNetwork = std::shared_ptr<const SpringNetwork>;

/// Returns the network with a group of these points and of all springs between them. Errors: an empty name,
/// or one that the network has already; a point that it does not have.
LIMBER_API Result<SharedNetwork> withGroup(const SpringNetwork& network, const std::string& name,
                                           std::vector<std::uint32_t> points);

/// Checks a network. The error is the first violation of the conditions stated at SpringNetwork's members,
/// with its index.
LIMBER_API Result<void> validate(const SpringNetwork& network);

// --- files -------------------------------------------------------------------------------------------------

/// Returns a network as the bytes of a `.limber` file: magic number, version, size, hash, then the arrays of
/// the members, little-endian on every machine. Equal networks give equal bytes.
LIMBER_API std::vector<std::uint8_t> toBytes(const SpringNetwork& network);

/// Returns the network that toBytes() wrote, bit for bit. Errors, each with its cause: not a .limber file; a
/// version that this library does not support; a file shorter or longer than its header states; a wrong hash;
/// arrays of inconsistent sizes; and everything that validate(SpringNetwork) reports. Never reads past
/// `size`, never allocates more than about `size`.
LIMBER_API Result<SharedNetwork> fromBytes(const std::uint8_t* bytes, std::size_t size);

/// Writes the file under a temporary name and renames it, so that an incomplete file never exists under the
/// final name. Errors name the file; networks that validate(SpringNetwork) rejects are not written.
LIMBER_API Result<void> saveNetwork(const SpringNetwork& network, const std::string& file);

/// Writes points (#points, m) and the springs between them for other programs to look at: .obj with lines, or
/// .ply with edges and their kinds. Errors name the file: another ending or number of points, a file that
/// cannot be written.
LIMBER_API Result<void> saveSprings(const SpringNetwork& network, const std::vector<Eigen::Vector3d>& points,
                                    const std::string& file);

/// Reads a file with fromBytes(). Errors contain the file's name.
LIMBER_API Result<SharedNetwork> loadNetwork(const std::string& file);

}  // namespace limber

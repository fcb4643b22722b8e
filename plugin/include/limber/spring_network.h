// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh_weld.h>
#include <limber/triangle_mesh.h>

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace limber {

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

/// Four points of positive volume, (b - a) . ((c - a) x (d - a)) / 6 > 0.
using Tetrahedron = std::array<std::uint32_t, 4>;

/// Positions that follow the point masses, called places. Place i is the sum of weights[w] times the position
/// of points[w] over w from firstWeight[i] to firstWeight[i + 1] - 1. The weights of a place sum to 1 and
/// reproduce affine motions.
struct Skin {
  std::vector<std::uint32_t> firstWeight;  ///< #places + 1, or empty: no skin
  std::vector<std::uint32_t> points;       ///< #weights
  std::vector<float> weights;              ///< #weights

  std::size_t size() const { return firstWeight.empty() ? 0 : firstWeight.size() - 1; }
};

/// The surface that is drawn. Each vertex of a mesh follows one point or, with a skin, one place of the skin.
struct RenderSurface {
  Skin skin;                                 ///< empty: the vertices follow the points themselves
  std::vector<std::uint32_t> vertexToPoint;  ///< #vertices; index of a point, or of a place of the skin
  std::vector<Eigen::Vector2f> uvs;          ///< #vertices, or empty
  std::vector<Triangle> triangles;           ///< #triangles, vertex indices
};

/// Point masses and the springs between them: the shape of a soft body, independent of its size, stiffness
/// and pose. It is built once, never changed, and shared by all bodies of that shape (by shared_ptr<const>).
/// Rest lengths follow from the rest points and the scale of a body.
struct SpringNetwork {
  NetworkKind kind = NetworkKind::Solid;
  std::vector<Eigen::Vector3d> restPoints;  ///< #points, metres
  std::vector<double> massFractions;        ///< #points, fractions of the total mass, sum 1
  std::vector<NetworkSpring> springs;       ///< #springs, sorted by (a, b), each pair once
  std::vector<Triangle> surface;            ///< #triangles, point indices; empty for ropes
  std::vector<Tetrahedron> tetrahedra;      ///< #tetrahedra that fill the body in material mode, or empty
  double stiffnessPerModulus = 0.0;  ///< m; in material mode the required spring constant (N/m) per Pa of
                                     ///< Young's modulus (material_network.h), else 0
  RenderSurface render;              ///< empty for ropes
  MeshReport report;                 ///< from welding; zeros for ropes and cloths
};

using SharedNetwork = std::shared_ptr<const SpringNetwork>;

/// Returns the first violation of the conditions stated at SpringNetwork's members, with its index, or an
/// empty string.
std::string validate(const SpringNetwork& network);

}  // namespace limber

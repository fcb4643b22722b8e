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

/// What a spring is there for.
enum class SpringKind : std::uint8_t { Structural, Shear, Bending, Brace };

/// The shape of a body in the small: a line, a sheet or a closed or open surface.
enum class NetworkKind : std::uint8_t { Rope, Cloth, Solid };

/// A spring between two different points, a < b.
struct NetworkSpring {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  SpringKind kind = SpringKind::Structural;
  double stiffnessScale = 1.0;  ///< times the body's spring constant and damping factor
};

/// Four points of positive volume, (b - a) . ((c - a) x (d - a)) / 6 > 0.
using Tetrahedron = std::array<std::uint32_t, 4>;

/// Places that ride on the point masses: place i is the sum of weights[w] times the position of points[w]
/// over w from firstWeight[i] to firstWeight[i + 1]. The weights of a place sum to 1 and reproduce affine
/// motions.
struct Skin {
  std::vector<std::uint32_t> firstWeight;  ///< #places + 1, or empty: no skin
  std::vector<std::uint32_t> points;       ///< #weights
  std::vector<float> weights;              ///< #weights

  std::size_t size() const { return firstWeight.empty() ? 0 : firstWeight.size() - 1; }
};

/// How the surface is drawn: the vertices of a mesh, each riding on one point, or, with a skin, on one place
/// of the skin.
struct RenderSurface {
  Skin skin;                                 ///< empty: vertices ride on the points themselves
  std::vector<std::uint32_t> vertexToPoint;  ///< #vertices; index of a point, or of a place of the skin
  std::vector<Eigen::Vector2f> uvs;          ///< #vertices, or empty
  std::vector<Triangle> triangles;           ///< #triangles, vertex indices
};

/// Point masses and the springs between them: the shape of a soft body, independent of its size, stiffness
/// and place. Built once, never changed, shared by all bodies of that shape (hold it by shared_ptr<const>).
/// Rest lengths follow from the rest points and a body's scale.
struct SpringNetwork {
  NetworkKind kind = NetworkKind::Solid;
  std::vector<Eigen::Vector3d> restPoints;  ///< #points, metres
  std::vector<double> massFractions;        ///< #points, share of the total mass, sum 1
  std::vector<NetworkSpring> springs;       ///< #springs, sorted by (a, b), each pair once
  std::vector<Triangle> surface;            ///< #triangles, point indices; empty for ropes
  std::vector<Tetrahedron> tetrahedra;      ///< #tetrahedra that fill the body in material mode, or empty
  double stiffnessPerModulus = 0.0;  ///< m; in material mode the spring constant (N/m) that a body needs
                                     ///< per Pa of Young's modulus (material_network.h), else 0
  RenderSurface render;              ///< empty for ropes
  MeshReport report;                 ///< what welding found; zeros for ropes and cloths
};

using SharedNetwork = std::shared_ptr<const SpringNetwork>;

/// The first thing that breaks the promises of SpringNetwork's members, with its index, or an empty string.
std::string validate(const SpringNetwork& network);

}  // namespace limber

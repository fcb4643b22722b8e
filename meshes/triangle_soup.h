// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

namespace shapes {

constexpr double kPi = 3.14159265358979323846;

struct Corner {
  Eigen::Vector3d position;
  Eigen::Vector2d uv;
};

/// Triangles that share nothing; each counter-clockwise seen from outside.
using TriangleSoup = std::vector<std::array<Corner, 3>>;

/// The quad a, b, c, d as two triangles that share the diagonal a, c.
void addQuad(TriangleSoup& soup, const Corner& a, const Corner& b, const Corner& c, const Corner& d);

struct ObjFormat {
  double scale = 1.0;  ///< units of the file in a metre
  double step = 1e-9;  ///< numbers are rounded to multiples of it, units of the file
  bool uvs = true;     ///< whether texture coordinates are written
};

/// The soup as text of an OBJ file. Numbers are rounded and equal ones stored once, so corners meant to be
/// the same become the same, and the text does not depend on the last bits of the machine's sine.
std::string toObjText(const TriangleSoup& soup, const std::string& name, const ObjFormat& format = {});

}  // namespace shapes

// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>

#include <cmath>
#include <numeric>
#include <string>
#include <utility>

namespace limber {
namespace {

/// Cells along x and z, and the index of the point in column i, row j.
struct Grid {
  std::uint32_t columns;
  std::uint32_t rows;

  std::uint32_t points() const { return (columns + 1) * (rows + 1); }
  std::uint32_t at(std::uint32_t i, std::uint32_t j) const { return j * (columns + 1) + i; }
};

bool isSize(double value) { return std::isfinite(value) && value > 0.0; }
bool isScale(double value) { return std::isfinite(value) && value >= 0.0; }

std::string check(const ClothSettings& settings) {
  if (!isSize(settings.width) || !isSize(settings.depth)) return "width and depth of a cloth must be above 0";
  if (settings.columns == 0 || settings.rows == 0)
    return "a cloth needs at least one column and one row of cells";
  if ((settings.columns + 1.0) * (settings.rows + 1.0) > 1e7)
    return "a cloth of that many cells has more than ten million points";
  if (!isScale(settings.shearScale)) return "the shear scale of a cloth must be 0 or more";
  if (!isScale(settings.bendingScale)) return "the bending scale of a cloth must be 0 or more";
  return {};
}

std::vector<Eigen::Vector3d> clothPoints(const Grid& grid, double width, double depth) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(grid.points());
  for (std::uint32_t j = 0; j <= grid.rows; ++j) {
    for (std::uint32_t i = 0; i <= grid.columns; ++i) {
      const double u = static_cast<double>(i) / grid.columns, v = static_cast<double>(j) / grid.rows;
      points.emplace_back(width * (u - 0.5), 0.0, depth * (v - 0.5));
    }
  }
  return points;
}

/// The springs from point (i, j) to points after it, in ascending order of their index:
///
///     (i, j)    (i+1, j)  (i+2, j)       structural, bending
///     (i-1, j+1)  (i, j+1)  (i+1, j+1)   shear, structural, shear
///               (i, j+2)                 bending
void addSpringsOfPoint(const Grid& grid, const ClothSettings& settings, std::uint32_t i, std::uint32_t j,
                       std::vector<NetworkSpring>& springs) {
  const auto join = [&](std::uint32_t column, std::uint32_t row, SpringKind kind, double scale) {
    if (column > grid.columns || row > grid.rows || scale == 0.0) return;
    springs.push_back({grid.at(i, j), grid.at(column, row), kind, scale});
  };
  join(i + 1, j, SpringKind::Structural, 1.0);
  join(i + 2, j, SpringKind::Bending, settings.bendingScale);
  if (i > 0) join(i - 1, j + 1, SpringKind::Shear, settings.shearScale);
  join(i, j + 1, SpringKind::Structural, 1.0);
  join(i + 1, j + 1, SpringKind::Shear, settings.shearScale);
  join(i, j + 2, SpringKind::Bending, settings.bendingScale);
}

std::vector<NetworkSpring> clothSprings(const Grid& grid, const ClothSettings& settings) {
  std::vector<NetworkSpring> springs;
  for (std::uint32_t j = 0; j <= grid.rows; ++j) {
    for (std::uint32_t i = 0; i <= grid.columns; ++i) addSpringsOfPoint(grid, settings, i, j, springs);
  }
  return springs;
}

/// The diagonals alternate like the fields of a chess board: with parallel ones folds would prefer a
/// direction.
std::vector<Triangle> clothTriangles(const Grid& grid) {
  std::vector<Triangle> triangles;
  for (std::uint32_t j = 0; j < grid.rows; ++j) {
    for (std::uint32_t i = 0; i < grid.columns; ++i) {
      const std::uint32_t a = grid.at(i, j), b = grid.at(i + 1, j), c = grid.at(i + 1, j + 1),
                          d = grid.at(i, j + 1);
      const bool alongAC = (i + j) % 2 == 0;
      triangles.push_back(alongAC ? Triangle{a, d, c} : Triangle{a, d, b});
      triangles.push_back(alongAC ? Triangle{a, c, b} : Triangle{b, d, c});
    }
  }
  return triangles;
}

/// u along +x, v along -z: the picture is upright for someone who looks down at it, with +x to the right.
std::vector<Eigen::Vector2f> clothUvs(const Grid& grid) {
  std::vector<Eigen::Vector2f> uvs;
  uvs.reserve(grid.points());
  for (std::uint32_t j = 0; j <= grid.rows; ++j) {
    for (std::uint32_t i = 0; i <= grid.columns; ++i) {
      const double u = static_cast<double>(i) / grid.columns, v = 1.0 - static_cast<double>(j) / grid.rows;
      uvs.emplace_back(static_cast<float>(u), static_cast<float>(v));
    }
  }
  return uvs;
}

}  // namespace

Result<SharedNetwork> buildCloth(const ClothSettings& settings) {
  if (std::string reason = check(settings); !reason.empty()) return Error{std::move(reason)};
  const Grid grid{settings.columns, settings.rows};
  auto network = std::make_shared<SpringNetwork>();
  network->kind = NetworkKind::Cloth;
  network->restPoints = clothPoints(grid, settings.width, settings.depth);
  network->massShares.assign(grid.points(), 1.0 / grid.points());
  network->springs = clothSprings(grid, settings);
  network->surface = clothTriangles(grid);
  network->render.vertexToPoint.resize(grid.points());
  std::iota(network->render.vertexToPoint.begin(), network->render.vertexToPoint.end(), 0u);
  network->render.uvs = clothUvs(grid);
  network->render.triangles = network->surface;
  return SharedNetwork(std::move(network));
}

}  // namespace limber

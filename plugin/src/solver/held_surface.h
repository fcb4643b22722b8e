// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace limber {

/// A piece of something static: a convex solid, a face of one, or a triangle of a sheet.
struct HeldPiece {
  enum class Kind : std::uint8_t {
    Plane,     ///< through `center`, its normal axes.col(1)
    Box,       ///< `size`: half its edges
    Capsule,   ///< its segment runs along axes.col(1), size[1] to both sides; `margin` is its radius
    Cylinder,  ///< around axes.col(1): radius size[0], half height size[1]
    Cone,      ///< likewise; its tip is at +size[1]
    Face,      ///< of a hull: the faces of one hull share an owner and follow each other
    Sheet      ///< a triangle that is solid on neither side
  };
  Kind kind = Kind::Plane;
  bool metAbove =
      false;  ///< of a Sheet: the point was above or below it, not beside its edges, when last seen
  std::int8_t side = 1;                                ///< of a Sheet: -1 if the point is behind it
  std::uint32_t owner = 0;                             ///< whose contacts these are, within a neighbourhood
  double margin = 0.0;                                 ///< m, of everything about what the other members tell
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< unit columns; of a Face or Sheet the corners
  Eigen::Vector3d center = Eigen::Vector3d::Zero();    ///< m; of a Face or Sheet the unit normal
  Eigen::Vector3d size = Eigen::Vector3d::Zero();      ///< m
};

/// The nearest place on a piece: the point x minus `height` times `normal`.
struct HeldPoint {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from the surface to the point
  double height = 0.0;                                ///< m, below 0 inside
  bool onFace = false;                                ///< in a flat face, not on its edges
};

/// Nearest place of the solid, or triangle, that begins at `first` (before `end`), and where it ends.
HeldPoint nearestOn(const HeldPiece* first, const HeldPiece* end, const Eigen::Vector3d& x);
const HeldPiece* endOfSolid(const HeldPiece* first, const HeldPiece* end);

/// Where a point may touch what is held.
struct HeldContact {
  std::uint32_t owner = 0;
  bool onFace = false;
  Eigen::Vector3d normal, touch;  ///< unit; m, where the point's centre touches
  double gap = 0.0;               ///< m, from here, along the normal
};

/// All pieces that are near a body's points in a tick, one neighbourhood after the other.
struct HeldSurroundings {
  std::vector<HeldPiece> pieces;
  std::vector<HeldContact> contacts;  ///< scratch of findContacts()
};

/// The pieces near one point.
struct HeldNeighbourhood {
  HeldSurroundings* all = nullptr;
  std::size_t begin = 0, end = 0;
  double radius = 0.0;  ///< m, of the point

  // Written by findContacts().
  Eigen::Vector3d clearAt = Eigen::Vector3d::Zero();  ///< m: a point there touches nothing before it has gone
  double clear = 0.0;                                 ///< so far, m; 0: it may touch at once
};

/// Fills all->contacts with the places where a point at `x` that is about to move by `displacement` (m) may
/// touch: each is nearest to the point among all that is held around it, where the point is or where it will
/// meet it. Contacts that are farther than `within` (m) beyond the way are left out. Edges and corners that
/// other pieces cover, as those between the tiles of a floor, are none.
void findContacts(HeldNeighbourhood& around, const Eigen::Vector3d& x, const Eigen::Vector3d& displacement,
                  double within);

/// Whether something of radius `radius` that touches at `place` along `normal` would overlap other pieces.
/// Pieces that `place` itself is on do not count.
bool isCovered(const HeldPiece* begin, const HeldPiece* end, const Eigen::Vector3d& place,
               const Eigen::Vector3d& normal, double radius);

}  // namespace limber

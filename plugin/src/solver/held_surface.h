// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/plane_kernel.h"

#include <Eigen/Core>

#include <cstdint>
#include <utility>
#include <vector>

namespace limber {

/// A piece of an object at rest: a convex solid, a face of a convex hull, or a triangle of a sheet.
struct HeldPiece {
  enum class Kind : std::uint8_t {
    Plane,     ///< through `center`, its normal axes.col(1)
    Box,       ///< `size`: half its edges
    Capsule,   ///< its segment extends along axes.col(1), size[1] to both sides; `margin` is its radius
    Cylinder,  ///< around axes.col(1): radius size[0], half height size[1]
    Cone,      ///< likewise; its tip is at +size[1]
    Face,      ///< of a convex hull; the faces of one hull share an owner and are adjacent in the array
    Sheet      ///< a triangle that is solid on neither side
  };
  Kind kind = Kind::Plane;
  bool metAbove = false;    ///< Sheet: at the last test the point was above or below it, not beside its edges
  std::int8_t side = 1;     ///< Sheet: -1 if the point is behind it
  std::uint32_t owner = 0;  ///< index of the owner of the contacts with this piece, within a neighbourhood
  double margin = 0.0;      ///< m, added around the shape that the other members describe
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< unit columns; Face or Sheet: the corners
  Eigen::Vector3d center = Eigen::Vector3d::Zero();    ///< m; Face or Sheet: the unit normal
  Eigen::Vector3d size = Eigen::Vector3d::Zero();      ///< m
};

/// The nearest point on a piece: x minus `height` times `normal`.
struct HeldPoint {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from the surface to the point
  double height = 0.0;                                ///< m, below 0 inside
  bool onFace = false;                                ///< the point is in a flat face, not on its edges
};

/// nearestOn() returns the nearest point of the solid, or triangle, that begins at `first` (before `end`),
/// and endOfSolid() its end.
HeldPoint nearestOn(const HeldPiece* first, const HeldPiece* end, const Eigen::Vector3d& x);
const HeldPiece* endOfSolid(const HeldPiece* first, const HeldPiece* end);

/// A possible contact of a point with held pieces.
struct HeldContact {
  std::uint32_t owner = 0;
  bool onFace = false;
  Eigen::Vector3d normal, touch;  ///< unit; m, centre of the touching point
  double gap = 0.0;               ///< m, from the present position along the normal
};

/// All pieces near a body's points in a tick, one neighbourhood after the other.
struct HeldSurroundings {
  std::vector<HeldPiece> pieces;
  std::vector<std::uint64_t> edgeKeys;  ///< scratch
  double maxSearchDistance = 0.0;  ///< m, within which a point has few pieces; infinite: all have few so far
};

/// The pieces near one point.
struct HeldNeighbourhood {
  HeldSurroundings* all = nullptr;
  std::size_t begin = 0, end = 0;
  double radius = 0.0;  ///< m, of the point

  // Written by findContacts().
  std::vector<HeldContact> contacts;  ///< no other point's, since threads share the points
  std::vector<std::pair<HeldContact, std::size_t>> edges;  ///< scratch: contacts beside faces, their pieces
  Eigen::Vector3d clearAt = Eigen::Vector3d::Zero();       ///< m, the position at which `clear` was computed
  double clear = 0.0;  ///< m, motion from there without a contact; 0: contact is possible at once
};

/// Returns a piece of Kind::Capsule for the kernels.
kernel::Capsule<double> capsuleOf(const HeldPiece& piece);

/// Returns the only piece near the point if it is a convex solid, else nullptr. Nothing hides or covers its
/// contact.
const HeldPiece* singleSolid(const HeldNeighbourhood& around);

/// Finds the contact with a single solid, see below. `radius`: m, of the point. Returns false if there is
/// none.
bool findContact(const HeldPiece& solid, double radius, const Eigen::Vector3d& x,
                 const Eigen::Vector3d& displacement, double within, HeldContact& contact);

/// Fills around.contacts with the possible contacts of a point at `x` that is about to move by `displacement`
/// (m). Each is with the nearest of all surfaces around, at the point or where it will hit the surface.
/// Contacts farther than `within` (m) beyond the displacement are left out, and so are edges and corners that
/// other pieces cover, as between the tiles of a floor.
void findContacts(HeldNeighbourhood& around, const Eigen::Vector3d& x, const Eigen::Vector3d& displacement,
                  double within);

/// A point of a piece that is touched along `normal`: on the piece without its margin (m).
struct TouchedPoint {
  Eigen::Vector3d core, normal;
  double margin;

  Eigen::Vector3d onSurface() const { return core + margin * normal; }
};

/// Whether a small sphere that leans against the touched point along `normal` would overlap other pieces.
/// Pieces on which the point lies do not count. `radius`: m, of the body's surface. Pieces with the same
/// margin are compared without it: an edge that the margin makes round is an edge still.
bool isCovered(const HeldPiece* begin, const HeldPiece* end, const TouchedPoint& touched,
               const Eigen::Vector3d& normal, double radius);

}  // namespace limber

// SPDX-License-Identifier: Zlib

// The surfaces of objects at rest, and the contacts of points with planes and with these surfaces.

#pragma once

#include "solver/springs.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
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

// --- contacts ----------------------------------------------------------------------------------------------

/// The impulse of a contact in a tick, in which its normal may rotate.
struct TickImpulse {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();       ///< N s
  Eigen::Vector3d pressing = Eigen::Vector3d::Zero();  ///< N s, part along the normals
  double along = 0.0;  ///< N s along the normals: 0 or more, since surfaces do not pull

  /// Adds `impulse`, whose component along the unit normal is `size`.
  void add(const Eigen::Vector3d& impulse, const Eigen::Vector3d& normal, double size) {
    sum += impulse;
    pressing += size * normal;
    along += size;
  }
  TickImpulse& operator+=(const TickImpulse& other) {
    sum += other.sum;
    pressing += other.pressing;
    along += other.along;
    return *this;
  }
};

/// What the contact of a point with a plane and the contact of two bodies have in common.
struct ContactBase {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from the surface to the point, or from b to a
  double friction = 0.0;
  double restitution = 0.0;
  double bounceThreshold = 0.0;     ///< m/s, slower approaches do not bounce, so that bodies come to rest
  double recoverySpeed = HUGE_VAL;  ///< m/s, largest speed at which an overlap is removed
  TickImpulse impulse;              ///< on the point, or on a; written by the step
};

/// The motion along the normal that a contact asks for in a substep; written by the step.
struct ContactTarget {
  double target = 0.0;   ///< m/s, least speed along the normal in the drift
  double rebound = 0.0;  ///< m/s, this and the next: see Bounce
  double fastest = 0.0;  ///< m/s
  bool bounces = false;

  /// m/s, the speed after a bounce whose second half begins at the speed `now`.
  double speedAfter(double now) const { return std::min(now + rebound, fastest); }
};

/// A point mass above a static or kinematic surface: the point's centre must stay on the outer side of a
/// plane, and slides on it with Coulomb friction.
///
///     gap(t) = normal . (x(t) - touch - t surfaceVelocity) >= 0,    t from the start of the tick
///
/// Where the surface is not flat around the point, the plane is updated in each substep.
struct PlaneContact : ContactBase, ContactTarget {
  std::uint32_t point = 0;
  std::uint32_t partner = 0;                        ///< the caller's number of the object
  Eigen::Vector3d touch = Eigen::Vector3d::Zero();  ///< m, the centre of a touching point at the tick's start
  Eigen::Vector3d surfaceVelocity = Eigen::Vector3d::Zero();  ///< m/s, at the tick's start; of pieces at rest
                                                              ///< (a belt), across the present normal
  Eigen::Vector3d surfaceAcceleration =
      Eigen::Vector3d::Zero();  ///< m/s^2, of a surface that turns; across the normal
  double time = 0.0;            ///< s, since the tick's start, of the present substep's middle
  bool coupled = false;         ///< solved together with the contacts between bodies (contacts.h)

  HeldNeighbourhood* around = nullptr;  ///< followed pieces of a surface at rest; nullptr: the plane is fixed
  std::uint32_t owner = 0;              ///< of its pieces in `around`
  bool away = false;                    ///< the point cannot touch these pieces in the next substep
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();  ///< planes whose normals point away from it do not act

  // Written by the step.
  double mass = 0.0;      ///< kg along the normal; 0: cannot be moved
  bool touching = false;  ///< has an impulse in the present substep
  Eigen::Vector3d lastVelocity =
      Eigen::Vector3d::Zero();  ///< m/s of the point at the end of the last substep
};

/// The indices of the rows of one point. Rows are sorted by point.
struct ContactRange {
  std::size_t begin, end;
};
ContactRange contactsOfPoint(const std::vector<PlaneContact>& rows, std::uint32_t point);

// --- laws of contact: recovery, friction, restitution ------------------------------------------------------

using kernel::minSpeed, kernel::coneFactor;

/// A substep in which a point hits a surface and leaves it by Newton's law of restitution: along the normal
/// `mean` is the speed of the drift, and `rebound` is added after the second kick, up to the speed `fastest`.
/// Several contacts that share points, as an edge and its ends, bounce in the same substep: without that
/// limit their rebounds would add up.
///
/// The point hits the surface at the position and time of motion under a constant force, and continues from
/// there. The drift's own speed belongs to another time: with it, points pressed onto a surface would gain
/// energy at some times and lose it at others, and would gain on average.
struct Bounce {
  bool rests = true;  ///< no bounce: the point is slow, or would bounce too often within the substep
  double mean = 0.0, rebound = 0.0, fastest = 0.0;
};

/// Computes a bounce over dt seconds. `approach` is the point's speed after the first kick, `before` that at
/// the start of the substep; slower impacts than `slow` do not bounce.
Bounce bounceOf(double gap, double approach, double before, double restitution, double slow, double dt);

/// Lets the contact bounce if it would close in a drift of dt seconds and is fast enough. Arguments as in
/// bounceOf(). target.target must be set for a contact that does not bounce.
void addBounce(ContactTarget& target, const ContactBase& contact, double gap, double approach, double before,
               double dt);

/// Whether the contacts are with fixed planes (kernel::Plane), at most one per point.
bool areFixedPlanes(const std::vector<PlaneContact>& rows);

// --- points on planes --------------------------------------------------------------------------------------

/// Points whose contacts are one task: enough work for a thread, and few enough for an even load.
constexpr std::uint32_t kContactPoints = 128;

/// Rows in the layout of the kernel that solves four at once: those of points with one row, on a fixed plane
/// or on a ball or capsule at rest, without a bounce. Until they are unpacked, the rows do not change.
struct PackedPlanes {
  static constexpr std::uint32_t kNoRow = static_cast<std::uint32_t>(-1);

  // Four by four, see kernel::PlaneBody. All points of a group are in the same block.
  std::vector<unsigned> points, capsuleOf;
  std::vector<std::uint32_t> rows;  ///< 4 x #groups; kNoRow: fills up the group
  AlignedNumbers planes;
  std::vector<kernel::Capsule<double>> capsules;
  double radius = 0.0;  ///< m, of points on capsules

  std::vector<Range> loose;  ///< the rows of each other point

  /// The first group and the first entry of `loose` of kContactPoints points.
  struct Block {
    std::uint32_t group, loose;
  };
  std::vector<Block> blocks;  ///< #blocks + 1
};

/// Packs the rows of a body with this number of points. Call it after prepareContacts().
void packPlanes(const std::vector<PlaneContact>& rows, std::uint32_t points, PackedPlanes& packed);

/// Updates the rows from the packed ones.
void unpackPlanes(PackedPlanes& packed, std::vector<PlaneContact>& rows);

constexpr std::size_t kPlaneNumbers = sizeof(kernel::Plane<double>) / sizeof(double);

/// Copy a row to a lane of a kernel::Plane, and back. `numbers`: the lane's first number; `lanes`: how many
/// there are.
void toLane(const PlaneContact& row, double* numbers, std::size_t lanes);
void fromLane(const double* numbers, std::size_t lanes, PlaneContact& row);

/// All rows of a body, or those of some of its points.
struct ContactRows {
  PlaneContact *first, *last;
  PackedPlanes* packed = nullptr;      ///< nullptr: none is packed
  PackedPlanes::Block begin{}, end{};  ///< in it

  explicit ContactRows(std::vector<PlaneContact>& rows, PackedPlanes* p = nullptr)
      : first(rows.data()), last(first + rows.size()), packed(p) {
    if (p) begin = p->blocks.front(), end = p->blocks.back();
  }
  /// The rows of the points from `from` to `to`: kContactPoints of them, or the last ones.
  ContactRows(std::vector<PlaneContact>& rows, PackedPlanes* p, std::uint32_t from, std::uint32_t to)
      : ContactRows(rows, p) {
    if (p) {
      begin = p->blocks[from / kContactPoints], end = p->blocks[from / kContactPoints + 1];
    } else {
      first = rows.data() + contactsOfPoint(rows, from).begin;
      last = rows.data() + contactsOfPoint(rows, to).begin;
    }
  }
};

/// Updates the planes of the `count` rows of one point to the surfaces at the point, or where it hits them
/// within `displacement` (m). Finds surfaces up to `within` (m) beyond that.
void followSurface(PlaneContact* rows, std::size_t count, const PointView& points,
                   const Eigen::Vector3d& displacement, double within);

/// Does the same for all points, before a substep of dt.
void followSurfaces(std::vector<PlaneContact>& rows, const PointView& points, double dt);

/// Computes the masses of the rows before the first substep of a tick.
void prepareContacts(std::vector<PlaneContact>& rows, const PointView& points);

/// Changes velocities before a drift of `dt` from `time` (s since the start of the tick): no point ends below
/// a surface, and friction reduces sliding as far as it can. A point already below is lifted slowly. Rows of
/// one point alternate until they agree; rows of different points are independent, so this is exact.
void solvePositions(const ContactRows& rows, const PointView& points, double time, double dt);

/// Finds contacts that were not predicted at the tick's start. Called before solvePositions() of each drift.
struct ContactWatch {
  bool on = false;
  std::vector<PlaneContact> rows;  ///< found in this tick
  virtual ~ContactWatch() = default;

  /// Around each point the ball in which its contacts are known in this tick. Held points have none.
  struct Regions {
    const Points* center;                 ///< 3 x #points, m
    const std::vector<double>* distance;  ///< #points, m
  };
  virtual Regions regions() const = 0;

  /// Returns whether one of the points from `begin` to `end` leaves its search region within dt seconds. Then
  /// look() finds its contacts.
  virtual bool anyLeaves(const PointView& points, double dt, std::uint32_t begin,
                         std::uint32_t end) const = 0;
  virtual void look(const PointView& points, double time, double dt) = 0;
  /// Moves the rows to those of the body.
  virtual void merge() = 0;
};

/// Changes velocities after the second kick of a substep: points that touch do not approach. Completes
/// solvePositions as RATTLE completes SHAKE: velocities are those of bodies at rest, not of a step in free
/// fall.
void solveVelocities(const ContactRows& rows, const PointView& points);

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "solver/plane_contacts.h"

#include "solver/lane_kernels.h"

namespace limber {
namespace {

/// Sweeps over the rows of a point between two or three surfaces.
constexpr int kSweepsInCorners = 8;

/// Bounces within a substep; a point with more of them rests.
constexpr int kMaxBounces = 8;

/// Adds in the order of the kernels, unlike Eigen: see pack.h.
inline double dot(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return kernel::dot(a.data(), b.data());
}

/// Brings the point's normal speed relative to the surface up to `target`, with friction against sliding.
inline void applyRow(PlaneContact& row, const PointView& points, double target) {
  auto velocity = points.velocityOf(row.point);
  const Eigen::Vector3d relative = velocity - row.surfaceVelocity - row.time * row.surfaceAcceleration;
  const double speed = dot(row.normal, relative);
  row.touching = speed < target && row.mass > 0.0;
  if (!row.touching) return;
  Eigen::Vector3d impulse;
  const double along = kernel::contactImpulse(row.normal.data(), relative.data(), speed, target, row.mass,
                                              row.friction, impulse.data());
  velocity += points.inverseMassOf(row.point).cwiseProduct(impulse);
  row.impulse.add(impulse, row.normal, along);
}

inline double speedAlong(const PlaneContact& row, const PointView& points) {
  return dot(row.normal, points.velocityOf(row.point) - row.surfaceVelocity);
}

/// Sets the target speed of the point before a drift of dt from `time`.
inline void setTarget(PlaneContact& row, const PointView& points, double time, double dt) {
  const double gap = dot(row.normal, points.positionOf(row.point) - row.touch - time * row.surfaceVelocity);
  row.target = minSpeed(gap, row.recoverySpeed, dt);
  row.time = time + 0.5 * dt;
  row.bounces = false;
  if (!(row.restitution > 0.0)) return;
  const double before = dot(row.normal, row.surfaceVelocity - row.lastVelocity);
  addBounce(row, row, gap, -speedAlong(row, points), before, dt);
}

/// Applies the second half of a bounce, an impulse along the normal or against it.
inline void finishBounce(PlaneContact& row, const PointView& points) {
  if (row.rebound > 0.0) return applyRow(row, points, row.speedAfter(speedAlong(row, points)));
  const double size = row.rebound * row.mass;
  const Eigen::Vector3d impulse = size * row.normal;
  points.velocityOf(row.point) += points.inverseMassOf(row.point).cwiseProduct(impulse);
  row.impulse.add(impulse, row.normal, size);
}

using kernel::kSearchBeyond, kernel::kSupportDistance;

double massAlongNormal(const PlaneContact& row, const PointView& points) {
  const double mobility = dot(row.normal, points.inverseMassOf(row.point).cwiseProduct(row.normal));
  return mobility > 0.0 && !row.coupled && !row.away ? 1.0 / mobility : 0.0;
}

HeldNeighbourhood* neighbourhoodOf(const PlaneContact* rows, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].around) return rows[i].around;
  return nullptr;
}

/// Returns the unused row of the contact's owner whose plane was most similar to the contact's, or nullptr.
PlaneContact* unusedRowFor(const HeldContact& c, PlaneContact* rows, std::size_t count) {
  PlaneContact* best = nullptr;
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].around && rows[i].away && rows[i].owner == c.owner)
      if (!best || rows[i].normal.dot(c.normal) > best->normal.dot(c.normal)) best = rows + i;
  return best;
}

/// Sets the row's plane to that of the contact.
void setPlane(PlaneContact& row, const HeldContact& c, const PointView& points) {
  row.away = c.normal.dot(row.facing) < 0.0;
  row.normal = c.normal;
  row.surfaceVelocity -= dot(c.normal, row.surfaceVelocity) * c.normal;
  row.touch = c.touch;
  row.mass = massAlongNormal(row, points);
}

/// Finds the contact of the row with the only solid near its point, with the bits of kernel::follow().
bool findSingle(const HeldPiece& solid, double radius, const PlaneContact& row, const Eigen::Vector3d& x,
                const Eigen::Vector3d& displacement, double within, HeldContact& c) {
  if (solid.kind != HeldPiece::Kind::Capsule) return findContact(solid, radius, x, displacement, within, c);
  c.normal = row.normal, c.touch = row.touch;
  return kernel::followCapsule(capsuleOf(solid), x.data(), displacement.data(), within, radius,
                               c.normal.data(), c.touch.data()) <= 1.0;
}

/// The case of most points: one fixed plane.
bool isSingleFixedPlane(const PlaneContact* rows, std::size_t count) { return count == 1 && !rows->around; }

/// Calls visit(rows, count) for each point whose rows are not packed.
template <class Visit>
void forEachPoint(const ContactRows& rows, Visit visit) {
  if (rows.packed) {
    for (std::uint32_t i = rows.begin.loose; i < rows.end.loose; ++i) {
      const Range& range = rows.packed->loose[i];
      visit(rows.first + range.begin, std::size_t{range.end - range.begin});
    }
    return;
  }
  PlaneContact* first = rows.first;
  for (PlaneContact* end = first; first != rows.last; first = end) {
    do ++end;
    while (end != rows.last && end->point == first->point);
    visit(first, static_cast<std::size_t>(end - first));
  }
}

kernel::PlaneBody planeBody(PackedPlanes& p, const PointView& points) {
  return {p.points.data(), numbers(p.planes), p.capsuleOf.data(), p.capsules.data(),
          p.radius,        points.position,   points.velocity,    points.inverseMass};
}

void follow(PlaneContact* rows, std::size_t count, const PointView& points, double dt, double beyond) {
  if (const HeldNeighbourhood* around = neighbourhoodOf(rows, count))
    followSurface(rows, count, points, dt * points.velocityOf(rows->point), beyond * around->radius);
}

void solvePointPosition(PlaneContact* rows, std::size_t count, const PointView& points, double time,
                        double dt) {
  follow(rows, count, points, dt, kSearchBeyond);
  bool changes = true;
  for (int sweep = 0; sweep < (count > 1 ? kSweepsInCorners : 1) && changes; ++sweep) {
    changes = false;
    for (std::size_t i = 0; i < count; ++i) {
      PlaneContact& row = rows[i];
      if (sweep == 0) setTarget(row, points, time, dt);
      const bool before = sweep > 0 && row.touching;
      applyRow(row, points, row.target);
      changes = changes || row.touching;
      row.touching = row.touching || before;
    }
  }
}

/// Sets `touching` for surfaces that have been followed to the present position of the point.
void updateTouching(PlaneContact* rows, std::size_t count, const PointView& points) {
  for (std::size_t i = 0; i < count; ++i) {
    PlaneContact& row = rows[i];
    if (!row.around) continue;
    const double gap = row.normal.dot(points.positionOf(row.point) - row.touch);
    row.touching = !row.away && (row.touching || gap <= kSupportDistance * row.around->radius);
  }
}

void solvePointVelocity(PlaneContact* rows, std::size_t count, const PointView& points) {
  bool touches = false;
  for (std::size_t i = 0; i < count; ++i)
    touches = touches || rows[i].touching || (rows[i].coupled && rows[i].around);
  if (!touches) return;
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].touching && rows[i].bounces) finishBounce(rows[i], points);
  follow(rows, count, points, 0.0, kSupportDistance);
  updateTouching(rows, count, points);
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].touching && !rows[i].bounces) applyRow(rows[i], points, 0.0);
}

}  // namespace

bool areFixedPlanes(const std::vector<PlaneContact>& rows) {
  const auto isOther = [](const PlaneContact& row) {
    return row.around || row.restitution > 0.0 || !row.surfaceAcceleration.isZero(0.0);
  };
  const auto haveOnePoint = [](const PlaneContact& a, const PlaneContact& b) { return a.point == b.point; };
  return std::none_of(rows.begin(), rows.end(), isOther) &&
         std::adjacent_find(rows.begin(), rows.end(), haveOnePoint) == rows.end();
}

ContactRange contactsOfPoint(const std::vector<PlaneContact>& rows, std::uint32_t point) {
  const auto isBefore = [](const PlaneContact& row, std::uint32_t i) { return row.point < i; };
  const auto first = std::lower_bound(rows.begin(), rows.end(), point, isBefore);
  auto end = first;
  while (end != rows.end() && end->point == point) ++end;
  return {static_cast<std::size_t>(first - rows.begin()), static_cast<std::size_t>(end - rows.begin())};
}

void followSurface(PlaneContact* rows, std::size_t count, const PointView& points,
                   const Eigen::Vector3d& displacement, double within) {
  HeldNeighbourhood* around = neighbourhoodOf(rows, count);
  if (!around) return;
  if (const HeldPiece* solid = count == 1 ? singleSolid(*around) : nullptr) {
    HeldContact c;
    const Eigen::Vector3d x = points.positionOf(rows->point);
    if (findSingle(*solid, around->radius, *rows, x, displacement, within, c))
      setPlane(*rows, c, points);
    else
      rows->away = true, rows->mass = 0.0;
    return;
  }
  findContacts(*around, points.positionOf(rows->point), displacement, within);
  for (std::size_t i = 0; i < count; ++i)
    if (rows[i].around) rows[i].away = true, rows[i].mass = 0.0;
  for (const HeldContact& c : around->contacts) {
    if (PlaneContact* row = unusedRowFor(c, rows, count)) setPlane(*row, c, points);
  }
}

void followSurfaces(std::vector<PlaneContact>& rows, const PointView& points, double dt) {
  forEachPoint(ContactRows(rows), [&](PlaneContact* first, std::size_t count) {
    follow(first, count, points, dt, kSearchBeyond);
  });
}

void prepareContacts(std::vector<PlaneContact>& rows, const PointView& points) {
  for (PlaneContact& row : rows) {
    row.mass = massAlongNormal(row, points);
    row.lastVelocity = points.velocityOf(row.point);
  }
}

Bounce bounceOf(double gap, double approach, double before, double restitution, double slow, double dt) {
  const double distance = std::max(gap, 0.0);
  const double kick = approach - before, pressing = 2.0 * kick / dt;
  // the sum is negative by rounding only: the point hits the surface within the substep
  const double impact = std::sqrt(std::max(0.0, before * before + 2.0 * pressing * distance));
  double speed = restitution * impact;
  double timeLeft = dt - (distance > 0.0 ? std::min(dt, 2.0 * distance / (approach - kick + impact)) : 0.0);
  if (!(impact > slow)) return {};
  for (int bounces = 0; pressing * timeLeft > 2.0 * speed; ++bounces) {
    if (restitution < 1.0 && (bounces == kMaxBounces || !(speed > slow))) return {};
    const double flightTime = 2.0 * speed / pressing;
    timeLeft -= restitution < 1.0 ? flightTime : flightTime * std::floor(timeLeft / flightTime);
    speed *= restitution;
  }
  const double mean = (speed * timeLeft - 0.5 * pressing * timeLeft * timeLeft - distance) / dt;
  const double after = speed - pressing * timeLeft;
  return {false, mean, after + kick - mean, std::max(restitution * impact, after)};
}

void addBounce(ContactTarget& target, const ContactBase& contact, double gap, double approach, double before,
               double dt) {
  if (!(gap < approach * dt)) return;
  const Bounce bounce = bounceOf(gap, approach, before, contact.restitution, contact.bounceThreshold, dt);
  if (bounce.rests) return;
  target = {gap < 0.0 ? std::max(bounce.mean, target.target) : bounce.mean, bounce.rebound, bounce.fastest,
            true};
}

void solvePositions(const ContactRows& rows, const PointView& points, double time, double dt) {
  forEachPoint(rows, [&](PlaneContact* first, std::size_t count) {
    if (!isSingleFixedPlane(first, count)) return solvePointPosition(first, count, points, time, dt);
    setTarget(*first, points, time, dt);
    applyRow(*first, points, first->target);
  });
  if (rows.begin.group == rows.end.group) return;
  kernel::stopBatchPoints(planeBody(*rows.packed, points), rows.begin.group, rows.end.group, time, dt);
}

void solveVelocities(const ContactRows& rows, const PointView& points) {
  forEachPoint(rows, [&](PlaneContact* first, std::size_t count) {
    if (!isSingleFixedPlane(first, count)) {
      solvePointVelocity(first, count, points);
    } else if (first->touching) {
      if (first->bounces)
        finishBounce(*first, points);
      else
        applyRow(*first, points, 0.0);
    }
    for (std::size_t i = 0; i < count; ++i)
      if (first[i].restitution > 0.0) first[i].lastVelocity = points.velocityOf(first->point);
  });
  if (rows.begin.group == rows.end.group) return;
  kernel::settleBatchPoints(planeBody(*rows.packed, points), rows.begin.group, rows.end.group);
}

// --- packed rows -------------------------------------------------------------------------------------------

namespace {

double* numbersOf(kernel::Plane<double>& plane) { return plane.normal; }
const double* numbersOf(const kernel::Capsule<double>& capsule) { return capsule.center; }

bool isSame(const kernel::Capsule<double>& a, const kernel::Capsule<double>& b) {
  return std::equal(numbersOf(a), numbersOf(a) + sizeof(a) / sizeof(double), numbersOf(b));
}

const HeldPiece* capsuleAt(const PlaneContact& row) {
  const HeldPiece* solid = row.around ? singleSolid(*row.around) : nullptr;
  return solid && solid->kind == HeldPiece::Kind::Capsule ? solid : nullptr;
}

bool canBePacked(const PlaneContact& row, double radius) {
  if (row.coupled || row.restitution > 0.0 || !row.surfaceAcceleration.isZero(0.0)) return false;
  if (!row.around) return true;
  return capsuleAt(row) && row.around->radius == radius && row.facing.isZero(0.0);
}

/// Returns the number of the capsule that the row follows. Most rows have that of the row before.
unsigned numberCapsule(PackedPlanes& p, const PlaneContact& row) {
  if (!row.around) return kernel::PlaneBody::kFixed;
  const kernel::Capsule<double> capsule = capsuleOf(*capsuleAt(row));
  const auto isIt = [&](const kernel::Capsule<double>& other) { return isSame(capsule, other); };
  const auto found = std::find_if(p.capsules.rbegin(), p.capsules.rend(), isIt);
  if (found != p.capsules.rend()) return static_cast<unsigned>(p.capsules.rend() - found - 1);
  p.capsules.push_back(capsule);
  return static_cast<unsigned>(p.capsules.size() - 1);
}

double* groupNumbers(PackedPlanes& p, std::size_t group) {
  return numbers(p.planes) + 4 * kPlaneNumbers * group;
}

/// Adds a group all of whose lanes are filled up with the point.
std::size_t addGroup(PackedPlanes& p, unsigned capsule, std::uint32_t point) {
  const std::size_t group = p.capsuleOf.size();
  p.capsuleOf.push_back(capsule);
  p.points.insert(p.points.end(), 4, point);
  p.rows.insert(p.rows.end(), 4, PackedPlanes::kNoRow);
  reserveNumbers(p.planes, 4 * kPlaneNumbers * (group + 1));
  std::fill_n(groupNumbers(p, group), 4 * kPlaneNumbers, 0.0);
  return group;
}

/// Returns the lane, counted over all groups, for a row of the present block.
std::size_t laneFor(PackedPlanes& p, unsigned capsule, std::uint32_t point) {
  for (std::size_t group = p.capsuleOf.size(); group-- > p.blocks.back().group;) {
    if (p.capsuleOf[group] != capsule) continue;
    for (std::size_t lane = 4 * group; lane < 4 * group + 4; ++lane)
      if (p.rows[lane] == PackedPlanes::kNoRow) return lane;
    break;
  }
  return 4 * addGroup(p, capsule, point);
}

void packRow(PackedPlanes& p, const std::vector<PlaneContact>& rows, std::uint32_t index) {
  const std::uint32_t point = rows[index].point;
  const std::size_t lane = laneFor(p, numberCapsule(p, rows[index]), point);
  p.points[lane] = point;
  p.rows[lane] = index;
  toLane(rows[index], groupNumbers(p, lane / 4) + lane % 4, 4);
}

void startBlock(PackedPlanes& p) {
  p.blocks.push_back(
      {static_cast<std::uint32_t>(p.capsuleOf.size()), static_cast<std::uint32_t>(p.loose.size())});
}

}  // namespace

void packPlanes(const std::vector<PlaneContact>& rows, std::uint32_t points, PackedPlanes& p) {
  p.points.clear(), p.capsuleOf.clear(), p.rows.clear();
  p.capsules.clear(), p.loose.clear(), p.blocks.clear();
  const auto followed = std::find_if(rows.begin(), rows.end(), capsuleAt);
  p.radius = followed != rows.end() ? followed->around->radius : 0.0;
  const auto count = static_cast<std::uint32_t>(rows.size());
  std::uint32_t next = 0;
  for (std::uint32_t block = 0; block < points; block += kContactPoints) {
    startBlock(p);
    for (std::uint32_t row = next; row < count && rows[row].point < block + kContactPoints; row = next) {
      do ++next;
      while (next < count && rows[next].point == rows[row].point);
      if (next == row + 1 && canBePacked(rows[row], p.radius))
        packRow(p, rows, row);
      else
        p.loose.push_back({row, next});
    }
  }
  startBlock(p);
}

void unpackPlanes(PackedPlanes& p, std::vector<PlaneContact>& rows) {
  for (std::size_t lane = 0; lane < p.rows.size(); ++lane)
    if (p.rows[lane] != PackedPlanes::kNoRow)
      fromLane(groupNumbers(p, lane / 4) + lane % 4, 4, rows[p.rows[lane]]);
}

void toLane(const PlaneContact& row, double* numbers, std::size_t lanes) {
  kernel::Plane<double> plane{};
  for (Eigen::Index c = 0; c < 3; ++c) {
    plane.normal[c] = row.normal[c];
    plane.touch[c] = row.touch[c];
    plane.surfaceVelocity[c] = row.surfaceVelocity[c];
    plane.impulse[c] = row.impulse.sum[c];
    plane.pressing[c] = row.impulse.pressing[c];
  }
  plane.along = row.impulse.along;
  plane.friction = row.friction, plane.recoverySpeed = row.recoverySpeed;
  plane.mass = row.away ? kernel::kAway : row.mass;
  plane.least = row.touching ? 0.0 : kernel::kNoLeast;
  for (std::size_t i = 0; i < kPlaneNumbers; ++i) numbers[i * lanes] = numbersOf(plane)[i];
}

void fromLane(const double* numbers, std::size_t lanes, PlaneContact& row) {
  kernel::Plane<double> plane{};
  for (std::size_t i = 0; i < kPlaneNumbers; ++i) numbersOf(plane)[i] = numbers[i * lanes];
  row.normal = Eigen::Vector3d::Map(plane.normal);
  row.touch = Eigen::Vector3d::Map(plane.touch);
  row.surfaceVelocity = Eigen::Vector3d::Map(plane.surfaceVelocity);
  row.away = plane.mass == kernel::kAway;
  row.mass = row.away ? 0.0 : plane.mass;
  row.impulse.sum = Eigen::Vector3d::Map(plane.impulse);
  row.impulse.pressing = Eigen::Vector3d::Map(plane.pressing);
  row.impulse.along = plane.along;
  row.touching = plane.least == 0.0;
}

}  // namespace limber

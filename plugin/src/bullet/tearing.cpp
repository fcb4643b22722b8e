// SPDX-License-Identifier: Zlib

// This file decides where bodies tear and what a cut separates, and gives a living body the network into
// which its own has separated.

#include "bullet/body_in_world.h"
#include "solver/split.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

// --- the separated network ---------------------------------------------------------------------------------

using Origins = std::vector<std::uint32_t>;

/// Appends columns for new points: those of the points that they come from.
void extend(Points& array, const Origins& pointOf) {
  const Eigen::Index before = array.cols(), count = static_cast<Eigen::Index>(pointOf.size());
  if (before == 0 || before == count) return;
  array.conservativeResize(3, count);
  for (Eigen::Index i = before; i < count; ++i)
    array.col(i) = array.col(pointOf[static_cast<std::size_t>(i)]).eval();
}

/// Returns the model of the new network. Gas escapes from a surface that is no longer closed.
Result<std::shared_ptr<const BodyModel>> modelOf(SoftBodyData& body, const SharedNetwork& network,
                                                 SoftBodySettings& settings) {
  auto model = body.models->of(network, settings);
  if (model) return model;
  settings.pressure = settings.ambientPressure = 0.0;
  settings.volumeModulus.reset();
  return body.models->of(network, settings);
}

/// Takes over yielded lengths and broken springs.
void carrySprings(const SoftBodyData& body, const BodyModel& before, const Origins& springOf,
                  SpringArrays& springs) {
  const std::vector<std::uint32_t>& oldOrder = before.springs.original->division.order;
  std::vector<std::size_t> indexOf(oldOrder.size());
  for (std::size_t i = 0; i < oldOrder.size(); ++i) indexOf[oldOrder[i]] = i;
  const std::vector<std::uint32_t>& order = springs.original->division.order;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t from = indexOf[springOf[order[i]]];
    springs.yielded->restLength[i] = body.springs->restLength[from];
    if (isBroken(body.springs, from)) breakSpring(springs, i);
  }
}

/// Shares what points have in proportion to their mass.
void sharePoints(SoftBodyData& body, const BodyModel& before, const Origins& pointOf) {
  PointState& state = body.state;
  for (Points* array :
       {&state.position, &state.velocity, &state.acceleration, &state.inverseMass, &body.masses.startPosition,
        &body.startVelocity, &body.surface.force, &body.surface.newForce})
    extend(*array, pointOf);
  for (std::size_t i = 0; i < pointOf.size(); ++i) {
    const double now = body.model->masses[i], was = before.masses[pointOf[i]];
    if (now == was) continue;
    const auto column = static_cast<Eigen::Index>(i);
    for (double& w : state.inverseMass.col(column)) w = w == inverseOf(was) ? inverseOf(now) : w * was / now;
    for (Points* force : {&body.surface.force, &body.surface.newForce})
      if (force->cols() > 0) force->col(column) *= now / was;
  }
  for (Points* array : {&state.force, &state.earlierForce}) array->resize(3, 0);
}

/// Discards what refers to the points and triangles of before.
void forgetShape(SoftBodyData& body) {
  forgetMotion(body);
  forgetSearches(body);
  SurfaceData& s = body.surface;
  s.contacts.clear();
  s.searches.clear();
  s.sweptBounds.tick = 0.0;
  if (s.shape) s.shape->setNetwork(*body.model->network);
  body.contacts.clear();
  body.heldPartners.clear();
  body.lastHeldPartners.clear();
  body.report = ContactReport();
  body.energyLimit = EnergyLimit();
  body.rateHistory = RateHistory();
  body.sumsValid = false;
  if (!body.medium) return;
  const Eigen::Vector3d wind = body.medium->lastWind;
  body.medium.reset();
  mediumOf(body).lastWind = wind;
}

/// Gives a living body the network that its own separates into. Positions, velocities and masses stay; so
/// does the energy, except that of springs that are left out. Errors, with nothing changed: a point that
/// would get too small a mass.
Result<void> takeSplit(SoftBodyData& body, const SplitNetwork& split) {
  SoftBodySettings settings = body.settings;
  auto model = modelOf(body, split.network, settings);
  if (!model) return Error{model.error()};
  readFromBullet(body);
  const std::shared_ptr<const BodyModel> before = std::exchange(body.model, *model);
  body.settings = settings;
  takeConstants(body, [&](SpringArrays& springs) { carrySprings(body, *before, split.springOf, springs); });
  body.surface.freed = true;
  sharePoints(body, *before, split.pointOf);
  dividePointMasses(body, split.pointOf, before->masses);
  forgetShape(body);
  writeToBullet(body);
  wakeBody(body, false);
  return {};
}

Vector3d placeOf(const SoftBodyData& body, std::uint32_t point) { return body.state.position.col(point); }

/// Separates the body and adds the places to its list. `energy` (J) is that of the springs at divided points.
Result<std::uint32_t> separate(SoftBodyData& body, const Elements& elements, const SplitRequest& request,
                               const std::vector<std::pair<std::uint32_t, double>>& energies = {}) {
  const SplitNetwork split = splitNetwork(*body.model->network, elements, request);
  if (!split.network) return std::uint32_t{0};
  const std::uint32_t before = pointCount(body);
  if (Result<void> taken = takeSplit(body, split); !taken) return Error{taken.error()};
  for (std::uint32_t i = before; i < pointCount(body); ++i) {
    Tear tear{placeOf(body, i), split.pointOf[i], i, 0.0};
    for (const auto& [point, energy] : energies)
      if (point == tear.point) tear.energy = energy;
    body.tears.push_back(tear);
  }
  return pointCount(body) - before;
}

// --- tears -------------------------------------------------------------------------------------------------

/// A spring that is longer than it may be.
struct Overload {
  std::size_t spring;
  double ratio;  ///< of its strain to the largest one
};

/// Maximum number of tears in a tick. The load must find its new way before more points part.
constexpr std::size_t kMaxTears = 8;

/// Springs with nearly the largest overload tear in the same tick.
constexpr double kNearlyMost = 0.9;

/// A spring tears the body only if both ends pull it: others pull by this share of its tension in the
/// opposite direction. Otherwise the load has gone already, and a tear would go on without it.
constexpr double kOpposed = 0.5;

/// Springs with a larger overload tear without these conditions. In a fast hit only the mass of the point at
/// its far end holds a spring: the springs behind it are not stretched yet. Many springs are then too long at
/// the same time.
constexpr double kSurely = 2.0;
constexpr std::size_t kMaxSureTears = 64;

/// Removes a spring that no element has.
void removeSpring(SoftBodyData& body, std::size_t spring) {
  if (!body.springs.yielded) body.springs.yielded = std::make_shared<SpringConstants>(*body.springs.original);
  breakSpring(body.springs, spring);
  ++body.springs.revision;
  body.surface.freed = true;
  *body.groupsStale = true;
}

class Tearing {
 public:
  explicit Tearing(SoftBodyData& body)
      : body_(body), elements_(elementsOf(*body.model->network)), springsOf_(pointCount(body)) {
    for (std::uint32_t i = 0; i < body.springs.size(); ++i) {
      springsOf_[body.springs->a[i]].push_back(i);
      springsOf_[body.springs->b[i]].push_back(i);
    }
    request_.side.assign(elements_.all.size(), 0);
    request_.place = [&body](std::uint32_t point) { return placeOf(body, point); };
  }

  void tear(const std::vector<Overload>& overloads) {
    for (const Overload& o : overloads) {
      const bool surely = o.ratio > kSurely;
      if (energies_.size() >= (surely ? kMaxSureTears : kMaxTears)) break;
      if (!surely && o.ratio < kNearlyMost * overloads.front().ratio) break;
      tearAt(o.spring, surely);
    }
    // a point of too small a mass is not divided
    if (!energies_.empty()) separate(body_, elements_, request_, energies_);
  }

  /// Returns whether an element has both ends of a spring.
  bool isEdge(std::size_t spring) const {
    const std::uint32_t a = body_.springs->a[spring], b = body_.springs->b[spring];
    const std::vector<std::uint32_t>& around = elements_.around[a];
    return std::any_of(around.begin(), around.end(),
                       [&](std::uint32_t element) { return hasCorner(elements_.all[element], b); });
  }

 private:
  static bool hasCorner(const std::array<std::uint32_t, 4>& element, std::uint32_t point) {
    return std::find(element.begin(), element.end(), point) != element.end();
  }

  Vector3d offset(std::uint32_t from, std::uint32_t to) const {
    return body_.state.position.col(to) - body_.state.position.col(from);
  }

  double stretch(std::size_t i) const {
    return offset(body_.springs->a[i], body_.springs->b[i]).norm() - body_.springs->restLength[i];
  }

  double tension(std::size_t i) const {
    return body_.springs->extensionStiffness[i] * std::max(0.0, stretch(i));
  }

  bool isFixed(std::uint32_t point) const {
    return limber::isHeld(body_.state.inverseMass, static_cast<Eigen::Index>(point)) ||
           isAttached(body_, point);
  }

  /// Returns the force (N) with which the other springs at a point pull against `towards` (unit).
  double opposing(std::uint32_t point, std::size_t spring, const Vector3d& towards) const {
    double sum = 0.0;
    for (const std::uint32_t i : springsOf_[point]) {
      if (i == spring) continue;
      const std::uint32_t other = body_.springs->a[i] == point ? body_.springs->b[i] : body_.springs->a[i];
      sum += tension(i) * std::max(0.0, -towards.dot(offset(point, other).stableNormalized()));
    }
    return sum;
  }

  void tearAt(std::size_t spring, bool surely) {
    std::uint32_t a = body_.springs->a[spring], b = body_.springs->b[spring];
    Vector3d along = offset(a, b).stableNormalized();
    const double least = kOpposed * tension(spring);
    double atA = opposing(a, spring, along), atB = opposing(b, spring, -along);
    if (!surely && ((atA < least && !isFixed(a)) || (atB < least && !isFixed(b)))) return;
    if (atB > atA) std::swap(a, b), along = -along;
    if (!part(a, along) && part(b, -along)) std::swap(a, b);
    if (!parted_) return breakBrace(spring, a, b);
    const double e = stretch(spring);
    energies_.emplace_back(a, 0.5 * body_.springs->extensionStiffness[spring] * e * e);
  }

  /// Braces may pull at both ends of a spring of a hollow body whose triangles cannot part.
  void breakBrace(std::size_t spring, std::uint32_t a, std::uint32_t b) {
    const SpringNetwork& network = *body_.model->network;
    if (network.kind != NetworkKind::Solid || elements_.corners == 4 || hasParted(a) || hasParted(b)) return;
    removeSpring(body_, spring);
  }

  bool hasParted(std::uint32_t point) const {
    const std::vector<std::uint32_t>& around = elements_.around[point];
    return std::any_of(around.begin(), around.end(),
                       [&](std::uint32_t element) { return request_.side[element] != 0; });
  }

  /// Parts the elements around a point by the plane through it. Returns false if all are on one side, or some
  /// have parted in this tick.
  bool part(std::uint32_t point, const Vector3d& normal) {
    parted_ = false;
    if (isFixed(point) || hasParted(point)) return false;
    std::vector<int> sides;
    int sum = 0;
    for (const std::uint32_t element : elements_.around[point]) {
      Vector3d middle = Vector3d::Zero();
      for (std::size_t c = 0; c < elements_.corners; ++c) middle += offset(point, elements_.all[element][c]);
      sides.push_back(middle.dot(normal) > 0.0 ? 1 : -1);
      sum += sides.back();
    }
    if (std::abs(sum) == static_cast<int>(sides.size())) return false;
    for (std::size_t i = 0; i < sides.size(); ++i) request_.side[elements_.around[point][i]] = sides[i];
    return parted_ = true;
  }

  SoftBodyData& body_;
  Elements elements_;
  std::vector<std::vector<std::uint32_t>> springsOf_;  // #points
  SplitRequest request_;
  std::vector<std::pair<std::uint32_t, double>> energies_;  // J, at the points that part
  bool parted_ = false;                                     // the last part() has parted elements
};

/// Returns the springs that are too long, the most overloaded first.
std::vector<Overload> overloadsOf(const SoftBodyData& body) {
  std::vector<Overload> overloads;
  const double strain = body.settings.elasticLimit.breakStrain;
  const SpringArrays& springs = body.springs;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double rest = springs.original->restLength[i], largest = strain * limitLength(springs, i);
    if (!(largest > 0.0) || isBroken(springs, i)) continue;
    const double length = (placeOf(body, springs->b[i]) - placeOf(body, springs->a[i])).norm();
    if (length - rest > largest) overloads.push_back({i, (length - rest) / largest});
  }
  std::stable_sort(overloads.begin(), overloads.end(),
                   [](const Overload& a, const Overload& b) { return a.ratio > b.ratio; });
  return overloads;
}

}  // namespace

bool mayTear(const SoftBodyData& body) {
  return body.settings.elasticLimit.tear && body.settings.elasticLimit.breakStrain > 0.0;
}

void tearBody(SoftBodyData& body) {
  if (body.asleep || !mayTear(body)) return;
  std::vector<Overload> overloads = overloadsOf(body);
  if (overloads.empty()) return;
  Tearing tearing(body);
  const auto inside = std::stable_partition(overloads.begin(), overloads.end(),
                                            [&](const Overload& o) { return tearing.isEdge(o.spring); });
  for (auto o = inside; o != overloads.end(); ++o) removeSpring(body, o->spring);
  overloads.erase(inside, overloads.end());
  tearing.tear(overloads);
}

// --- cuts --------------------------------------------------------------------------------------------------

namespace {

/// Returns whether the projection of a place onto the plane of a triangle is within it.
bool isOver(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& place) {
  const Vector3d normal = (b - a).cross(c - a);
  const double scale = -1e-9 * normal.squaredNorm();
  return normal.dot((b - a).cross(place - a)) >= scale && normal.dot((c - b).cross(place - b)) >= scale &&
         normal.dot((a - c).cross(place - c)) >= scale;
}

Result<std::uint32_t> makeCut(SoftBodyData& body, const Cut& cut) {
  if (!isAlive(body)) return notAlive();
  readFromBullet(body);
  const Elements elements = elementsOf(*body.model->network);
  SplitRequest request;
  request.place = [&body](std::uint32_t point) { return placeOf(body, point); };
  for (const auto& element : elements.all) {
    double height = 0.0;
    for (std::size_t c = 0; c < elements.corners; ++c)
      height += cut.normal.dot(placeOf(body, element[c]) - cut.point);
    request.side.push_back(height > 0.0 ? 1 : -1);
  }
  if (const std::vector<Vector3d>& x = cut.corners; !x.empty())
    request.within = [x](const Vector3d& middle) {
      return isOver(x[0], x[1], x[2], middle) || isOver(x[0], x[2], x[3], middle);
    };
  return separate(body, elements, request);
}

/// Makes a cut, now or, within a tick, at the start of the next one.
Result<std::uint32_t> cutBody(SoftBodyData& body, const Cut& cut) {
  if (!isAlive(body)) return notAlive();
  if (!body.inTick || !*body.inTick) return makeCut(body, cut);
  body.cuts.push_back(cut);
  *body.groupsStale = true;  // the next tick divides bodies
  return std::uint32_t{0};
}

}  // namespace

void makePendingCuts(SoftBodyData& body) {
  for (const Cut& cut : std::exchange(body.cuts, {})) makeCut(body, cut);
}

Result<std::uint32_t> SoftBody::cut(const btVector3& point, const btVector3& normal) {
  const Vector3d n = toEigen(normal);
  if (!toEigen(point).allFinite() || !n.allFinite()) return Error{"the plane of the cut is not finite"};
  if (n.isZero(0.0)) return Error{"the normal of the cut is 0"};
  return cutBody(*data_, {toEigen(point), n.stableNormalized(), {}});
}

Result<std::uint32_t> SoftBody::cut(const std::array<btVector3, 4>& edge) {
  Cut cut{Vector3d::Zero(), Vector3d::Zero(), {}};
  for (const btVector3& corner : edge) {
    cut.corners.push_back(toEigen(corner));
    cut.point += 0.25 * toEigen(corner);
  }
  if (!cut.point.allFinite()) return Error{"the region of the cut is not finite"};
  cut.normal = (cut.corners[2] - cut.corners[0]).cross(cut.corners[3] - cut.corners[1]).stableNormalized();
  if (!(cut.normal.norm() > 0.5)) return Error{"the region of the cut has no area"};
  return cutBody(*data_, cut);
}

const std::vector<Tear>& SoftBody::tears() const { return data_->tears; }

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This file computes what air, water and fields do to a body in a tick.

#include "bullet/body_medium.h"

#include "bullet/soft_body_data.h"

#include <Eigen/Cholesky>

#include <limits>
#include <numeric>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Of a plate broadside to the flow, and of a cylinder across it (Hoerner 1965).
constexpr double kSheetDrag = 1.2;

/// 1/s. Air alone does not bring heavy cloths to rest, as it hardly acts on slow motions and not along the
/// cloth.
constexpr double kSheetLinearDrag = 0.3;

/// 1/s, of solids in water.
constexpr double kWaveDrag = 0.5;

/// Of a bluff solid in water.
constexpr double kSolidDragInWater = 1.0;

/// Square of the phase in a tick with which a part of a body may bob by itself.
constexpr double kMaxLocalPhase = 0.5;

/// m/s, the largest wind that is taken from the user's function.
constexpr double kMaxWind = 1e6;

/// m/s, change of the wind that wakes a body.
constexpr double kWakingWind = 0.5;

/// A solid whose surface is open, as by a cut, is a sheet.
bool isSolid(const SoftBodyData& body) {
  return body.model->network->kind == NetworkKind::Solid && body.model->parts.sheets.empty();
}

/// Returns the flow of a medium past the body, whose default drag in it is `usual`.
Flow flowOf(const SoftBodyData& body, double density, const Vector3d& velocity, double usual) {
  const FlowCoefficients& c = body.settings.flow;
  Flow flow;
  flow.density = density;
  flow.drag = c.drag.value_or(usual);
  const bool isSheet = !body.model->parts.sheets.empty();
  flow.lift = std::min(c.lift.value_or(isSheet ? flow.drag : 0.0), flow.drag);
  flow.friction = flow.drag > 0.0 ? c.friction : 0.0;
  flow.velocity = velocity;
  return flow;
}

Flow airOf(const SoftBodyData& body) {
  const Air& air = body.surroundings->air;
  return flowOf(body, air.density, air.wind, isSolid(body) ? 0.0 : kSheetDrag);
}

Flow waterOf(const SoftBodyData& body) {
  const Water& water = *body.surroundings->water;
  return flowOf(body, water.density, water.flow, isSolid(body) ? kSolidDragInWater : kSheetDrag);
}

Vector3d windAt(const Surroundings& around, const Vector3d& place, double time) {
  Vector3d wind = around.air.windAt(place, time);
  for (int axis = 0; axis < 3; ++axis)
    wind[axis] = std::isfinite(wind[axis]) ? std::clamp(wind[axis], -kMaxWind, kMaxWind) : 0.0;
  return around.air.wind + wind;
}

/// Of the middle of the tick.
void setWindOfPoints(const SoftBodyData& body, BodyMedium& medium, double tick, Flow& air) {
  if (!body.surroundings->air.windAt) return;
  medium.wind.resize(3, body.state.position.cols());
  for (Eigen::Index i = 0; i < medium.wind.cols(); ++i)
    medium.wind.col(i) =
        windAt(*body.surroundings, medium.predicted.col(i), body.surroundings->time + 0.5 * tick);
  air.velocityAt = &medium.wind;
  medium.lastWind = medium.wind.col(0);
}

/// Returns the plane of the water; none if there is no gravity, or if the body is above it.
WaterPlane waterPlaneNear(SoftBodyData& body, double tick) {
  WaterPlane plane;
  if (!body.surroundings->water) return plane;
  const Vector3d gravity = toEigen(body.world->getGravity());
  const double strength = gravity.norm();
  if (!(strength > 0.0) || !std::isfinite(strength)) return plane;
  plane.up = -gravity / strength;
  plane.level = body.surroundings->water->level;
  const MotionSums& s = sumsOf(body);
  double lowest = 0.0, fastest = std::sqrt(s.fastest);
  for (int axis = 0; axis < 3; ++axis) {
    lowest += plane.up[axis] * (plane.up[axis] > 0.0 ? s.low[axis] : s.high[axis]);
    fastest += std::abs(s.meanVelocity[axis]);
  }
  const double reach = radiusOf(body) + tick * fastest;
  if (lowest - reach < plane.level) plane.weight = body.surroundings->water->density * strength;
  return plane;
}

/// Adds the buoyancy of a body that encloses no volume. Each point has its share of the displaced volume, and
/// is under water more and more from a radius above the plane to a radius below it. Returns what that is as
/// an area of the plane (m^2).
double addDisplacement(const SoftBodyData& body, BodyMedium& medium, const WaterPlane& plane) {
  const double volume = body.settings.flow.displacedVolume, diameter = 2.0 * radiusOf(body);
  double planeArea = 0.0;
  for (Eigen::Index i = 0; i < medium.predicted.cols(); ++i) {
    const double own = volume * body.model->network->massFractions[static_cast<std::size_t>(i)];
    const double share = plane.depthOf(medium.predicted.col(i)) / diameter + 0.5;
    if (share > 0.0) medium.force.col(i) += plane.weight * own * std::min(share, 1.0) * plane.up;
    if (share > 0.0 && share < 1.0) planeArea += own / diameter;
  }
  return planeArea;
}

/// Returns the square of the phase in a tick with which a mass (kg) bobs that has this area (m^2) of the
/// plane.
double bobbingPhase(const WaterPlane& plane, double area, double mass, double tick) {
  return plane.weight * std::max(area, 0.0) * tick * tick / mass;
}

/// The forces of the water on a body as a whole.
struct Lift {
  double area = 0.0;                     ///< m^2, of the plane inside the body
  double mass = 0.0;                     ///< kg, of the points that are not held
  Vector3d center = Vector3d::Zero();    ///< m, of that mass
  double wetMass = 0.0;                  ///< kg, of the points that the water acts on
  Vector3d sum = Vector3d::Zero();       ///< N
  Vector3d rotation = Vector3d::Zero();  ///< rad/s^2, by the torque
};

/// `places` (3 x #points, m): where the forces act.
Lift liftOf(const PointState& s, const Points& places, const Points& force) {
  Lift lift;
  Vector3d middle = Vector3d::Zero();
  for (Eigen::Index i = 0; i < force.cols(); ++i) {
    const double own = massOf(s.inverseMass, i);
    lift.mass += own, lift.center += own * s.position.col(i), lift.sum += force.col(i);
    middle += own * places.col(i);
    if (!force.col(i).isZero(0.0)) lift.wetMass += own;
  }
  if (!(lift.mass > 0.0)) return lift;
  lift.center /= lift.mass, middle /= lift.mass;
  Vector3d torque = Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < force.cols(); ++i) {
    const Vector3d r = s.position.col(i) - lift.center;
    torque += Vector3d(places.col(i) - middle).cross(Vector3d(force.col(i)));
    inertia += massOf(s.inverseMass, i) *
               (r.squaredNorm() * Eigen::Matrix3d::Identity() - Eigen::Matrix3d(r * r.transpose()));
  }
  inertia += 1e-9 * inertia.trace() * Eigen::Matrix3d::Identity();
  lift.rotation = inertia.ldlt().solve(torque);
  return lift;
}

/// Returns the share of the water's forces that act where the pressure is. Forces that may move the wet part
/// of a light body by much of its size within a tick change faster than once a tick: they crush the body, or
/// shake it for ever.
double localShare(const Lift& lift, const WaterPlane& plane, double tick) {
  const double across = std::pow(lift.sum.norm() / plane.weight, 2.0 / 3.0);
  const double phase = bobbingPhase(plane, std::max(lift.area, across), lift.wetMass, tick);
  return std::clamp((kMaxLocalPhase - phase) / (0.5 * kMaxLocalPhase), 0.0, 1.0);
}

/// Strain of a submerged body by the water's pressure: up to the first the pressure acts on each triangle,
/// from the second on on the body as a whole.
constexpr double kHeldStrain = 0.15, kCrushingStrain = 0.4;

/// Returns the share of the water's forces that act where the pressure is on a body whose springs must hold
/// the difference of the pressure between its top and its bottom. A softer one would be turned inside out:
/// what is real and as soft is filled with something that hardly changes its volume. The share depends on
/// nothing that moves, so that the forces keep a potential.
double heldShare(const WettedParts& parts, const WaterPlane& plane) {
  const double strain = plane.weight * std::cbrt(parts.volume) / parts.modulus;
  return std::clamp((kCrushingStrain - strain) / (kCrushingStrain - kHeldStrain), 0.0, 1.0);
}

/// Density relative to the water's: up to the first a body has the whole inertia of the water that it pushes
/// aside, at any tick, from the second on none at ticks that are short enough. It matters where it is several
/// times the body's own.
constexpr double kLightDensity = 0.1, kHeavyDensity = 0.2;

double lightnessOf(const Lift& lift, const WettedParts& parts, const WaterPlane& plane, double gravity) {
  const double density = lift.mass * gravity / (plane.weight * parts.volume);
  return std::clamp((kHeavyDensity - density) / (kHeavyDensity - kLightDensity), 0.0, 1.0);
}

/// Sets `places` to the rest shape as it moves with the body, in the middle of the tick.
void placeRestShape(SoftBodyData& body, const Points& predicted, double tick, Points& places) {
  const RestShape& rest = body.model->rest;
  const Vector3d spin = 0.5 * tick * fitRigid(body).spin;
  const double angle = spin.norm();
  Eigen::Matrix3d turn = followRotation(body).toRotationMatrix();
  if (angle > 0.0) turn = Eigen::AngleAxisd(angle, spin / angle) * turn;
  places.resize(3, predicted.cols());
  Vector3d center = Vector3d::Zero(), restCenter = Vector3d::Zero();
  for (Eigen::Index i = 0; i < places.cols(); ++i) {
    const double fraction = rest.fractions[static_cast<std::size_t>(i)];
    center += fraction * predicted.col(i);
    restCenter += rest.weighted.col(i);
    places.col(i) = rest.weighted.col(i) / fraction;
  }
  for (Eigen::Index i = 0; i < places.cols(); ++i)
    places.col(i) = center + turn * (places.col(i) - restCenter);
}

/// How a body bobs in a tick.
struct Bobbing {
  double area = 0.0;      ///< m^2, of the plane inside the body
  double phase = 0.0;     ///< its square, with the inertia below
  double local = 1.0;     ///< see localShare()
  double held = 1.0;      ///< see heldShare()
  double own = 1.0;       ///< the share of the body's mass in the inertia of both
  double implicit = 1.0;  ///< the share of the forces by the implicit rule, see steadyForces()
};

/// Makes the forces on a light or very soft body act as a whole, with the same sum and torque, as far as they
/// must not act locally. With the phase p of bobbing and the places that buoy() moves,
///   (1 + p^2 / 4) F = F(x + v tick / 2 + a tick^2 / 4)
/// for light ones, with the acceleration a by all other forces. This is the implicit midpoint rule, stable
/// for any mass, and at rest F is the buoyancy there.
void steadyForces(const SoftBodyData& body, const Lift& lift, const WaterPlane& plane, double tick,
                  Points& force, Bobbing& bobbing) {
  const PointState& s = body.state;
  const double steady = 1.0 - bobbing.local;
  const double phase = bobbing.own * bobbingPhase(plane, bobbing.area, lift.mass, tick);
  const double implicit = 1.0 / (1.0 + 0.25 * steady * phase);
  const double local = std::min(bobbing.local, bobbing.held);
  for (Eigen::Index i = 0; i < force.cols(); ++i) {
    const double mass = massOf(s.inverseMass, i);
    const Vector3d rigid =
        lift.sum / lift.mass + lift.rotation.cross(Vector3d(s.position.col(i) - lift.center));
    force.col(i) = implicit * (local * force.col(i) + (1.0 - local) * mass * rigid);
  }
  bobbing.implicit = implicit;
}

void massesHaveChanged(SoftBodyData& body) {
  body.springs.preparedFor = 0.0;
  ++body.springs.revision;
  body.frequencyStale = true;
}

/// Adds the mass of the water that moves with the body to its points in this tick, so that contacts, anchors
/// and springs act against both.
void addWaterMass(SoftBodyData& body, BodyMedium& medium, double own) {
  medium.others.reset();
  if (own == 1.0) return;
  PointState& s = body.state;
  medium.inverseMass = s.inverseMass;
  medium.velocity = s.velocity;
  medium.hasWaterMass = true;
  s.inverseMass *= own;
  s.acceleration *= own;
  massesHaveChanged(body);
}

/// Returns the plane lowered to the top of a body that is under water. The pressure there acts on all sides
/// and moves nothing; without it bodies far below are not crushed.
WaterPlane planeAt(const Points& position, WaterPlane plane) {
  double top = -std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < position.cols(); ++i) top = std::max(top, plane.up.dot(position.col(i)));
  plane.level = std::min(plane.level, top);
  return plane;
}

/// Sets the forces of the water on a closed body at the predicted places.
Lift setBuoyancy(SoftBodyData& body, BodyMedium& medium, const WaterPlane& plane) {
  medium.force.setZero();
  const double area =
      addBuoyancy(body.model->parts.closed, medium.predicted, planeAt(medium.predicted, plane), medium.force);
  Lift lift = liftOf(body.state, medium.predicted, medium.force);
  lift.area = area;
  return lift;
}

/// Sets the forces of the water on a closed body. A very soft one is lifted as its rest shape, as the work of
/// forces on its deformations could not come from the water's level alone. A light body also has the inertia
/// of the water that it pushes aside, half the displaced mass, as for a sphere. It moves during the tick by
/// gravity or, from the second tick on, by what acted on it in the last one: loads and contacts, too.
Bobbing buoy(SoftBodyData& body, BodyMedium& medium, const WaterPlane& plane, double tick) {
  Bobbing bobbing;
  bobbing.held = heldShare(body.model->parts, plane);
  if (bobbing.held < 1.0) {
    placeRestShape(body, medium.predicted, tick, medium.velocity);
    medium.predicted += (1.0 - bobbing.held) * (medium.velocity - medium.predicted);
  }
  Lift lift = setBuoyancy(body, medium, plane);
  bobbing.area = lift.area;
  const bool above = !(lift.wetMass > 0.0);
  if (!above) bobbing.local = localShare(lift, plane, tick);
  const double steady = above ? 1.0 : 1.0 - bobbing.local;
  const Vector3d gravity = toEigen(body.world->getGravity());
  if (!above) {
    const double share = std::max(steady, lightnessOf(lift, body.model->parts, plane, gravity.norm()));
    bobbing.own = lift.mass / (lift.mass + share * 0.5 * lift.sum.norm() / gravity.norm());
  }
  if (steady == 0.0 && bobbing.held == 1.0) return bobbing;
  Vector3d others = bobbing.own * medium.others.value_or(gravity);
  // what balances buoyancy is below 2 g: the body has the mass of half of the water that lifts it
  if (const double most = 2.0 * gravity.norm(), size = others.norm(); size > most) others *= most / size;
  medium.predicted.colwise() += 0.25 * tick * tick * steady * others;
  lift = setBuoyancy(body, medium, plane);
  bobbing.area = lift.area;
  if (!(lift.wetMass > 0.0)) return bobbing;
  if (above) {
    bobbing.local = localShare(lift, plane, tick);
    medium.force.setZero();
  }
  steadyForces(body, lift, plane, tick, medium.force, bobbing);
  return bobbing;
}

/// Limits the force on a body that is so small that a tick may take it from one side of the water's plane to
/// the other: it would leap ever higher. The force then lifts its centre to the plane at most, where it comes
/// to rest unless its draught is larger.
void limitRise(const SoftBodyData& body, BodyMedium& medium, const WaterPlane& plane, double tick) {
  constexpr double kSmall = 1.6;  // falls from rest in a tick, per size
  const Vector3d gravity = toEigen(body.world->getGravity());
  if (!(gravity.norm() * tick * tick > kSmall * body.size)) return;
  const PointState& s = body.state;
  double momentum = 0.0, impulse = 0.0,
         wanted = 0.0;  // kg m/s, upward: without the force, by it, to the plane
  for (Eigen::Index i = 0; i < s.position.cols(); ++i) {
    const double m = massOf(s.inverseMass, i);
    momentum += m * plane.up.dot(s.velocity.col(i) + tick * s.acceleration.col(i));
    impulse += tick * plane.up.dot(medium.force.col(i));
    wanted += m * plane.depthOf(s.position.col(i)) / tick;
  }
  const double excess = momentum + impulse - wanted;
  if (impulse > 0.0 && excess > 0.0) medium.force *= std::max(0.0, 1.0 - excess / impulse);
}

/// Adds the buoyancy to the accelerations. It is that of the predicted positions: then a constant force over
/// the tick keeps the energy of bobbing bodies.
Bobbing addWaterForces(SoftBodyData& body, BodyMedium& medium, const WaterPlane& plane, double tick) {
  medium.force.setZero(3, medium.predicted.cols());
  Bobbing bobbing;
  const double mass = totalMass(body.state);  // without the water that it pushes aside
  if (!body.model->parts.closed.empty()) {
    bobbing = buoy(body, medium, plane, tick);
    medium.drag.terms *= bobbing.implicit;
    addWaterMass(body, medium, bobbing.own);
  } else if (body.settings.flow.displacedVolume > 0.0) {
    bobbing.area = addDisplacement(body, medium, plane);
  }
  limitRise(body, medium, plane, tick);
  body.state.acceleration += medium.force.cwiseProduct(body.state.inverseMass);
  body.surface.sweptBounds.tick = 0.0;
  bobbing.phase = bobbing.own * bobbing.implicit * bobbingPhase(plane, bobbing.area, mass, tick);
  return bobbing;
}

/// Returns the rate (1/s) at which bobbing is damped. A body that bobs too fast for a constant force over a
/// tick creeps to its draught. The waves of a solid that is far lighter than the water around it, or very
/// soft, take most of its energy within a period: it moves more water than itself.
double bobbingRate(const SoftBodyData& body, const Bobbing& bobbing, double tick) {
  if (bobbing.phase > 1.0) return bobbing.phase / tick;
  if (!isSolid(body) || body.settings.flow.linearDrag) return 0.0;
  return (1.0 - std::min(bobbing.local, bobbing.held)) * std::sqrt(bobbing.phase) / tick;
}

void dampBobbing(const SoftBodyData& body, BodyMedium& medium, const WaterPlane& plane, double rate) {
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    addDrag(medium.drag, i, rate * massOf(body.state.inverseMass, i), plane.up, 0.0, Vector3d::Zero());
}

/// Slows the points of a solid under water down: the waves that it makes carry its energy away.
void dampByWaves(const SoftBodyData& body, BodyMedium& medium, const WaterPlane& plane,
                 const Vector3d& flow) {
  if (!isSolid(body) || body.settings.flow.linearDrag) return;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    if (plane.depthOf(body.state.position.col(i)) > 0.0)
      addDrag(medium.drag, i, 0.0, plane.up, kWaveDrag * massOf(body.state.inverseMass, i), flow);
}

/// Rate of the drag times tick, up to which the speeds are those of the middle of the tick. Stronger drag in
/// air alone is computed several times within the tick; in water, from the second value on, by the speeds in
/// the middle of the last tick.
constexpr double kWeakDrag = 0.5, kStrongDrag = 1.0;

/// Returns the velocities so many ticks after the start of this one, if they change as in the last tick.
const Points& velocityAhead(const SoftBodyData& body, BodyMedium& medium, double ticks) {
  if (body.startVelocity.cols() != body.state.velocity.cols()) return body.state.velocity;
  medium.velocity = body.state.velocity + ticks * (body.state.velocity - body.startVelocity);
  return medium.velocity;
}

/// Has the drag in air computed again so often that it changes little in between. `time` (s): that in which
/// it changes the velocities.
void updateWithinTick(const SoftBodyData& body, BodyMedium& medium, const Flow& air, double time) {
  DragUpdates& u = medium.drag.updates;
  u.interval = kWeakDrag * time;
  u.parts = &body.model->parts;
  u.diameter = 2.0 * radiusOf(body);
  u.air = air;
  u.inverseMass = &body.state.inverseMass;
  u.position = &medium.predicted, u.velocity = &medium.velocity;
}

/// Adds the drag by the flow past the parts in the middle of the tick to a cleared one: its error falls with
/// the square of the tick. Where drag is strong enough to act fully within a tick, it would be too strong and
/// too weak by turns with the speeds of this tick.
void addFlowDrag(const SoftBodyData& body, BodyMedium& medium, const Flow& air, const Flow& water,
                 const WaterPlane& plane, double tick) {
  const auto addWith = [&](double ticksAhead) {
    addDragOfParts(body.model->parts, 2.0 * radiusOf(body),
                   {medium.predicted, velocityAhead(body, medium, ticksAhead)}, air, water, plane,
                   medium.drag);
  };
  addWith(0.5);
  const double strength = tick * limitDrag(medium.drag, body.state.inverseMass);
  if (strength > kWeakDrag && !plane.isThere()) return updateWithinTick(body, medium, air, tick / strength);
  const double back = std::clamp((strength - kWeakDrag) / (kStrongDrag - kWeakDrag), 0.0, 1.0);
  if (back == 0.0) return;
  clearDrag(medium.drag, body.state.position.cols());
  addWith(0.5 - back);
}

}  // namespace

BodyMedium& mediumOf(SoftBodyData& body) {
  if (!body.medium) body.medium = std::make_unique<BodyMedium>();
  return *body.medium;
}

WettedParts wettedParts(const SpringNetwork& network, const SoftBodySettings& settings,
                        const SpringConstants& springs) {
  WettedParts parts;
  const VolumeConstants closed = closedSurfaces(network, scaledRest(network, settings.scale));
  parts.closed = closed.triangles;
  if (!parts.closed.empty()) {
    parts.volume = std::accumulate(closed.restVolume.begin(), closed.restVolume.end(), 0.0);
    // of springs that fill it evenly: sum k L^2 / (6 V), see networkModulus(); gas stretches its skin
    for (std::size_t i = 0; i < springs.restLength.size(); ++i)
      parts.modulus += 0.5 * (springs.extensionStiffness[i] + springs.compressionStiffness[i]) *
                       springs.restLength[i] * springs.restLength[i] / (6.0 * parts.volume);
    parts.modulus += settings.pressure;
    return parts;
  }
  parts.sheets = network.surface;
  if (!parts.sheets.empty()) return parts;
  for (const NetworkSpring& spring : network.springs)
    if (spring.kind == SpringKind::Structural) parts.segments.push_back({spring.a, spring.b});
  return parts;
}

bool hasDragInAir(const SoftBodyData& body) { return airOf(body).acts() && !body.model->parts.empty(); }

bool isBlownAwake(const SoftBodyData& body) {
  if (!body.asleep || !body.surroundings->air.windAt || !hasDragInAir(body)) return false;
  const Vector3d last = body.medium ? body.medium->lastWind : Vector3d(Vector3d::Zero());
  const Vector3d now = windAt(*body.surroundings, body.state.position.col(0), body.surroundings->time);
  return (now - last).norm() > kWakingWind;
}

PointDrag* surroundBody(SoftBodyData& body, double tick) {
  const double rate = body.settings.flow.linearDrag.value_or(isSolid(body) ? 0.0 : kSheetLinearDrag);
  const bool inAir = hasDragInAir(body);
  const WaterPlane plane = waterPlaneNear(body, tick);
  if (body.medium && !plane.isThere()) body.medium->others.reset();
  if (!inAir && !plane.isThere() && rate == 0.0) return nullptr;
  BodyMedium& medium = mediumOf(body);
  medium.drag.rate = rate;
  medium.drag.updates.interval = 0.0;
  medium.predicted = body.state.position + 0.5 * tick * body.state.velocity;
  Flow air = airOf(body), water;
  if (inAir) setWindOfPoints(body, medium, tick, air);
  if (plane.isThere()) water = waterOf(body);
  // a body that goes in and out of the water keeps its memory
  clearDrag(medium.drag, inAir || body.surroundings->water ? body.state.position.cols() : 0);
  if (inAir || water.acts()) addFlowDrag(body, medium, air, water, plane, tick);
  if (plane.isThere()) dampByWaves(body, medium, plane, water.velocity);
  if (plane.isThere()) {
    const Bobbing bobbing = addWaterForces(body, medium, plane, tick);
    if (const double damping = bobbingRate(body, bobbing, tick); damping > 0.0)
      dampBobbing(body, medium, plane, damping);
  }
  limitDrag(medium.drag, body.state.inverseMass);
  return &medium.drag;
}

void removeWaterMass(SoftBodyData& body, double tick) {
  if (!body.medium || !body.medium->hasWaterMass) return;
  BodyMedium& medium = *body.medium;
  const PointState& s = body.state;
  Vector3d force = -medium.drag.impulse / tick;
  double mass = 0.0;
  for (Eigen::Index i = 0; i < medium.force.cols(); ++i) {
    force +=
        massOf(s.inverseMass, i) / tick * (s.velocity.col(i) - medium.velocity.col(i)) - medium.force.col(i);
    mass += massOf(medium.inverseMass, i);
  }
  medium.others = Vector3d(force / mass);
  body.state.inverseMass = medium.inverseMass;
  massesHaveChanged(body);
  medium.hasWaterMass = false;
}

void applyFields(SoftBodyData& body, double tick) {
  if (body.surroundings->fields.empty()) return;
  BodyMedium& medium = mediumOf(body);
  PointState& s = body.state;
  const Eigen::Index count = s.position.cols();
  medium.masses.resize(static_cast<std::size_t>(count));
  for (Eigen::Index i = 0; i < count; ++i)
    medium.masses[static_cast<std::size_t>(i)] = massOf(s.inverseMass, i);
  medium.force = s.acceleration;
  medium.predicted = s.position + 0.5 * tick * s.velocity;
  const FieldPoints points{
      static_cast<std::size_t>(count),      medium.predicted.data(), s.velocity.data(), medium.masses.data(),
      body.surroundings->time + 0.5 * tick, s.acceleration.data()};
  for (const ActingField& field : body.surroundings->fields)
    if (!field.body || field.body == &body) field.act(points);
  // along axes on which a point is held, it keeps its velocity
  s.acceleration = (s.inverseMass.array() > 0.0).select(s.acceleration, medium.force);
  body.surface.sweptBounds.tick = 0.0;
  if (s.acceleration.cwiseAbs().sum() < kMaxSound) return;
  s.acceleration = medium.force;
  body.restored = true;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

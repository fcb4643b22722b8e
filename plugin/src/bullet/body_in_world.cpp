// SPDX-License-Identifier: Zlib

// This file makes bodies and the surface topologies that equal bodies share. It also calls the functions for
// points or for surfaces at each stage of a body's life in the world.

#include "bullet/body_in_world.h"

#include "bullet/point_contacts.h"
#include "bullet/point_masses.h"
#include "bullet/surface_body.h"
#include "solver/midpoint_solver.h"
#include "solver/stepping_choice.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- a new body --------------------------------------------------------------------------------------------

namespace {

Eigen::Vector3d centerOfMass(const SpringNetwork& network, const Points& position) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < network.massFractions.size(); ++i)
    center += network.massFractions[i] * position.col(static_cast<Eigen::Index>(i));
  return center;
}

/// Maximum width of a narrow matrix band: the index distance of two points that a spring joins. A rope has 1,
/// a rope with bending springs 2.
constexpr std::size_t kNarrowBand = 3;

/// Maximum number of operations of a cheap banded factorisation, about 3 #points (3 width)^2. This takes some
/// 20 us. A cube takes 10 000 operations.
constexpr std::size_t kCheapOperations = 50000;

void initializePoints(SoftBodyData& body) {
  const SoftBodySettings& s = body.settings;
  PointState& state = body.state;
  state.resize(static_cast<Eigen::Index>(body.network->restPoints.size()));
  const Eigen::Matrix3d rotation = s.rotation.toRotationMatrix();
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    const Eigen::Vector3d rest = body.network->restPoints[static_cast<std::size_t>(i)];
    state.position.col(i) = s.position + rotation * rest.cwiseProduct(s.scale);
  }
  const Eigen::Vector3d center = centerOfMass(*body.network, state.position);
  for (Eigen::Index i = 0; i < state.position.cols(); ++i)
    state.velocity.col(i) = s.linearVelocity + s.angularVelocity.cross(state.position.col(i) - center);
}

/// m, m/s; the settings have the same limit. Its fourth power does not overflow Bullet's floats.
constexpr double kMaxCoordinate = 1e9;

std::string checkCoordinates(const PointState& state) {
  for (Eigen::Index i = 0; i < state.position.cols(); ++i)
    for (const Points* array : {&state.position, &state.velocity})
      if (!(array->col(i).cwiseAbs().maxCoeff() <= kMaxCoordinate))
        return "point " + std::to_string(i) + " would be, or move, beyond 1e9";
  return {};
}

/// Relative residual of the eigenvalue. The error of the resulting period is about 1e-3.
constexpr double kResidual = 0.03;

/// Returns the fastest oscillation with the masses of the settings and no held points. It uses the unrotated
/// rest shape at the origin: otherwise the remaining residual, and sometimes the number of substeps, would
/// depend on the body's initial pose.
double fastestAtRest(const SoftBodyData& body) {
  PointState rest = body.state;
  for (Eigen::Index i = 0; i < rest.position.cols(); ++i)
    rest.position.col(i) =
        body.network->restPoints[static_cast<std::size_t>(i)].cwiseProduct(body.settings.scale);
  for (Eigen::Index i = 0; i < rest.inverseMass.cols(); ++i)
    rest.inverseMass.col(i).setConstant(
        1.0 / (body.settings.totalMass * body.network->massFractions[static_cast<std::size_t>(i)]));
  return fastestOscillationSquared(body.springs, body.volumes, body.tetrahedra, rest, kResidual);
}

}  // namespace

Result<std::unique_ptr<SoftBodyData>> makeBodyData(SharedNetwork network, const SoftBodySettings& settings) {
  if (!network) return Error{"there is no network"};
  if (std::string reason = validate(*network); !reason.empty()) return Error{"network: " + reason};
  if (std::string reason = validate(settings); !reason.empty()) return Error{"settings: " + reason};
  if (std::string reason = checkVolume(*network, settings); !reason.empty()) return Error{reason};
  auto body = std::make_unique<SoftBodyData>();
  body->network = std::move(network);
  body->settings = settings;
  body->springs = makeSprings(*body->network, settings);
  body->volumes = makeVolumes(*body->network, settings);
  body->tetrahedra = makeTetrahedronVolumes(*body->network, settings);
  initializePoints(*body);
  if (std::string reason = checkCoordinates(body->state); !reason.empty()) return Error{reason};
  body->fastestAtRest = fastestAtRest(*body);
  const Points& x = body->state.position;
  body->size = (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).norm();
  const auto order = bandOrder(body->springs, body->network->restPoints.size());
  const std::size_t width = bandWidth(body->springs, order), points = body->network->restPoints.size();
  body->narrow = width <= kNarrowBand;
  body->cheapNewton = 27 * points * width * width <= kCheapOperations;
  return body;
}

// --- surfaces that equal bodies share ----------------------------------------------------------------------

namespace {

/// Returns the surface features of a network. A scale that mirrors the network reverses the orientation of
/// its triangles, so it is reversed again here.
SurfaceFeatures featuresOf(const SpringNetwork& network, const SoftBodySettings& settings) {
  SurfaceFeatures features;
  features.triangles = network.surface;
  if (settings.scale.prod() < 0.0)
    for (Triangle& t : features.triangles) std::swap(t[1], t[2]);
  if (!features.triangles.empty()) return features;
  for (const NetworkSpring& spring : network.springs)
    if (spring.kind == SpringKind::Structural) features.segments.push_back({spring.a, spring.b});
  if (features.segments.empty())
    for (std::uint32_t i = 0; i < network.restPoints.size(); ++i) features.vertices.push_back(i);
  return features;
}

std::shared_ptr<const SurfaceTopology> makeTopology(const SpringNetwork& network,
                                                    const SoftBodySettings& settings) {
  Points rest(3, static_cast<Eigen::Index>(network.restPoints.size()));
  for (Eigen::Index i = 0; i < rest.cols(); ++i)
    rest.col(i) = network.restPoints[static_cast<std::size_t>(i)].cwiseProduct(settings.scale);
  Result<SurfaceTopology> topology = makeSurfaceTopology(rest, featuresOf(network, settings));
  return topology ? std::make_shared<const SurfaceTopology>(std::move(*topology)) : nullptr;
}

}  // namespace

std::shared_ptr<const SurfaceTopology> SharedTopologies::of(const SharedNetwork& network,
                                                            const SoftBodySettings& settings) {
  const Key key{network.get(), {settings.scale.x(), settings.scale.y(), settings.scale.z()}};
  Entry& entry = entries_[key];
  std::shared_ptr<const SurfaceTopology> topology = entry.topology.lock();
  if (topology) return topology;
  topology = makeTopology(*network, settings);
  entry.network = network;
  entry.topology = topology;
  for (auto it = entries_.begin(); it != entries_.end();)
    it = it->second.topology.expired() ? entries_.erase(it) : std::next(it);
  return topology;
}

// --- in the world ------------------------------------------------------------------------------------------

void addToWorld(SoftBodyData& body) {
  (isSurfaceBody(body) ? addSurface : addPointMasses)(body);
  addContactWatch(body);
}

void removeFromWorld(SoftBodyData& body) { (isSurfaceBody(body) ? removeSurface : removePointMasses)(body); }

namespace {

bool isInWorld(const btRigidBody* object) { return object && object->isInWorld(); }

}  // namespace

bool anyInWorld(const SoftBodyData& body) {
  if (isSurfaceBody(body)) return isInWorld(body.surface.object);
  return std::any_of(body.masses.bodies.begin(), body.masses.bodies.end(), isInWorld);
}

bool wholeInWorld(const SoftBodyData& body) {
  if (isSurfaceBody(body)) return isInWorld(body.surface.object);
  return std::all_of(body.masses.bodies.begin(), body.masses.bodies.end(), isInWorld);
}

void wakeBody(SoftBodyData& body, bool insideTick) {
  if (isSurfaceBody(body))
    wakeSurface(body);
  else
    wakeWorldPoints(body, insideTick);
  body.asleep = false;
  body.calmTime = 0.0;
}

bool movesTooFast(const SoftBodyData& body, btScalar tick) {
  return (isSurfaceBody(body) ? anySurfacePointMoves : anyPointMoves)(body, tick);
}

void gatherBody(SoftBodyData& body, btScalar tick) {
  (isSurfaceBody(body) ? gatherSurface : gatherWorldPoints)(body, tick);
}

void writeBodyToBullet(SoftBodyData& body, btScalar tick) {
  (isSurfaceBody(body) ? writeBoxToBullet : writeVelocitiesToBullet)(body, tick);
}

void finishBody(SoftBodyData& body, btScalar tick) {
  (isSurfaceBody(body) ? finishSurface : finishWorldPoints)(body, tick);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib

// This file makes bodies and the surfaces that equal bodies share, and takes a body through its life in the
// world.

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

/// Points between two that a spring joins: a rope has 1, one with bending springs 2.
constexpr std::size_t kNarrowBand = 3;

/// Of factorising the banded matrix, about 3 #points (3 width)^2: some 20 us. A cube takes 10 000.
constexpr std::size_t kCheapOperations = 50000;

void placePoints(SoftBodyData& body) {
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

/// m, m/s: what the settings allow, too; Bullet's floats hold the square of the square of it.
constexpr double kLargestPlace = 1e9;

std::string checkPlaces(const PointState& state) {
  for (Eigen::Index i = 0; i < state.position.cols(); ++i)
    for (const Points* array : {&state.position, &state.velocity})
      if (!(array->col(i).cwiseAbs().maxCoeff() <= kLargestPlace))
        return "point " + std::to_string(i) + " would be, or move, beyond 1e9";
  return {};
}

/// Of the eigenvalue: the period that follows from it is good to some 1e-3.
constexpr double kResidual = 0.03;

/// With nothing held and the masses of the settings. Not as it is turned and where: what remains of the
/// residual would be another, and with it, now and then, the number of substeps.
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
  placePoints(*body);
  if (std::string reason = checkPlaces(body->state); !reason.empty()) return Error{reason};
  body->fastestAtRest = fastestAtRest(*body);
  const Points& x = body->state.position;
  body->size = (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).norm();
  const auto place = bandOrder(body->springs, body->network->restPoints.size());
  const std::size_t width = bandWidth(body->springs, place), points = body->network->restPoints.size();
  body->narrow = width <= kNarrowBand;
  body->cheapNewton = 27 * points * width * width <= kCheapOperations;
  return body;
}

// --- surfaces that equal bodies share ----------------------------------------------------------------------

namespace {

/// A scale that mirrors the network turns its triangles inside out: here they are turned back.
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

bool isInWorld(const PointMass* point) { return point && point->isInWorld(); }

}  // namespace

bool anyInWorld(const SoftBodyData& body) {
  if (isSurfaceBody(body)) return body.surface.object && body.surface.object->isInWorld();
  return std::any_of(body.masses.bodies.begin(), body.masses.bodies.end(), isInWorld);
}

bool wholeInWorld(const SoftBodyData& body) {
  if (isSurfaceBody(body)) return body.surface.object && body.surface.object->isInWorld();
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

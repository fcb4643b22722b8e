// SPDX-License-Identifier: Zlib

// This file makes bodies and the models that equal bodies share. It also calls the functions for
// points or for surfaces at each stage of a body's life in the world.

#include "bullet/body_in_world.h"

#include "bullet/point_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- the model of equal bodies -----------------------------------------------------------------------------

namespace {

/// Returns the surface features of a network. A scale that mirrors the network reverses the orientation of
/// its triangles, so it is reversed again here.
SurfaceFeatures featuresOf(const SpringNetwork& network, const SoftBodySettings& settings) {
  SurfaceFeatures features;
  features.triangles = network.surface;
  features.solid = settings.hollow ? Solid::None : Solid::ClosedPieces;
  if (settings.scale.prod() < 0.0)
    for (Triangle& t : features.triangles) std::swap(t[1], t[2]);
  if (!features.triangles.empty()) return features;
  for (const NetworkSpring& spring : network.springs)
    if (spring.kind == SpringKind::Structural) features.segments.push_back({spring.a, spring.b});
  if (features.segments.empty())
    for (std::uint32_t i = 0; i < network.restPoints.size(); ++i) features.vertices.push_back(i);
  return features;
}

/// Relative residual of the eigenvalue. The error of the resulting period is about 1e-5, so that a mirrored
/// body, for which the iteration starts elsewhere, seldom has another number of substeps.
constexpr double kResidual = 0.003;

/// Returns the fastest oscillation with the masses of the settings and no held points. It uses the unrotated
/// rest shape at the origin: otherwise the remaining residual, and sometimes the number of substeps, would
/// depend on the body's initial pose.
double fastestAtRest(const BodyModel& model, const Points& rest) {
  PointState state;
  state.resize(rest.cols());
  state.position = rest;
  for (Eigen::Index i = 0; i < rest.cols(); ++i)
    state.inverseMass.col(i).setConstant(1.0 / model.masses[static_cast<std::size_t>(i)]);
  return fastestOscillationSquared(model.springs, model.volumes, model.tetrahedra, state, kResidual);
}

/// Largest number of blocks below the diagonal in a column of a narrow matrix. A rope has 1, a rope with
/// bending springs 2.
constexpr std::uint32_t kNarrow = 3;

/// Largest number of products in a cheap factorisation, which takes some 20 us. A cube takes 3 500.
constexpr std::size_t kCheapProducts = 20000;

/// A column with n blocks below the diagonal takes n (n + 1) / 2 + n products of blocks, and an inverse.
void measureFactors(BodyModel& model) {
  std::uint32_t widest = 0;
  std::size_t products = 0;
  for (const std::size_t n :
       fillOf(joinedPoints({model.springs, &model.tetrahedra}), model.network->restPoints.size())) {
    widest = std::max(widest, static_cast<std::uint32_t>(n));
    products += 27 * (n * (n + 1) / 2 + n + 1);
  }
  model.narrow = widest <= kNarrow;
  model.cheapNewton = products <= kCheapProducts;
}

/// Sets the masses of the points, and their fractions of the sum: groups may change it.
void setMasses(BodyModel& model, const SoftBodySettings& settings) {
  model.masses = model.rest.fractions = model.network->massFractions;
  for (double& mass : model.masses) mass *= settings.totalMass;
  if (settings.groups.empty()) return;
  const GroupFactors factors(*model.network, settings.groups);
  double sum = 0.0;
  for (std::size_t i = 0; i < model.masses.size(); ++i) sum += model.masses[i] *= factors.mass[i];
  for (std::size_t i = 0; i < model.masses.size(); ++i) model.rest.fractions[i] = model.masses[i] / sum;
}

BodyModel makeModel(const SharedNetwork& network, const SoftBodySettings& settings) {
  BodyModel model;
  model.network = network;
  model.springs = makeSprings(*network, settings);
  model.volumes = makeVolumes(*network, settings);
  model.tetrahedra = makeTetrahedronVolumes(*network, settings);
  model.parts = wettedParts(*network, settings, *model.springs.original);
  const Points rest = scaledRest(*network, settings.scale);
  if (settings.collision == Collision::Surface)
    if (auto topology = makeSurfaceTopology(rest, featuresOf(*network, settings)))
      model.topology = std::move(*topology);
  setMasses(model, settings);
  model.rest.weighted = rest;
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    model.rest.weighted.col(i) *= model.rest.fractions[static_cast<std::size_t>(i)];
    model.rest.meanSquare += model.rest.weighted.col(i).dot(rest.col(i));
  }
  model.fastestAtRest = fastestAtRest(model, rest);
  measureFactors(model);
  return model;
}

std::vector<double> modelKey(const SpringNetwork& network, const SoftBodySettings& s) {
  const ElasticLimit& limit = s.elasticLimit;
  std::vector<double> key = {s.scale.x(),
                             s.scale.y(),
                             s.scale.z(),
                             s.totalMass,
                             s.extensionStiffness,
                             s.compressionStiffness,
                             s.damping,
                             s.volumeModulus.value_or(-1.0),
                             s.pressure,
                             s.ambientPressure,
                             limit.stiffenStrain,
                             limit.stiffenFactor,
                             limit.yieldStrain,
                             limit.yieldMaximum,
                             limit.breakStrain,
                             limit.tear ? 1.0 : 0.0,
                             static_cast<double>(s.collision),
                             s.hollow ? 1.0 : 0.0};
  for (const GroupSettings& g : s.groups) {
    const auto same = [&](const NamedGroup& group) { return group.name == g.name; };
    const auto it = std::find_if(network.groups.begin(), network.groups.end(), same);
    const auto number = static_cast<double>(it - network.groups.begin());
    key.insert(key.end(), {number, g.stiffness, g.damping, g.limitStrain, g.restLength, g.mass});
  }
  return key;
}

/// m. Bullet computes moments of inertia with squares of a fiftieth of it, and their inverses, in floats.
constexpr double kMinSize = 1e-6;

/// kg. The square of its inverse fits in Bullet's floats.
constexpr double kMinPointMass = 1e-15;

/// N/m, N s/m; the settings have the same limit, before the spring's own factor.
constexpr double kMaxStiffness = 1e12;

std::string inWords(double value) {
  char number[40];
  std::snprintf(number, sizeof number, "%g", value);
  return number;
}

std::string checkSprings(const SpringNetwork& network, const SoftBodySettings& s,
                         const GroupFactors& factors) {
  const double stiffest = std::max(s.extensionStiffness, s.compressionStiffness);
  for (std::size_t i = 0; i < network.springs.size(); ++i) {
    const double stiffness = std::max(stiffest * factors.stiffness[i], s.damping * factors.damping[i]) *
                             network.springs[i].stiffnessScale;
    if (!(stiffness <= kMaxStiffness))
      return "spring " + std::to_string(i) + " would have a stiffness or damping of " + inWords(stiffness) +
             ", must be at most 1e12";
  }
  return {};
}

/// Checks the settings together with the network.
std::string checkShape(const SpringNetwork& network, const SoftBodySettings& s) {
  const GroupFactors factors(network, s.groups);
  for (std::size_t i = 0; i < network.massFractions.size(); ++i)
    if (const double mass = s.totalMass * network.massFractions[i] * factors.mass[i];
        !(mass >= kMinPointMass))
      return "point " + std::to_string(i) + " would have a mass of " + inWords(mass) +
             " kg, must be at least 1e-15";
  const double extent = extentOf(scaledRest(network, s.scale));
  if (!(extent >= kMinSize) && !network.springs.empty())
    return "the body would be " + inWords(extent) + " m across, must be at least 1e-6";
  return checkSprings(network, s, factors);
}

std::string checkPoints(const PointState& state) {
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    std::string reason = checkPlace(static_cast<std::size_t>(i), state.position.col(i));
    if (!reason.empty()) return reason;
    const double speed = state.velocity.col(i).norm();
    if (!(speed <= kMaxPointSpeed))
      return "point " + std::to_string(i) + " would move at " + inWords(speed) + " m/s, must be at most 1e6";
  }
  return {};
}

}  // namespace

Result<std::shared_ptr<const BodyModel>> SharedModels::of(const SharedNetwork& network,
                                                          const SoftBodySettings& settings) {
  const Key key{network.get(), modelKey(*network, settings)};
  if (const auto it = models_.find(key); it != models_.end())
    if (std::shared_ptr<const BodyModel> model = it->second.lock()) return model;
  if (Result<void> valid = validate(*network); !valid) return Error{"network: " + valid.error()};
  if (std::string reason = checkGroups(*network, settings.groups); !reason.empty()) return Error{reason};
  if (std::string reason = checkVolume(*network, settings); !reason.empty()) return Error{reason};
  if (std::string reason = checkShape(*network, settings); !reason.empty()) return Error{reason};
  for (auto it = models_.begin(); it != models_.end();)
    it = it->second.expired() ? models_.erase(it) : std::next(it);
  auto model = std::make_shared<const BodyModel>(makeModel(network, settings));
  models_[key] = model;
  return std::shared_ptr<const BodyModel>(std::move(model));
}

// --- a new body --------------------------------------------------------------------------------------------

Eigen::Vector3d centerOfMass(const BodyModel& model, const Points& position) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < model.rest.fractions.size(); ++i)
    center += model.rest.fractions[i] * position.col(static_cast<Eigen::Index>(i));
  return center;
}

void placeAsCreated(SoftBodyData& body) {
  const SoftBodySettings& s = body.settings;
  PointState& state = body.state;
  const Eigen::Matrix3d rotation = s.rotation.toRotationMatrix();
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    const Eigen::Vector3d rest = body.model->network->restPoints[static_cast<std::size_t>(i)];
    state.position.col(i) = s.position + rotation * rest.cwiseProduct(s.scale);
  }
  const Eigen::Vector3d center = centerOfMass(*body.model, state.position);
  for (Eigen::Index i = 0; i < state.position.cols(); ++i)
    state.velocity.col(i) = s.linearVelocity + s.angularVelocity.cross(state.position.col(i) - center);
}

std::string checkPlace(std::size_t point, const Eigen::Vector3d& place) {
  const double coordinate = place.cwiseAbs().maxCoeff();
  if (coordinate <= kMaxCoordinate) return {};
  return "point " + std::to_string(point) + " would have a coordinate of " + inWords(coordinate) +
         " m, must be at most 2e6";
}

Result<std::unique_ptr<SoftBodyData>> makeBodyData(const SharedNetwork& network,
                                                   const SoftBodySettings& settings, SharedModels& models) {
  if (!network) return Error{"there is no network"};
  if (Result<void> valid = validate(settings); !valid) return Error{"settings: " + valid.error()};
  auto model = models.of(network, settings);
  if (!model) return Error{model.error()};
  auto body = std::make_unique<SoftBodyData>();
  body->model = *model;
  body->settings = settings;
  body->springs = body->model->springs;
  body->volumes = body->model->volumes;
  body->tetrahedra = body->model->tetrahedra;
  body->state.resize(static_cast<Eigen::Index>(network->restPoints.size()));
  placeAsCreated(*body);
  if (std::string reason = checkPoints(body->state); !reason.empty()) return Error{reason};
  body->size = extentOf(body->state.position);
  body->models = &models;
  body->surface.frame = settings.rotation.normalized();
  return body;
}

// --- in the world ------------------------------------------------------------------------------------------

void addToWorld(SoftBodyData& body) {
  (isSurfaceBody(body) ? addSurface : addPointMasses)(body);
  addContactWatch(body);
}

void removeFromWorld(SoftBodyData& body) { (isSurfaceBody(body) ? removeSurface : removePointMasses)(body); }

namespace {

bool isInWorld(const btRigidBody* object) { return object && object->isInWorld(); }

/// Returns whether all of the body's objects are in its world, which still exists.
bool wholeInWorld(const SoftBodyData& body) {
  const auto isHere = [&](const btRigidBody* object) {
    return isInWorld(object) && !isElsewhere(*object, *body.world);
  };
  if (isSurfaceBody(body)) return isHere(body.surface.object);
  return std::all_of(body.masses.bodies.begin(), body.masses.bodies.end(), isHere);
}

void wakeRigid(btCollisionObject& object, bool insideTick) {
  if (object.isActive() || isStaticOrKinematic(object)) return;
  object.activate();
  btRigidBody* rigid = btRigidBody::upcast(&object);
  if (rigid && insideTick) rigid->applyGravity();
}

/// Whether the body gets out of another one, which is slow without gravity.
bool getsOut(SoftBodyData& body, btScalar tick) {
  constexpr double kStuck = 0.1;  // of the speed at which it should
  const double least = kStuck * body.speeds.recovery * double(tick);
  return body.surface.overlapTicks > 0 && sumsOf(body).farthest > least * least;
}

}  // namespace

bool anyInWorld(const SoftBodyData& body) {
  if (isSurfaceBody(body)) return isInWorld(body.surface.object);
  return std::any_of(body.masses.bodies.begin(), body.masses.bodies.end(), isInWorld);
}

bool isAlive(SoftBodyData& body) {
  if (!wholeInWorld(body)) return false;
  const std::vector<PointMass*>& points = body.masses.bodies;
  if (!body.alive && std::find(points.begin(), points.end(), nullptr) != points.end()) return false;
  if (isSurfaceBody(body)) adoptObject(body);
  if (body.alive) return true;
  body.alive = true;
  forgetMotion(body);
  forgetSearches(body);
  body.surface.contacts.clear();
  body.masses.startPosition = body.state.position;
  wakeBody(body, false);
  *body.groupsStale = true;
  return true;
}

void updateQueryBoxes(SoftBodyData& body) {
  if (isSurfaceBody(body)) return updateQueryBox(body);
  for (PointMass* point : body.masses.bodies)
    if (isInWorld(point)) body.world->updateSingleAabb(point);
}

void wakeAnchored(SoftBodyData& body, bool insideTick) {
  const btCollisionObjectArray& objects = body.world->getCollisionObjectArray();
  for (const Anchor& anchor : body.anchors)
    // the application may have deleted the body
    if (objects.findLinearSearch(anchor.body) < objects.size()) wakeRigid(*anchor.body, insideTick);
}

void wakeNeighbours(SoftBodyData& body, bool insideTick) {
  if (!anyInWorld(body)) return;
  wakeAnchored(body, insideTick);
  const double margin = 2.0 * radiusOf(body) + double(gContactBreakingThreshold);
  forEachObjectIn(*body.world, boxAround(body.state.position, margin), [&](btCollisionObject& object) {
    SoftBodyData* owner = ownerOf(object);
    if (owner && owner != &body && owner->alive && owner->asleep) wakeBody(*owner, insideTick);
    if (!isSoft(&object)) wakeRigid(object, insideTick);
  });
}

void wakeBody(SoftBodyData& body, bool insideTick) {
  if (isSurfaceBody(body))
    wakeSurface(body);
  else
    wakeWorldPoints(body, insideTick);
  body.asleep = false;
  body.calmTime = 0.0;
}

void putToSleep(SoftBodyData& body) {
  body.asleep = true;
  body.substeps = 0;
  body.surface.partners.clear();
  if (body.surface.object) body.surface.object->setActivationState(ISLAND_SLEEPING);
  for (PointMass* point : body.masses.bodies)
    if (point && body.masses.exposed) point->setActivationState(ISLAND_SLEEPING);
}

bool movesTooFast(SoftBodyData& body, btScalar tick) {
  if (isSurfaceBody(body) && getsOut(body, tick)) return true;
  return isSurfaceBody(body) ? anySurfacePointMoves(body, tick) : anyPointMoves(body, tick);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "bullet_soft/bullet_twin.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <utility>

namespace limber::bullet_soft {
namespace {

constexpr double kTwinTick = 1.0 / double(scenes::kTicksPerSecond);  // s
constexpr double kLostStretch = 3.0;  // RMS strain of bodies that have lost their shape for good
constexpr double kHardness = 1.0;     // kKHR: with Bullet's default of 0.1 bodies sink into static ones

/// Returns what of a body's settings btSoftBody cannot have, or an empty string.
std::string missingOf(const SoftBody& body) {
  const SoftBodySettings& s = body.settings();
  const ElasticLimit& limit = s.elasticLimit;
  if (s.extensionStiffness != s.compressionStiffness) return "springs that pull and push differently";
  if (limit.breakStrain > 0.0) return "springs that break";
  if (limit.yieldStrain > 0.0) return "springs that yield";
  if (limit.stiffenStrain > 0.0) return "springs that stiffen";
  if (!s.groups.empty()) return "groups of springs with factors";
  for (std::uint32_t i = 0; i < body.pointCount(); ++i)
    if (body.attached(i)) return "points attached to rigid bodies";
  return {};
}

std::string missingOf(const scenes::Scene& scene) {
  if (scene.soft->water()) return "water that carries bodies";
  if (scene.soft->springCount() > 0) return "springs between bodies";
  if (scene.world->dynamics.getNumConstraints() > 0) return "joints in this view";
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b)
    if (const std::string missing = missingOf(*scene.soft->body(b)); !missing.empty()) return missing;
  return {};
}

/// The differences with which a scene can still be played.
std::vector<std::string> notesOf(const scenes::Scene& scene) {
  bool damped = false, filled = false, blownRope = false, self = false;
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    const SoftBody& body = *scene.soft->body(b);
    const SoftBodySettings& s = body.settings();
    const bool solid = body.network().kind == NetworkKind::Solid;
    damped = damped || s.damping > 0.0;
    filled = filled || (solid && s.volumeModulus.value_or(1.0) > 0.0);
    blownRope = blownRope || body.network().kind == NetworkKind::Rope;
    self = self || s.selfCollision;
  }
  std::vector<std::string> notes;
  if (damped) notes.push_back("no dampers along springs");
  if (filled) notes.push_back("no volume term");
  if (blownRope) notes.push_back("no drag of the air on ropes");
  if (self) notes.push_back("no contacts with itself");
  return notes;
}

double linearDragOf(const SoftBody& body) {
  const bool thin = body.network().kind != NetworkKind::Solid;
  return body.settings().flow.linearDrag.value_or(thin ? 0.3 : 0.0);  // Limber's defaults
}

/// m, half of the smallest side of a rigid body.
double smallestRigid(const scenes::SceneWorld& world) {
  double smallest = 1.0;
  for (const auto& shape : world.shapes) {
    btVector3 low, high;
    shape->getAabb(btTransform::getIdentity(), low, high);
    const btVector3 half = btScalar(0.5) * (high - low);
    smallest = std::min({smallest, double(half.x()), double(half.y()), double(half.z())});
  }
  return smallest;
}

/// btSoftBody reads the distances of rigid shapes at the corners of a grid. Bullet's cells of 0.25 m are as
/// large as the balls of some scenes.
double cellSize(const scenes::SceneWorld& world) {
  return std::clamp(0.25 * smallestRigid(world), 0.02, 0.25);
}

/// Drag of cloths, which has the coefficients of Limber's.
void setAerodynamics(btSoftBody& body, const SoftBody& made) {
  if (made.network().kind != NetworkKind::Cloth) return;
  const double drag = made.settings().flow.drag.value_or(1.2);  // Limber's default
  body.m_cfg.aeromodel = btSoftBody::eAeroModel::F_TwoSidedLiftDrag;
  body.m_cfg.kDG = static_cast<btScalar>(drag);
  body.m_cfg.kLF = static_cast<btScalar>(made.settings().flow.lift.value_or(drag));
}

void setContacts(btSoftBody& body) {
  body.m_cfg.collisions = btSoftBody::fCollision::SDF_RS;
  if (body.m_faces.size() > 0) body.m_cfg.collisions |= btSoftBody::fCollision::VF_SS;
  body.m_cfg.kKHR = static_cast<btScalar>(kHardness);
}

BodySetup setupOf(const SoftBody& made) {
  BodySetup setup;
  setup.network = made.sharedNetwork();
  setup.settings = made.settings();
  for (std::uint32_t i = 0; i < made.pointCount(); ++i)
    if (made.pinned(i)) setup.pins.push_back(i);
  return setup;
}

/// Adds a spring to the figures of a body.
void addStrain(const NetworkSpring& spring, double strain, double& squares, std::size_t& count,
               double& largest) {
  if (spring.kind == SpringKind::Bending) return;
  squares += strain * strain;
  largest = std::max(largest, std::abs(strain));
  ++count;
}

/// Sums up the figures of bodies.
class FigureSum {
 public:
  void add(const SpringNetwork& network, const BodyStart& start, const Eigen::Matrix3Xd& positions,
           const Eigen::Matrix3Xd& velocities, const std::vector<bool>& pinned) {
    for (Eigen::Index i = 0; i < positions.cols(); ++i)
      if (!pinned[std::size_t(i)]) sum_.kinetic += 0.5 * start.masses[i] * velocities.col(i).squaredNorm();
    for (std::size_t s = 0; s < network.springs.size(); ++s) {
      const NetworkSpring& spring = network.springs[s];
      const auto k = static_cast<Eigen::Index>(s);
      const double rest = start.restLengths[k];
      const double change = (positions.col(spring.a) - positions.col(spring.b)).norm() - rest;
      sum_.elastic += 0.5 * start.stiffnesses[k] * change * change;
      if (rest > 0.0) addStrain(spring, change / rest, squares_, count_, sum_.largest);
    }
  }

  SpringFigures result() const {
    SpringFigures figures = sum_;
    if (count_ > 0) figures.stretch = std::sqrt(squares_ / double(count_));
    return figures;
  }

 private:
  SpringFigures sum_;
  double squares_ = 0.0;
  std::size_t count_ = 0;
};

}  // namespace

bool TwinSettings::operator==(const TwinSettings& other) const {
  return iterations == other.iterations && stiffness == other.stiffness && damping == other.damping &&
         pressure == other.pressure && friction == other.friction && margin == other.margin;
}

// --- making it ---------------------------------------------------------------------------------------------

std::string BulletTwin::problemOf(const scenes::Scene& scene) {
  const std::string missing = missingOf(scene);
  return missing.empty() ? missing : "btSoftBody has no " + missing;
}

Result<std::unique_ptr<BulletTwin>> BulletTwin::create(std::unique_ptr<scenes::Scene> scene) {
  if (std::string problem = problemOf(*scene); !problem.empty()) return Error{std::move(problem)};
  return std::unique_ptr<BulletTwin>(new BulletTwin(std::move(scene)));
}

BulletTwin::BulletTwin(std::unique_ptr<scenes::Scene> scene)
    : scene_(std::move(scene)), notes_(notesOf(*scene_)) {
  world_.setGravity(scene_->world->dynamics.getGravity());
  world_.getWorldInfo().m_gravity = world_.getGravity();
  world_.getWorldInfo().m_sparsesdf.setDefaultVoxelsz(static_cast<btScalar>(cellSize(*scene_->world)));
  takeRigidBodies();
  for (std::size_t b = 0; b < scene_->soft->bodyCount(); ++b) addBody(*scene_->soft->body(b));
  apply(settings_);
}

BulletTwin::~BulletTwin() {
  for (const Body& body : bodies_) world_.removeSoftBody(body.soft.body.get());
  for (int i = world_.getNumCollisionObjects() - 1; i >= 0; --i)
    world_.removeCollisionObject(world_.getCollisionObjectArray()[i]);
}

void BulletTwin::takeRigidBodies() {
  const auto take = [this](btRigidBody& body) {
    scene_->world->dynamics.removeRigidBody(&body);
    world_.addRigidBody(&body);
  };
  const auto &statics = scene_->world->statics, &movables = scene_->world->movables;
  while (staticsTaken_ < statics.size()) take(*statics[staticsTaken_++]);
  while (movablesTaken_ < movables.size()) take(*movables[movablesTaken_++]);
}

void BulletTwin::addBody(const SoftBody& made) {
  const BodySetup setup = setupOf(made);
  Body body;
  body.start = startOf(setup);
  body.soft = makeBulletSoftBody(setup, body.start, world_.getWorldInfo());
  body.linearDrag = linearDragOf(made);
  body.stiffness = setup.settings.extensionStiffness;
  body.pinned.assign(made.pointCount(), false);
  for (const std::uint32_t pin : setup.pins) body.pinned[pin] = true;
  btSoftBody& soft = *body.soft.body;
  if (made.network().kind == NetworkKind::Solid) body.volume = std::abs(double(soft.getVolume()));
  setContacts(soft);
  setAerodynamics(soft, made);
  soft.setCollisionFlags(soft.getCollisionFlags() | btCollisionObject::CF_DISABLE_VISUALIZE_OBJECT);
  world_.addSoftBody(&soft, setup.settings.collisionGroup, setup.settings.collisionMask);
  bodies_.push_back(std::move(body));
}

// --- settings ----------------------------------------------------------------------------------------------

void BulletTwin::apply(const TwinSettings& settings) {
  settings_ = settings;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    btSoftBody& soft = *body.soft.body;
    const SoftBodySettings& made = scene_->soft->body(b)->settings();
    soft.m_cfg.piterations = settings.iterations;
    const double damping = 1.0 - std::exp(-body.linearDrag * kTwinTick) + settings.damping;
    soft.m_cfg.kDP = static_cast<btScalar>(std::min(damping, 1.0));
    soft.m_cfg.kPR = static_cast<btScalar>((made.pressure + settings.pressure) * body.volume);
    soft.m_cfg.kDF = static_cast<btScalar>(settings.friction * made.friction);
    const double radius = pointRadius(scene_->soft->body(b)->network(), made);
    soft.getCollisionShape()->setMargin(static_cast<btScalar>(settings.margin * radius));
    stiffen(body);
  }
}

/// Gives the links their stiffness.
void BulletTwin::stiffen(Body& body) {
  btSoftBody& soft = *body.soft.body;
  const SpringNetwork& network = scene_->soft->body(std::size_t(&body - bodies_.data()))->network();
  if (settings_.stiffness <= 0.0) {
    calibrateLinks(body.soft, network, body.start, settings_.iterations, kTwinTick);
    return;
  }
  btSoftBody::Material* material = soft.m_materials[0];
  material->m_kLST = static_cast<btScalar>(settings_.stiffness);
  for (int s = 0; s < soft.m_links.size(); ++s) soft.m_links[s].m_material = material;
  soft.updateLinkConstants();
}

// --- stepping ----------------------------------------------------------------------------------------------

void BulletTwin::tick(const scenes::Scene& other, const TwinSettings& settings,
                      const std::optional<HeldPoint>& held) {
  if (!problem_.empty()) return;
  if (scene_->beforeTick) scene_->beforeTick(*scene_);
  follow(other);
  if (!problem_.empty()) return;
  if (!(settings == settings_)) apply(settings);
  blow(other);
  if (held) pull(*held);
  const auto start = std::chrono::steady_clock::now();
  world_.stepSimulation(static_cast<btScalar>(kTwinTick), 0);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  tickMs_ = took.count();
  ++scene_->ticks;
  if (!isFinite() || figures().stretch > kLostStretch) problem_ = "btSoftBody has become unstable";
}

/// Takes over what has changed in the other scene.
void BulletTwin::follow(const scenes::Scene& other) {
  const btVector3 gravity = other.world->dynamics.getGravity();
  world_.getWorldInfo().m_gravity = gravity;
  if (!(gravity == world_.getGravity())) {
    for (int i = 0; i < world_.getNumCollisionObjects(); ++i) world_.getCollisionObjectArray()[i]->activate();
    world_.setGravity(gravity);
  }
  for (std::size_t b = 0; b < bodies_.size() && problem_.empty(); ++b)
    followBody(bodies_[b], *other.soft->body(b));
}

void BulletTwin::followBody(Body& body, const SoftBody& other) {
  if (other.pointCount() != body.pinned.size()) {
    problem_ = "btSoftBody cannot be cut or torn like this";
    return;
  }
  const SoftBodySettings& settings = other.settings();
  bool changed = settings.extensionStiffness != body.stiffness;
  if (changed) {
    body.start.stiffnesses *= settings.extensionStiffness / body.stiffness;
    body.stiffness = settings.extensionStiffness;
  }
  for (std::uint32_t i = 0; i < other.pointCount(); ++i) {
    if (other.pinned(i) == body.pinned[i]) continue;
    body.pinned[i] = other.pinned(i);
    pinNode(body.soft, i, body.pinned[i]);
    changed = true;
  }
  if (changed) stiffen(body);
}

/// Sets the wind: that at the centre of each body.
void BulletTwin::blow(const scenes::Scene& other) {
  const Air& air = other.soft->air();
  world_.getWorldInfo().air_density = static_cast<btScalar>(air.density);
  const double seconds = double(scene_->ticks) * kTwinTick;
  for (Body& body : bodies_) {
    if (body.soft.body->m_cfg.kDG == btScalar(0)) continue;
    Eigen::Vector3d wind = air.wind;
    if (air.windAt) wind += air.windAt(nodePositions(body.soft).rowwise().mean(), seconds);
    body.soft.body->setWindVelocity(toBullet(wind));
  }
}

/// Pulls the point as limber::Grab does: with the critically damped spring on which the whole body would
/// oscillate with 4 Hz, solved implicitly for this point.
void BulletTwin::pull(const HeldPoint& held) {
  if (held.body >= bodies_.size()) return;
  Body& body = bodies_[held.body];
  if (held.point >= body.pinned.size() || body.pinned[held.point]) return;
  constexpr double kRate = 2.0 * 3.141592653589793 * 4.0;  // rad/s
  btSoftBody::Node& node = body.soft.node(held.point);
  const double share = body.start.masses.sum() * double(node.m_im) * kTwinTick;
  const double spring = share * kRate * kRate, damper = share * 2.0 * kRate;
  const Eigen::Vector3d away = held.place - fromBullet(node.m_x);
  const Eigen::Vector3d velocity = fromBullet(node.m_v);
  node.m_v = toBullet((velocity + spring * away) / (1.0 + damper + spring * kTwinTick));
  body.soft.body->activate(true);
}

bool BulletTwin::isFinite() const {
  return std::all_of(bodies_.begin(), bodies_.end(), [](const Body& body) {
    const auto& nodes = body.soft.body->m_nodes;
    for (int i = 0; i < nodes.size(); ++i)
      if (!std::isfinite(double(nodes[i].m_x.length2()))) return false;
    return true;
  });
}

// --- results -----------------------------------------------------------------------------------------------

Eigen::Vector3d BulletTwin::position(std::size_t b, std::uint32_t i) const {
  return fromBullet(bodies_[b].soft.node(i).m_x);
}

Eigen::Vector3d BulletTwin::center(std::size_t b) const {
  return nodePositions(bodies_[b].soft).rowwise().mean();
}

void BulletTwin::writePositions(std::size_t b, float* xyz, double tickFraction) const {
  const BulletSoftBody& soft = bodies_[b].soft;
  for (std::uint32_t i = 0; i < soft.nodeOfPoint.size(); ++i) {
    const btSoftBody::Node& node = soft.node(i);
    const btVector3 place = node.m_q.lerp(node.m_x, static_cast<btScalar>(tickFraction));
    for (int k = 0; k < 3; ++k) *xyz++ = static_cast<float>(place[k]);
  }
}

SpringFigures BulletTwin::figures() const {
  FigureSum sum;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = bodies_[b];
    sum.add(scene_->soft->body(b)->network(), body.start, nodePositions(body.soft), nodeVelocities(body.soft),
            body.pinned);
  }
  return sum.result();
}

SpringFigures BulletTwin::figuresOf(const scenes::Scene& other) const {
  FigureSum sum;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const SoftBody& body = *other.soft->body(b);
    const auto count = static_cast<Eigen::Index>(bodies_[b].pinned.size());
    if (static_cast<Eigen::Index>(body.pointCount()) < count) continue;
    Eigen::Matrix3Xd positions(3, count), velocities(3, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      positions.col(i) = body.position(static_cast<std::uint32_t>(i));
      velocities.col(i) = body.velocity(static_cast<std::uint32_t>(i));
    }
    sum.add(scene_->soft->body(b)->network(), bodies_[b].start, positions, velocities, bodies_[b].pinned);
  }
  return sum.result();
}

std::uint64_t BulletTwin::stateHash() const {
  std::uint64_t hash = 14695981039346656037ull;  // FNV-1a
  const auto add = [&hash](btScalar value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof value);
    hash = (hash ^ bits) * 1099511628211ull;
  };
  for (const Body& body : bodies_) {
    const auto& nodes = body.soft.body->m_nodes;
    for (int i = 0; i < nodes.size(); ++i)
      for (int k = 0; k < 3; ++k) add(nodes[i].m_x[k]), add(nodes[i].m_v[k]);
  }
  return hash;
}

}  // namespace limber::bullet_soft

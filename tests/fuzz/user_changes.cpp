// SPDX-License-Identifier: Zlib
// The user changes soft bodies as a whole: settings, place, motion, saved states.
#include "fuzz/world_player.h"

#include <limber/contact_filter.h>
#include <limber/contacts.h>
#include <limber/skeleton.h>

namespace limber::fuzz {
namespace {

/// Changes one of the settings, which `variant` selects, by `factor`.
SoftBodySettings changedSettings(SoftBodySettings s, int variant, double factor, const Eigen::Vector3d& by) {
  switch (variant % 12) {
    case 0:
      s.extensionStiffness *= factor;
      break;
    case 1:
      s.compressionStiffness *= factor;
      break;
    case 2:
      s.damping = factor;
      break;
    case 3:
      s.totalMass *= factor;
      break;
    case 4:
      s.scale *= std::min(factor, 1.5);
      break;
    case 5:
      s.scale = s.scale.cwiseProduct(Eigen::Vector3d(Eigen::Vector3d::Constant(1.2) + 0.1 * by));
      break;
    case 6:
      s.friction = factor;
      break;
    case 7:
      s.collisionMask = s.collisionMask == 0 ? -1 : 0;
      break;
    case 8:
      s.gravityFactor = 1.0 - factor;
      break;
    case 9:
      s.stepping.maxSubsteps = s.stepping.maxSubsteps > 0 ? 0 : 7;
      break;
    case 10:
      s.volumeModulus = s.volumeModulus.value_or(0.0) > 0.0 ? 0.0 : 500.0 * factor;
      break;
    default:
      s.pointRadius = 0.01 * factor;
      s.elasticLimit.yieldStrain = 0.05;
  }
  return s;
}

/// Cuts a body with a square blade about its centre.
void cutByBlade(SoftBody& body, const btTransform& place, double size) {
  const auto half = static_cast<btScalar>(0.5 * size);
  const auto corner = [&](int x, int y) {
    const btVector3 local(static_cast<btScalar>(x) * half, static_cast<btScalar>(y) * half, 0);
    return body.transform().getOrigin() + place.getBasis() * local;
  };
  static_cast<void>(body.cut({corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)}));
}

}  // namespace

void WorldPlayer::changeSoft(const Step& s) {
  SoftBody* body = livingSoft(s.whole("of"));
  if (!body) return;
  const std::string& what = s.choice("what");
  const btVector3 by = toBt(s.vec("by")), spin = toBt(s.vec("spin"));
  const auto point = static_cast<std::uint32_t>(s.whole("variant")) % body->pointCount();
  btTransform to(rotationOf(s.vec("rotation")), by);
  to = btTransform(to.getRotation() * body->transform().getRotation(), body->transform().getOrigin() + by);
  if (what == "settings")
    static_cast<void>(
        body->change(changedSettings(body->settings(), s.whole("variant"), s["factor"], s.vec("by"))));
  else if (what == "place")
    static_cast<void>(body->setTransform(to));
  else if (what == "motion")
    static_cast<void>(body->setVelocity(by, spin));
  else if (what == "reset")
    static_cast<void>(s.whole("variant") % 2 ? body->reset() : body->reset(to));
  else if (what == "push")
    pushSoft(*body, s, point);
  else if (what == "pin" && body->pinned(point))
    static_cast<void>(body->teleportPin(point, toBt(body->position(point) + s.vec("by"))));
  else if (what == "pin")
    static_cast<void>(body->pin(point));
  else if (what == "save")
    saved_[s.whole("of")] = body->saveState();
  else if (what == "restore" && saved_.count(s.whole("of")))
    static_cast<void>(body->restoreState(saved_[s.whole("of")]));
  else if (what == "cut")
    static_cast<void>(body->cut(body->transform().getOrigin() + by * btScalar(0.1), spin));
  else if (what == "blade")
    cutByBlade(*body, to, s["factor"]);
  else if (what == "clone" && phase_ == Phase::Between)
    static_cast<void>(systemOf(soft(s.whole("of"))->system)->clone(body, to));
  else if (what == "bones" || what == "release")
    carrySoft(*body, s, what == "release");
  else if (what == "present")
    static_cast<void>(body->presentNetwork());
  else
    joinSoft(*body, s, point);
}

namespace {

/// Rejects, reports, turns, carries or loads contacts, by their triangle and place alone.
ContactFilter filterOf(int variant, const btVector3& by) {
  return [variant, by](ContactCandidate& c) {
    switch (variant % 6) {
      case 0:
        if (c.otherTriangle % 2 == 0) c.response = ContactResponse::Ignore;
        break;
      case 1:
        if (c.position.x() > by.x()) c.response = ContactResponse::Report;
        break;
      case 2:
        c.facing = by;
        break;
      case 3:
        c.surfaceVelocity = by;
        break;
      case 4:
        c.massFactor = 1e3, c.otherMassFactor = 1e-3;
        break;
      default:
        c.friction = 2.0, c.restitution = 0.9;
    }
  };
}

/// A plain world of its own.
struct SpareWorld {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

}  // namespace

/// Writes all bodies of a system, and reads and steps them in another world.
void WorldPlayer::loadElsewhere(SoftBodySystem& system) {
  SpareWorld spare;
  SoftBodySystem other(spare.world);
  const auto loaded = other.loadBodies(system.saveBodies());
  if (!loaded) return fail("loads", loaded.error());
  std::size_t living = 0;
  for (std::size_t b = 0; b < system.bodyCount(); ++b) living += system.body(b)->alive() ? 1u : 0u;
  if (loaded->size() != living)
    return fail("loads", std::to_string(loaded->size()) + " of " + std::to_string(living) + " bodies");
  spare.world.stepSimulation(btScalar(1.0 / 60.0), 0, btScalar(1.0 / 60.0));
}

void WorldPlayer::weldSoft(SoftBody& body, const Step& s) {
  SpringSettings settings;
  settings.stiffness = 100.0 * s["factor"];
  settings.breakForce = s.whole("variant") % 2 ? 10.0 * s["factor"] : 0.0;
  for (const auto& [id, object] : softs_)
    if (SoftBody* other = livingSoft(id);
        other && other != &body && object.system == soft(s.whole("of"))->system)
      return static_cast<void>(systemOf(object.system)->weld(&body, other, 0.3 * s["factor"], settings));
}

void WorldPlayer::joinSoft(SoftBody& body, const Step& s, std::uint32_t point) {
  const int id = s.whole("of");
  const std::string& what = s.choice("what");
  SoftBodySystem& system = *systemOf(soft(id)->system);
  if (what == "weld") {
    weldSoft(body, s);
  } else if (what == "grab" && grabs_.count(id)) {
    if (s.whole("variant") % 3 == 0) return static_cast<void>(grabs_.erase(id));
    grabs_[id].moveTo(toBt(body.centerOfMass() + s.vec("by")));
  } else if (what == "grab") {
    if (auto held = grab(system, &body, point)) grabs_[id] = std::move(*held);
  } else if (what == "load" && phase_ == Phase::Between) {
    loadElsewhere(system);
  } else if (what == "filter") {
    system.setContactFilter(s.whole("variant") % 4 ? filterOf(s.whole("variant"), toBt(s.vec("by")))
                                                   : ContactFilter());
  }
}

/// Binds every third point to a bone that is first at the body's place, some with limits; then moves the
/// bone.
void WorldPlayer::carrySoft(SoftBody& body, const Step& s, bool release) {
  const int id = s.whole("of"), variant = s.whole("variant");
  const auto held = skeletons_.find(id);
  if (release && held != skeletons_.end()) return held->second.release();
  const std::vector<btTransform> bones = {btTransform(
      rotationOf(0.1 * s.vec("rotation")), body.transform().getOrigin() + toBt(0.2 * s.vec("by")))};
  if (held != skeletons_.end()) return static_cast<void>(held->second.moveTo(bones, variant % 5 == 0));
  std::vector<BoundPoint> points;
  for (std::uint32_t i = static_cast<std::uint32_t>(variant % 3); i < body.pointCount(); i += 3) {
    const double limit = i % 2 ? 0.05 * s["factor"] : 0.0;
    points.push_back({i, {{0, 1.0}}, limit, limit > 0.0 && !body.network().surface.empty() ? 0.0 : -1.0});
  }
  SoftBodySystem& system = *systemOf(soft(id)->system);
  if (auto skeleton = Skeleton::bind(system, body, points, {body.transform()}))
    skeletons_.emplace(id, std::move(*skeleton));
}

void WorldPlayer::pushSoft(SoftBody& body, const Step& s, std::uint32_t point) {
  const btVector3 by = toBt(s.vec("by"));
  switch (s.whole("variant") % 7) {
    case 0:
      return static_cast<void>(body.applyForce(by));
    case 1:
      return static_cast<void>(body.applyForce(by, point));
    case 2:
      return static_cast<void>(body.applyTorque(by));
    case 3:
      return static_cast<void>(body.applyImpulse(by));
    case 4:
      return static_cast<void>(body.applyImpulse(by, point));
    case 5:
      return static_cast<void>(body.applyTorqueImpulse(by));
    default:
      return static_cast<void>(body.applyBlast(toBt(body.centerOfMass() + s.vec("by")), 2, 3));
  }
}

}  // namespace limber::fuzz

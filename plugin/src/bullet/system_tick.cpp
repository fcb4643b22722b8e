// SPDX-License-Identifier: Zlib
#include "bullet/body_in_world.h"
#include "bullet/contact_gather.h"
#include "bullet/group_sleep.h"
#include "bullet/group_stepping.h"
#include "bullet/joint_rows.h"
#include "bullet/known_contacts.h"
#include "bullet/pair_gather.h"
#include "bullet/surface_body.h"
#include "bullet/surface_partners.h"
#include "bullet/system_impl.h"

#include <chrono>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Adds the milliseconds of its life to `sum`.
class StopWatch {
 public:
  explicit StopWatch(double& sum) : sum_(sum), start_(std::chrono::steady_clock::now()) {}
  ~StopWatch() {
    sum_ += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }
  StopWatch(const StopWatch&) = delete;
  StopWatch& operator=(const StopWatch&) = delete;

 private:
  double& sum_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace

void SoftBodySystem::Impl::updateLiving() {
  living.clear();
  for (auto& body : bodies)
    if (body->data_->alive) {
      body->data_->index = static_cast<std::uint32_t>(living.size());
      living.push_back(body->data_.get());
    }
}

void SoftBodySystem::Impl::rebuildGroupsIfNeeded() {
  for (const TickGroup& group : groups) groupsStale = groupsStale || !isWhole(group);
  groupsStale = groupsStale || countUsableLinks(living, springs) != usableLinks;
  if (!groupsStale) return;
  updateLiving();
  groups = makeGroups(living, springs);
  plan.clear();
  usableLinks = countUsableLinks(living, springs);
  groupsStale = false;
}

void SoftBodySystem::Impl::gatherGroups(btScalar tick) {
  const StopWatch watch(profile.gatherMs);
  for (TickGroup& group : groups) {
    if (group.asleep) continue;
    gatherGroup(group, tick);
  }
  for (TickGroup& group : groups)
    if (!group.asleep)
      for (SoftBodyData* body : group.bodies) gatherPartners(*body, tick);
  gatherClusters(tick);
  for (TickGroup& group : groups)
    if (!group.asleep) chooseStepping(group, double(tick));
}

void SoftBodySystem::Impl::gatherPartners(SoftBodyData& body, btScalar tick) {
  if (isSurfaceBody(body)) return gatherSurfacePairs(body, tick, rigidSurfaces, search, pairs);
  for (btRigidBody* partner : body.freePartners) limber::gatherPairs(body, *partner, tick, pairs);
}

void SoftBodySystem::Impl::gatherClusters(btScalar tick) {
  guessBearings(pairs);
  addLinkedRigids(groups, pairs);
  gatherRigidContacts(*world, tick, manifolds, pairs);
  makeClusters(groups, pairs, tick, clusters);
}

void SoftBodySystem::Impl::stepGroups(btScalar tick) {
  const StopWatch watch(profile.stepMs);
  plan.step(groups, double(tick));
  for (Cluster& cluster : clusters) stepCluster(cluster, double(tick));
}

void SoftBodySystem::Impl::handOverGroups(btScalar tick) {
  const StopWatch watch(profile.handOverMs);
  for (Cluster& cluster : clusters) handOverCluster(cluster, pairs, tick);
  reportRigidContacts(pairs);
  rememberBearings(living, pairs);
  for (TickGroup& group : groups) {
    if (group.asleep) continue;
    reportStepping(group, double(tick));
    handOverGroup(group, tick);
    for (const SoftBodyData* body : group.bodies) {
      profile.pointsStepped += body->network->restPoints.size();
      profile.springSubsteps += body->springs.size() * static_cast<std::size_t>(group.substeps);
    }
  }
}

void SoftBodySystem::Impl::beforeTick(btScalar tick) {
  profile = TickProfile();
  hideManifolds();
  // a tick without length moves nothing and would divide by zero
  if (!(tick > btScalar(0))) return;
  rebuildGroupsIfNeeded();
  beginStepOfForces();
  collectPartners(*world, this);
  collectMovers(*world, this, tick);
  updateSleep(groups, *world, tick, islands);
  pairs.clear();
  rigidSurfaces.clear();
  readManifolds(*world->getDispatcher());
  freeManifolds(*world->getDispatcher());
  gatherGroups(tick);
  stepGroups(tick);
  handOverGroups(tick);
}

void SoftBodySystem::Impl::afterTick(btScalar tick) {
  if (!(tick > btScalar(0))) return;
  const StopWatch watch(profile.takeBackMs);
  for (TickGroup& group : groups) {
    if (group.asleep) continue;
    takeBackGroup(group, tick);
    for (std::size_t i = 0; i < group.springs.size(); ++i)
      group.springs[i]->force_ = group.step.links.springs[i].force;
  }
  for (const Cluster& cluster : clusters) takeBackCluster(cluster, pairs, tick);
  reportJoints(pairs, tick);
  reportContacts(living, pairs, *world, double(tick));
  reportContactImpulses(*world->getDispatcher());
  tellOfContacts();
}

// Forces on point masses outside the world last, as Bullet's do, for all ticks of one stepSimulation().

void SoftBodySystem::Impl::watchSteps() {
  if (!sentinel) sentinel = std::make_unique<StepSentinel>(*world, *this);
}

void SoftBodySystem::Impl::stopWatching(bool alive) {
  if (sentinel && alive) sentinel->leave();
  sentinel.reset();
}

void SoftBodySystem::Impl::beginStepOfForces() {
  if (!sentinel || !sentinel->stepHasBegun()) return;
  for (SoftBodyData* body : living)
    if (isSurfaceBody(*body) && body->masses.shared) body->surface.force.setZero();
}

/// What is applied from here on until a step ends without a tick is lost, as with Bullet's bodies: it is
/// counted to a step that is over.
void SoftBodySystem::Impl::afterTickOrEmptyStep() {
  for (SoftBodyData* body : living)
    if (isSurfaceBody(*body) && body->masses.shared) collectForces(*body);
}

void SoftBodySystem::Impl::tickMissed() {
  hideManifolds();
  if (overwritten) return;
  overwritten = true;
  warn(
      "the world's pre-tick callback was overwritten after soft bodies were added: springs are not stepped. "
      "Set yours before the first soft body, or call SoftBodySystem::rehook().");
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

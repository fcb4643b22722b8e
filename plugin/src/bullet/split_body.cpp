// SPDX-License-Identifier: Zlib

// This file gives a living body the network into which its own has separated.

#include "bullet/body_in_world.h"
#include "bullet/point_masses.h"
#include "bullet/surface_body.h"
#include "bullet/tearing.h"

#include <utility>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

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
void takeSprings(SoftBodyData& body, const BodyModel& before, const Origins& springOf) {
  SpringArrays springs = body.model->springs;
  springs.revision = body.springs.revision + 1;
  if (body.springs.yielded) {
    const SpringConstants& old = *body.springs.yielded;
    const std::vector<std::uint32_t>& oldOrder = before.springs.original->division.order;
    std::vector<std::size_t> placeOf(oldOrder.size());
    for (std::size_t i = 0; i < oldOrder.size(); ++i) placeOf[oldOrder[i]] = i;
    springs.yielded = std::make_shared<SpringConstants>(*springs.original);
    const std::vector<std::uint32_t>& order = springs.original->division.order;
    for (std::size_t i = 0; i < order.size(); ++i) {
      const std::size_t from = placeOf[springOf[order[i]]];
      springs.yielded->restLength[i] = old.restLength[from];
      if (isBroken(body.springs, from)) breakSpring(springs, i);
    }
  }
  body.springs = std::move(springs);
  body.volumes = body.model->volumes;
  body.tetrahedra = body.model->tetrahedra;
  forgetConstants(body);
  body.surface.freed = true;
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
  body.contactPartners.clear();
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

}  // namespace

Result<void> takeSplit(SoftBodyData& body, const SplitNetwork& split) {
  SoftBodySettings settings = body.settings;
  auto model = modelOf(body, split.network, settings);
  if (!model) return Error{model.error()};
  readFromBullet(body);
  const std::shared_ptr<const BodyModel> before = std::exchange(body.model, *model);
  body.settings = settings;
  takeSprings(body, *before, split.springOf);
  sharePoints(body, *before, split.pointOf);
  dividePointMasses(body, split.pointOf, before->masses);
  forgetShape(body);
  writeToBullet(body);
  wakeBody(body, false);
  return {};
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

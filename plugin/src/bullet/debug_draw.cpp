// SPDX-License-Identifier: Zlib

// This file draws soft bodies and springs for Bullet's debug drawer.

#include "bullet/bullet_objects.h"
#include "bullet/contact_report.h"
#include "bullet/system_impl.h"

#include <limber/contacts.h>
#include <limber/spring_constraint.h>

#include <LinearMath/btIDebugDraw.h>

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Strain at which the colour saturates.
constexpr double kMaxStrain = 0.1;

/// Size of a pin's cross, in radii of the points.
constexpr double kCrossSize = 2.0;

/// Returns blue for compression, red for extension and grey at rest.
btVector3 colourOf(double strain) {
  const btVector3 rest(btScalar(0.75), btScalar(0.75), btScalar(0.75));
  const btVector3 pressed(btScalar(0.12), btScalar(0.35), btScalar(0.8));
  const btVector3 stretched(btScalar(0.85), btScalar(0.15), btScalar(0.1));
  const double share = std::min(std::abs(strain) / kMaxStrain, 1.0);
  return lerp(rest, strain < 0.0 ? pressed : stretched, static_cast<btScalar>(share));
}

double strainOf(double length, double restLength) {
  return restLength > 0.0 ? length / restLength - 1.0 : length;
}

void drawSprings(const SoftBodyData& body, btIDebugDraw& drawer) {
  const Points& x = body.state.position;
  const SpringArrays& s = body.springs;
  for (std::size_t i = 0; i < s.size(); ++i) {
    if (s->extensionStiffness[i] == 0.0 && s->compressionStiffness[i] == 0.0) continue;
    const Eigen::Vector3d a = x.col(s->a[i]), b = x.col(s->b[i]);
    drawer.drawLine(toBullet(a), toBullet(b), colourOf(strainOf((b - a).norm(), s->restLength[i])));
  }
}

void drawPins(const SoftBodyData& body, btIDebugDraw& drawer) {
  const btScalar size = static_cast<btScalar>(kCrossSize) * body.masses.shape->getRadius();
  for (std::size_t i = 0; i < body.masses.held.size(); ++i) {
    if (!body.masses.held[i]) continue;
    const btVector3 at = toBullet(body.state.position.col(static_cast<Eigen::Index>(i)));
    for (int axis = 0; axis < 3; ++axis) {
      btVector3 arm(0, 0, 0);
      arm[axis] = size;
      drawer.drawLine(at - arm, at + arm, btVector3(1, 1, 0));
    }
  }
}

void drawBox(const SoftBodyData& body, btIDebugDraw& drawer) {
  const Points& x = body.state.position;
  const double radius = double(body.masses.shape->getRadius());
  const Eigen::Vector3d low = x.rowwise().minCoeff().array() - radius;
  const Eigen::Vector3d high = x.rowwise().maxCoeff().array() + radius;
  drawer.drawAabb(toBullet(low), toBullet(high), drawer.getDefaultColors().m_aabb);
}

void drawContacts(SoftBodyData& body, btIDebugDraw& drawer) {
  for (const SoftContact& contact : readReport(body))
    drawer.drawContactPoint(contact.position, contact.normal, static_cast<btScalar>(contact.distance), 0,
                            drawer.getDefaultColors().m_contactPoint);
}

void drawAnchors(const SoftBodyData& body, btIDebugDraw& drawer) {
  for (const Anchor& anchor : body.anchors)
    drawer.drawLine(anchor.body->getCenterOfMassPosition(), anchor.body->getWorldTransform() * anchor.pivot,
                    btVector3(1, 1, 0));
}

bool hasMode(const btIDebugDraw& drawer, int mode) { return (drawer.getDebugMode() & mode) != 0; }

/// Draws the parts of a body that the drawer's modes select: springs coloured by strain and pinned points
/// (wireframe), the bounding box (AABB), contacts (contact points), anchors (constraints).
void debugDraw(SoftBodyData& body, btIDebugDraw& drawer) {
  if (!body.alive) return;
  if (hasMode(drawer, btIDebugDraw::DBG_DrawWireframe)) {
    drawSprings(body, drawer);
    drawPins(body, drawer);
  }
  if (hasMode(drawer, btIDebugDraw::DBG_DrawAabb)) drawBox(body, drawer);
  if (hasMode(drawer, btIDebugDraw::DBG_DrawContactPoints)) drawContacts(body, drawer);
  if (hasMode(drawer, btIDebugDraw::DBG_DrawConstraints)) drawAnchors(body, drawer);
}

/// Draws the springs that were added one by one, in the mode for constraints.
void debugDraw(const SpringList& springs, btIDebugDraw& drawer) {
  if (!hasMode(drawer, btIDebugDraw::DBG_DrawConstraints)) return;
  for (const auto& spring : springs) {
    const double strain = strainOf(double(spring->length()), *spring->settings().restLength);
    drawer.drawLine(SpringConstraint::worldPivot(spring->endA()),
                    SpringConstraint::worldPivot(spring->endB()), colourOf(strain));
  }
}

}  // namespace

void SoftBodySystem::debugDraw(btIDebugDraw& drawer) const { impl_->debugDraw(drawer); }

void SoftBodySystem::Impl::debugDraw(btIDebugDraw& drawer) {
  for (auto& body : bodies) limber::debugDraw(*body->data_, drawer);
  limber::debugDraw(springs, drawer);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

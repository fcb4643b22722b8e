// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/rigid_partner.h"
#include "bullet/soft_body_data.h"
#include "solver/verlet_step.h"

#include <limber/spring_constraint.h>

#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Soft and rigid bodies that springs and anchors join: stepped, put to sleep and woken together. A soft body
/// that nothing is joined to is a group of its own.
struct TickGroup {
  StepGroup step;
  std::vector<SoftBodyData*> bodies;       ///< step.bodies[i] is bodies[i]
  std::vector<RigidPartner> rigids;        ///< step.links.rigids[i] is rigids[i]
  std::vector<SpringConstraint*> springs;  ///< step.links.springs[i] is springs[i]
  double calmTime = 0.0;  ///< s for which nothing in it has moved faster than it may in sleep
  bool asleep = false;
  bool clustered = false;  ///< in this tick it is stepped together with what it touches
  Stepping stepping;       ///< the strictest of its bodies' choices
  int substeps = 0;
  bool cut = false;  ///< the budget allows fewer than it needs
  Stepper stepper = Stepper::Verlet;
  bool guarded = false;      ///< its energy must not rise in this tick if a push is held back in it
  bool heldBack = false;     ///< that is so at the start of the tick
  bool lasting = false;      ///< nor beyond what it was in the first of such ticks
  double energyBound = 0.0;  ///< J, if it is guarded
  double energyAtEnd = 0.0;  ///< J, of the last tick, if it is guarded
};

using SpringList = std::vector<std::unique_ptr<SpringConstraint>>;

/// The groups of these bodies and springs, in the order of their first bodies, then of their first springs.
/// A group is asleep if all its bodies are.
std::vector<TickGroup> makeGroups(const std::vector<SoftBodyData*>& bodies,
                                  const std::vector<SpringConstraint*>& springs);

/// False once a point mass of the group has left the world: the groups must be made anew.
bool isWhole(const TickGroup& group);

/// Looks up which springs and anchors have both ends in the world, and which of these ends are static.
/// Returns whether this is not what `links` says, which is then brought up to date: the groups must be made
/// anew.
bool updateUsableLinks(const std::vector<SoftBodyData*>& bodies, const std::vector<SpringConstraint*>& springs,
                       std::vector<unsigned char>& links);

/// The stages of a tick, see point_masses.h. What a body may touch depends on where all of them are.
void gatherBodies(TickGroup& group, btScalar tick);
void gatherGroup(TickGroup& group, btScalar tick);
void handOverGroup(TickGroup& group, btScalar tick);
void takeBackGroup(TickGroup& group, btScalar tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

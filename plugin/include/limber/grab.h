// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/contacts.h>
#include <limber/export.h>
#include <limber/handle.h>
#include <limber/result.h>
#include <limber/soft_body_system.h>

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct GrabPull;

struct GrabSettings {
  double frequency = 4.0;  ///< Hz, 0.01 to 1000, of the body's mass on the spring, which is critically damped
  double maxForce = 0.0;   ///< N, largest force of the spring, without the damping; 0: no limit. Where it
                           ///< limits the force, the damping is critical for this weaker pull
};

/// Holds a point of a soft body with a spring to a place in the world, for mouse picking and hands.
///
///     limber::Result<limber::Grab> held = limber::grab(soft, limber::surfaceHit(object, triangle, place));
///     held->moveTo(mouse);      // in each frame
///     held->release();          // or destroy it
///
/// The body, the system and the world may be destroyed before it; it then holds nothing. Thread rule: as for
/// SoftBodySystem.
class LIMBER_API Grab {
 public:
  Grab() = default;
  ~Grab() { release(); }
  Grab(Grab&& other) noexcept;
  Grab& operator=(Grab&& other) noexcept;

  /// Moves the place and wakes the body. The springs pull to it in all of the coming ticks: of a place that
  /// moves, give the one in the middle of the tick. With its velocity (m/s) the point does not lag behind a
  /// place that moves evenly, by 2 / (2 pi frequency) seconds. No effect on a place that is not finite.
  void moveTo(const btVector3& place, const btVector3& velocity = btVector3(0, 0, 0));
  void release();

  bool holds() const;           ///< false after release(), or if body or world is gone
  SoftBody* body() const;       ///< nullptr after release(), or if it is gone
  std::uint32_t point() const;  ///< of the body; 0 after release()
  btVector3 force() const;      ///< N on the body, with the damping, at the end of the last tick

 private:
  friend LIMBER_API Result<Grab> grab(SoftBodySystem&, SoftBody*, std::uint32_t, const GrabSettings&);
  friend class SoftBodySystem;
  static void mark(SpringConstraint& spring, const std::shared_ptr<GrabPull>& pull);
  static void aim(GrabPull& pull);                                    // its springs at its place
  static void aimAll(const std::vector<SpringConstraint*>& springs);  // at the start of a tick

  SoftBodySystem* system_ = nullptr;  // exists as long as one of the springs does
  std::shared_ptr<GrabPull> pull_;    // shared with its springs
};

/// Grabs point i of a body, at its present position. Errors: no body of this system, no such point, a pinned
/// point, invalid settings.
LIMBER_API Result<Grab> grab(SoftBodySystem& system, SoftBody* body, std::uint32_t i,
                             const GrabSettings& settings = {});
/// Grabs the point of a body that is nearest to a hit on its surface. Errors: also no hit.
LIMBER_API Result<Grab> grab(SoftBodySystem& system, const SurfaceHit& hit,
                             const GrabSettings& settings = {});

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

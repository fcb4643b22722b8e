// SPDX-License-Identifier: Zlib
#pragma once

// All settings of soft bodies and of single springs.

#include <limber/export.h>
#include <limber/result.h>
#include <limber/spring_network.h>
#include <limber/surroundings.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace limber {

// --- soft bodies -------------------------------------------------------------------------------------------

/// Integrator for the motion of a body within a Bullet tick.
enum class Stepper : std::uint8_t {
  Auto,              ///< the cheapest of the following for the body's stiffness, damping, mesh and tick
  Verlet,            ///< velocity Verlet with the number of substeps that the stiffest spring requires
  ImplicitMidpoint,  ///< local/global iterations with a factorisation shared by all bodies of one network
  Newton             ///< implicit midpoint with Newton's method, for ropes, chains and small bodies
};

/// Time resolution of the springs within one Bullet tick. Every choice is stable. These settings increase the
/// accuracy or limit its cost.
struct Stepping {
  Stepper stepper = Stepper::Auto;
  int minSubsteps = 5;  ///< per tick, 1 to 10000. With 5, the period of an oscillation of 30 ticks has an
                        ///< error below 1e-4; they cost little compared to Bullet's part of the tick. A
                        ///< smaller maxSubsteps counts
  double periodTolerance = 0.04;  ///< largest relative error of the period of the body's stiffest
                                  ///< oscillation (Verlet: (omega dt)^2 / 24), 1e-8 to 1. The error of
                                  ///< slower ones is smaller by the square of the ratio. Half the error
                                  ///< costs 1.41x the substeps
  double tolerance = 0.0;  ///< m per second of motion, of SoftBody::errorPerSecond(), to 1e6; 0: not used
  double relativeTolerance =
      0.0;  ///< the same as a fraction of the body's size per second, to 1e6; 0: not used
  int maxSubsteps =
      0;  ///< per tick, 0 to 10000; 0: 10000. The springs, volume terms and links of a
          ///< body that would need more to be stable are softened to what these substeps resolve, see
          ///< SoftBody::softening(). So the cost is bounded at any stiffness. Bodies that touch
          ///< take the largest number of any of them, linked ones the smallest limit

  double searchDistance =
      0.05;  ///< largest relative displacement of two surfaces between searches for
             ///< their contacts, as a share of the size of their triangles, 0.01 to 0.25.
             ///< Only what moves faster is searched several times per tick. Of two
             ///< bodies the smaller one counts; for a rigid ball that rolls on a body, a tenth

  /// Returns the cheapest settings for those who can bear about 2 % of error in the strain and period of what
  /// one sees: 2 to 10 substeps, a periodTolerance of 0.08 and a searchDistance of 0.25. What 10 substeps do
  /// not resolve is softened: cloths and chains of many points, and very stiff bodies, stretch more than
  /// that.
  LIMBER_API static Stepping fast();
};

/// Behaviour of springs beyond a strain, |length / rest length - 1|, to 1e6. A strain of 0 disables it.
struct ElasticLimit {
  double stiffenStrain = 0.0;   ///< beyond it the spring is stiffenFactor times as stiff (C. Hart's paper,
                                ///< Fig. 5)
  double stiffenFactor = 10.0;  ///< 1 to 1e6
  double yieldStrain = 0.0;     ///< beyond it the rest length changes permanently (perfect plasticity)
  double yieldMaximum = 0.5;    ///< largest permanent strain, 0 to 0.999; there the spring is elastic again
  double breakStrain = 0.0;     ///< a spring longer than at rest is removed permanently beyond this strain
  bool tear = false;            ///< instead, the body tears there: at one end of the spring the point and the
                      ///< triangles, tetrahedra or segments around it part (SoftBody::tears()). The spring
                      ///< goes with one side. Springs that no triangle, tetrahedron or segment has, such as
                      ///< those against bending, are removed. A piece of a single one does not tear
};

#if defined(__GNUC__) && !defined(__clang__)
// GCC warns that a scoped enumerator shadows a type of the same name.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#endif

/// Representation of a soft body in Bullet's world.
enum class Collision : std::uint8_t {
  Points,  ///< each point mass is a sphere body in the world, with Bullet's narrowphase and solver. Only
           ///< these spheres collide, and each costs as much as any rigid body
  Surface  ///< one object represents the whole body (SoftBody::surfaceObject()); the point masses are
           ///< outside the world. Points, edges and triangles collide. Costs Bullet almost nothing while no
           ///< other object is near
};

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

/// Factors for a named group of the network (NamedGroup in spring_network.h). A spring or point of several of
/// these groups gets the product of their factors.
struct GroupSettings {
  std::string name;
  double stiffness = 1.0;    ///< of its springs, 0 to 1e6
  double damping = 1.0;      ///< of its springs, 0 to 1e6
  double limitStrain = 1.0;  ///< of the strains of ElasticLimit, for its springs, 1e-6 to 1e6
  double mass = 1.0;         ///< of its points, 1e-3 to 1e3; comes on top of totalMass
  double restLength =
      1.0;  ///< of its springs, 1e-3 to 1e3: below 1 they pull, as muscles, straps and tight skins do
};

/// All properties of a soft body except its shape. SI units: metres, kilograms, seconds, newtons, radians.
struct SoftBodySettings {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();            ///< m, to 1e6, of the network's origin
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit quaternion
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< per axis, before the rotation; negative values
                                                    ///< mirror; sizes 1e-9 to 1e9 that differ by
                                                    ///< at most a factor of 1000
  Eigen::Vector3d linearVelocity = Eigen::Vector3d::Zero();   ///< m/s, to 1e5
  Eigen::Vector3d angularVelocity = Eigen::Vector3d::Zero();  ///< rad/s, to 1e5, about the centre of mass

  double extensionStiffness = 1000.0;    ///< N/m of each spring while longer than at rest, 0 to 1e12
  double compressionStiffness = 1000.0;  ///< N/m of each spring while shorter than at rest, 0 to 1e12
  double damping = 1.0;                  ///< N s/m along each spring, 0 to 1e12; does not limit the time step
  double totalMass = 1.0;                ///< kg, 1e-9 to 1e12

  std::optional<double> volumeModulus;  ///< Pa, 0 to 1e15, resists changes of the volume inside a closed
                                        ///< surface; default: for each closed piece the combined stiffness
                                        ///< of its springs, 0 for all others (ropes, cloths, open pieces)
  // Gas in closed bodies. At the volume V it pushes outwards with  (p + a) V0 / V - a  per area, by the
  // pressure p, the ambient pressure a and the rest volume V0 (Boyle's law at constant temperature). A free
  // balloon swells until its springs, and its volume modulus unless it is 0, balance that.
  double pressure = 0.0;  ///< Pa, 0 to 1e12, p: gauge pressure, above the ambient one, at the rest volume
  double ambientPressure = 0.0;  ///< Pa, 0 to 1e12, a: outside. 0: the gas alone never balances, so without
                                 ///< springs a balloon swells without end, and it resists compression only
                                 ///< by p. 101325: air at sea level; it ends at  V = V0 (1 + p/a)  at most
                                 ///< and is stiff, like a ball or a tyre. The substeps follow the stiffness

  Collision collision = Collision::Surface;
  bool selfCollision = false;  ///< triangles, or the segments of a rope, also collide with each other,
                               ///< except where they share a point or are nearer at rest than the sum of the
                               ///< radii; needs Surface
  bool hollow = false;  ///< closed surfaces are shells, which keep in what is inside: a bag, a balloon with
                        ///< something in it. false: they are solid, and push out what is a little inside;
                        ///< what is far inside does not touch them. Needs Surface
  std::optional<double> pointRadius;  ///< m, 1e-9 to 1e4, radius of each point mass as a sphere in Bullet;
                                      ///< default: 2 % of the shortest spring
  double friction = 0.5;              ///< 0 to 1e6, Bullet multiplies it with the partner's
  double restitution = 0.0;           ///< 0 to 1, Bullet multiplies it with the partner's
  int collisionGroup = 1;             ///< Bullet's filter group; 1 = btBroadphaseProxy::DefaultFilter
  int collisionMask = -1;             ///< Bullet's filter mask; -1 = btBroadphaseProxy::AllFilter
  bool continuousCollision = true;    ///< also find contacts within a tick that were not predicted at its
                                      ///< start, so that fast objects do not pass through
  double sleepingSpeed = 0.1;  ///< m/s, 0 to 1e6; a body falls asleep when all its points have been slower
                               ///< than this for gDeactivationTime; each faster tick subtracts six ticks
  double gravityFactor = 1.0;  ///< of the world's gravity, -1000 to 1000; 0: weightless. Does not apply to
                               ///< points whose gravity the user has set (BT_DISABLE_WORLD_GRAVITY)
  double maxPinSpeed = 300.0;  ///< m/s, 1e-6 to 1e6; a pin whose target is farther than this allows in a tick
                               ///< gets there in several ticks. teleportPin() has no limit

  std::vector<GroupSettings> groups;  ///< for groups of the network; all others have factors of 1

  FlowCoefficients flow;  ///< drag in air and water

  Stepping stepping;
  ElasticLimit elasticLimit;

  /// Returns the values of C. Hart's paper for its cube with edges of 1 m: k = 20 N/m, damping 0.2 N s/m.
  LIMBER_API static SoftBodySettings paper();
};

/// Checks settings. The error is the first invalid one and the reason ("totalMass is -1, must be from 1e-9 to
/// 1e12"). SoftBodySystem::createBody() also checks the settings together with the network.
LIMBER_API Result<void> validate(const SoftBodySettings& settings);

/// Returns the radius (m) of a body's point masses: the setting, or 2 % of the shortest spring at the body's
/// scale.
LIMBER_API double pointRadius(const SpringNetwork& network, const SoftBodySettings& settings);

// --- single springs ----------------------------------------------------------------------------------------

/// The deformations in which a spring exerts a force.
enum class SpringAction : std::uint8_t {
  Both,
  ExtensionOnly,   ///< a bungee: no force while shorter than its rest length
  CompressionOnly  ///< a bumper: no force while longer than its rest length
};

/// A single spring with a parallel damper.
struct SpringSettings {
  std::optional<double> restLength;  ///< m, 0 to 4e6; default: the distance of the ends when the spring is
                                     ///< added; set in SpringConstraint::settings()
  double stiffness = 1000.0;         ///< N/m, 0 to 1e12
  double damping = 0.0;              ///< N s/m along the spring, 0 to 1e12, only while the spring acts: not
                                     ///< where its stiffness is 0
  SpringAction action = SpringAction::Both;
  double breakForce = 0.0;  ///< N, 0 (never) to 1e18; after a tick that ends with a larger force, pulling or
                            ///< pushing, the spring is broken for good, see SpringConstraint::broken()
};

/// Checks settings. The error is the first invalid one and the reason.
LIMBER_API Result<void> validate(const SpringSettings& settings);

}  // namespace limber

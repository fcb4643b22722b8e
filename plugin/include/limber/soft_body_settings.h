// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <string>

namespace limber {

/// How the motion of a body is advanced within a Bullet tick.
enum class Stepper : std::uint8_t {
  Auto,    ///< whichever of those below is cheapest for the body's stiffness, damping, mesh and tick
  Verlet,  ///< velocity Verlet in as many substeps as the stiffest spring needs
  ImplicitMidpoint,  ///< local/global iterations on a factor that all bodies of one network share
  BandedNewton       ///< implicit midpoint by Newton's method, for ropes and chains
};

/// How finely the springs are stepped within one Bullet tick. Every choice is stable; these settings buy
/// accuracy, or cap what it may cost.
struct Stepping {
  Stepper stepper = Stepper::Auto;
  int minSubsteps = 5;            ///< substeps per tick, 1 or more. 5 keep the period of an oscillation of 30
                                  ///< ticks within 1e-4 and cost little beside Bullet's part of the tick
  double periodTolerance = 0.04;  ///< largest relative error of the period of the body's stiffest oscillation
                                  ///< (Verlet: (omega dt)^2 / 24); slower ones are better by the square of
                                  ///< the ratio. Halving the error costs 1.41x the substeps. 1e-8 to 1
  double tolerance = 0.0;         ///< m per second of motion, of SoftBody::errorPerSecond(); 0: not asked for
  double relativeTolerance = 0.0;  ///< the same as a share of the body's size per second; 0: not asked for
  int maxSubsteps =
      0;  ///< substeps per tick at most, 0: no limit. A body that would need more to be stable is
          ///< stepped implicitly; the error that follows is reported by SoftBody::errorPerSecond()
};

/// What becomes of springs beyond a strain, |length / rest length - 1|. Each is off at 0.
struct ElasticLimit {
  double stiffenStrain = 0.0;   ///< beyond it the spring is stiffenFactor times as stiff (the paper's Fig. 5)
  double stiffenFactor = 10.0;  ///< 1 or more
  double yieldStrain = 0.0;     ///< beyond it the rest length follows, for good (perfect plasticity)
  double yieldMaximum = 0.5;    ///< largest permanent strain, below 1; at it the spring is elastic again
  double breakStrain = 0.0;     ///< beyond it, while longer than at rest, the spring is gone for good
};

#if defined(__GNUC__) && !defined(__clang__)
// GCC takes a scoped enumerator for one that may hide a type of the same name
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#endif

/// How a soft body lives in Bullet's world.
enum class Collision : std::uint8_t {
  Points,  ///< every point mass is a sphere body of the world, which Bullet's narrowphase and solver know;
           ///< only these spheres touch, and they cost Bullet as much as any rigid body
  Surface  ///< one object stands for the whole body (SoftBody::surfaceObject()); the point masses are outside
           ///< the world. Points, edges and triangles touch. Costs Bullet next to nothing while nothing is
           ///< near
};

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

/// Everything a soft body is besides its shape. SI units: metres, kilograms, seconds, newtons, radians.
struct SoftBodySettings {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();            ///< m, of the network's origin
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit quaternion
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();               ///< per axis, before the rotation; negative
                                                                 ///< mirrors, 0 is refused
  Eigen::Vector3d linearVelocity = Eigen::Vector3d::Zero();      ///< m/s
  Eigen::Vector3d angularVelocity = Eigen::Vector3d::Zero();     ///< rad/s, about the centre of mass

  double extensionStiffness = 1000.0;    ///< N/m of each spring while longer than at rest, 0 or more
  double compressionStiffness = 1000.0;  ///< N/m of each spring while shorter than at rest, 0 or more
  double damping = 1.0;                  ///< N s/m along each spring, 0 or more; never limits the time step
  double totalMass = 1.0;                ///< kg, 1e-9 or more

  double volumeModulus = -1.0;  ///< Pa, 0 or more, against changes of the volume inside a closed surface;
                                ///< negative: for each closed piece, as stiff as the body's springs are
                                ///< together; 0 for all others (ropes, cloths, open pieces)
  double pressure = 0.0;        ///< Pa of gas above the outside, at the rest volume; only for closed bodies

  Collision collision = Collision::Surface;
  bool selfCollision = false;  ///< triangles, or a rope's segments, also touch each other, except where they
                               ///< share a point or are nearer at rest than both radii; needs Surface
  double pointRadius = 0.0;  ///< m, of the sphere each point mass is to Bullet; 0: 2 % of the shortest spring
  double friction = 0.5;     ///< Bullet multiplies it with the partner's
  double restitution = 0.0;  ///< 0..1, Bullet multiplies it with the partner's
  int collisionGroup = 1;    ///< Bullet's filter group; 1 = btBroadphaseProxy::DefaultFilter
  int collisionMask = -1;    ///< Bullet's filter mask; -1 = btBroadphaseProxy::AllFilter
  bool continuousCollision = true;  ///< contacts that nobody foresaw at the start of a tick are found within
                                    ///< it, so that what moves fast does not pass through
  double sleepingSpeed =
      0.1;  ///< m/s; a body all of whose points stay slower for gDeactivationTime goes to sleep

  Stepping stepping;
  ElasticLimit elasticLimit;

  /// The values of C. Hart's paper for its cube with edges of 1 m: k = 20 N/m, damping 0.2 N s/m.
  static SoftBodySettings paper();
};

/// The first setting that cannot be used and why ("totalMass is -1, must be from 1e-9 to 1e12"), or an empty
/// string.
std::string validate(const SoftBodySettings& settings);

/// The radius (m) a body's point masses get: the setting, or 2 % of the shortest spring at the body's scale.
double pointRadius(const SpringNetwork& network, const SoftBodySettings& settings);

}  // namespace limber

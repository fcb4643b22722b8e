// SPDX-License-Identifier: Zlib
#include "contact/memory_use.h"

#include "accuracy/bodies.h"
#include "contact/contact_scene.h"
#include "engines/limber_engine.h"
#include "text_format.h"

#include <Eigen/LU>

#include <cstdlib>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace limber::bench {
namespace {

/// Returns the bytes of heap that the program uses.
std::optional<double> heapBytes() {
#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33)
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
#else
  return std::nullopt;
#endif
}

constexpr double kLatticeSpacing = 1.0;                   // m: the broadphase sees no pairs
constexpr double kBondReach = 1.1, kDiagonalReach = 1.5;  // spacings: 6 or 18 neighbours

/// Returns side^3 points, with springs to the neighbours within `reach` spacings.
SharedNetwork lattice(int side, double reach) {
  auto network = std::make_shared<SpringNetwork>(*latticeNetwork(side, side, side, kLatticeSpacing));
  std::vector<NetworkSpring> springs;
  for (const NetworkSpring& s : network->springs)
    if ((network->restPoints[s.a] - network->restPoints[s.b]).norm() < kLatticeSpacing * reach)
      springs.push_back(s);
  network->springs = springs;
  return network;
}

/// Returns the bytes of each of `count` bodies of a network.
double bytesOfBody(const SharedNetwork& network, int count) {
  const auto engine = makeLimberEngine();
  BodySetup body = bodyOf(network, 1.0, 100.0, 1.0);
  engine->addBody(body);
  for (int i = 0; i < 4; ++i) engine->tick(kContactTick);
  const double before = *heapBytes();
  for (int i = 0; i < count; ++i) {
    body.settings.position.x() += 10.0 * kLatticeSpacing;
    engine->addBody(body);
  }
  for (int i = 0; i < 4; ++i) engine->tick(kContactTick);
  return (*heapBytes() - before) / count;
}

}  // namespace

std::optional<MemoryUse> measureMemory(bool quick) {
  if (!heapBytes()) return std::nullopt;
  const int count = quick ? 4 : 32;
  Eigen::Matrix3d counts;  // points, springs and 1 of three bodies
  Eigen::Vector3d bytes;
  const SharedNetwork networks[] = {lattice(4, kBondReach), lattice(4, kDiagonalReach),
                                    lattice(7, kBondReach)};
  for (int i = 0; i < 3; ++i) {
    counts.row(i) << double(networks[i]->restPoints.size()), double(networks[i]->springs.size()), 1.0;
    bytes[i] = bytesOfBody(networks[i], count);
  }
  const Eigen::Vector3d use = counts.inverse() * bytes;
  return MemoryUse{use[0], use[1], use[2], double(sizeof(NetworkSpring))};
}

std::string describe(const std::optional<MemoryUse>& use) {
  if (!use) return "memory: not known on this system\n";
  return format(
      "memory of Limber: %.0f bytes a point (and %zu for Bullet's rigid body, once SoftBody::point() is "
      "called), %.0f a spring, "
      "%.0f a body;\nthe network that bodies of one shape share: %.0f a spring\n",
      use->perPoint, sizeof(btRigidBody), use->perSpring, use->perBody, use->networkPerSpring);
}

}  // namespace limber::bench

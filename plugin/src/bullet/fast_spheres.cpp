// SPDX-License-Identifier: Zlib
#include <limber/fast_spheres.h>

#include <BulletCollision/CollisionDispatch/btSphereBoxCollisionAlgorithm.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Which of the two objects is the sphere.
btSphereBoxCollisionAlgorithm::CreateFunc makeCreateFunction(bool swapped) {
  btSphereBoxCollisionAlgorithm::CreateFunc create;
  create.m_swapped = swapped;
  return create;
}

}  // namespace

void useFastSphereAlgorithms(btCollisionDispatcher& dispatcher) {
  // a dispatcher keeps pointers only, and may live as long as the program; they are never changed
  static btSphereBoxCollisionAlgorithm::CreateFunc sphereBox = makeCreateFunction(false),
                                                   boxSphere = makeCreateFunction(true);
  dispatcher.registerCollisionCreateFunc(SPHERE_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, &sphereBox);
  dispatcher.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, SPHERE_SHAPE_PROXYTYPE, &boxSphere);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

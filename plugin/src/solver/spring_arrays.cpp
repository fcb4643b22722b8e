// SPDX-License-Identifier: Zlib
#include "solver/spring_arrays.h"

#include "solver/spring_order.h"

#include <algorithm>

namespace limber {

SpringArrays makeSprings(const SpringNetwork& network, const SoftBodySettings& settings) {
  SpringArrays s;
  for (const std::uint32_t i : orderApart(network)) {
    const NetworkSpring& spring = network.springs[i];
    const Eigen::Vector3d d = network.restPoints[spring.b] - network.restPoints[spring.a];
    s.a.push_back(spring.a);
    s.b.push_back(spring.b);
    s.restLength.push_back(d.cwiseProduct(settings.scale).norm());
    s.extensionStiffness.push_back(settings.extensionStiffness * spring.stiffnessScale);
    s.compressionStiffness.push_back(settings.compressionStiffness * spring.stiffnessScale);
    s.damping.push_back(settings.damping * spring.stiffnessScale);
  }
  for (const double length : s.restLength)
    if (length > 0.0) s.shortest = s.shortest > 0.0 ? std::min(s.shortest, length) : length;
  const ElasticLimit& limit = settings.elasticLimit;
  s.limit = limit;
  s.limited = limit.stiffenStrain > 0.0 || limit.yieldStrain > 0.0 || limit.breakStrain > 0.0;
  if (s.limited) s.originalLength = s.restLength;
  s.damped = settings.damping > 0.0;
  s.direction.setZero(3, static_cast<Eigen::Index>(s.size()));
  s.dampHalf.assign(s.size(), 0.0);
  s.dampFull.assign(s.size(), 0.0);
  return s;
}

}  // namespace limber

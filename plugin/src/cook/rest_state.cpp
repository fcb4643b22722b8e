// SPDX-License-Identifier: Zlib
#include "cook/rest_state.h"

namespace limber {

PointState restState(const SpringNetwork& network, const SoftBodySettings& settings) {
  PointState state;
  state.resize(static_cast<Eigen::Index>(network.restPoints.size()));
  for (std::size_t i = 0; i < network.restPoints.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    state.position.col(column) = network.restPoints[i].cwiseProduct(settings.scale);
    state.inverseMass.col(column).setConstant(1.0 / (settings.totalMass * network.massShares[i]));
  }
  return state;
}

}  // namespace limber

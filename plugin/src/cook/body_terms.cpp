// SPDX-License-Identifier: Zlib
#include "cook/body_terms.h"

#include "solver/stepping_choice.h"

namespace limber {

BodyTerms::BodyTerms(const SpringNetwork& network, const SoftBodySettings& settings)
    : springs(makeSprings(network, settings)),
      volumes(makeVolumes(network, settings)),
      tetrahedra(makeTetrahedronVolumes(network, settings)) {}

SteppedBody steppedBody(BodyTerms& terms, PointState& state) {
  SteppedBody body{&state, &terms.springs, nullptr};
  if (!terms.volumes.empty()) body.volumes = &terms.volumes;
  if (!terms.tetrahedra.empty()) body.tetrahedra = &terms.tetrahedra;
  return body;
}

double volumeBoundSquared(BodyTerms& terms, const PointState& state, double time) {
  return volumeFrequencyBoundSquared(terms.volumes, state, time) +
         tetrahedronFrequencyBoundSquared(terms.tetrahedra, state);
}

double boundSquared(BodyTerms& terms, const PointState& state) {
  std::vector<double> sums;
  return frequencyBoundSquared(terms.springs, state.inverseMass, sums) +
         volumeBoundSquared(terms, state, 0.0);
}

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/elastic_moduli.h"
#include "solver/linear_algebra.h"

namespace limber {

/// Small displacements of a body under forces, about its rest shape.
class LinearResponse {
 public:
  explicit LinearResponse(const ElasticBody& body);

  /// 3 #points x #loads, m, for forces (N) in the same order: x, y, z of each point. The forces of each load
  /// must have neither sum nor torque on any part of the body.
  Eigen::MatrixXd displacements(const Eigen::MatrixXd& forces) const;

  const Eigen::MatrixXd& points() const { return points_; }  ///< 3 x #points, m, at the body's scale

 private:
  Eigen::MatrixXd points_;
  SparseFactor factor_;
  Eigen::MatrixXd volumeGradient_;  ///< 3 #points x 1, m^2, times the root of modulus over volume; or empty
  Eigen::MatrixXd volumeAnswer_;    ///< the displacements that it alone causes
};

}  // namespace limber

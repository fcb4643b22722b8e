// SPDX-License-Identifier: Zlib
// Fits spring constants to the response of a solid body.

#include "network/response_fit.h"

#include "mesh/linear_algebra.h"
#include "network/material.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Weight of the change of the constants relative to the misfit of the compliance.
constexpr double kChangeWeight = 0.1;

/// Largest number of trial steps, and the weighted relative error of a compliance that is small enough.
constexpr int kMaxTrials = 12;
constexpr double kSufficientError = 0.015;

/// A step that lessens the objective by a smaller fraction is the last one.
constexpr double kMinProgress = 0.01;

/// Damping of the first step, relative to kChangeWeight, and its factors after a good and a bad step.
constexpr double kFirstDamping = 20.0, kLessDamping = 0.5, kMoreDamping = 3.0, kMaxDamping = 1e4;

/// Limits of the conjugate gradients: number, and the fraction of the first residual's square.
constexpr int kMaxGradients = 30;
constexpr double kGradientTolerance = 1e-4;

struct Responder {
  SpringNetwork& network;
  const SolidResponses& wanted;
  VectorXd start, shares;      ///< #springs: log k0; kChangeWeight times the share of the sum of k L^2
  VectorXd smallest, largest;  ///< #springs, limits of log k
};

/// A trial: logarithms of the constants, and what follows from them.
struct Trial {
  VectorXd logs;           ///< #springs
  MatrixXd displacements;  ///< 3 #points x #loads
  MatrixXd misfit;         ///< #loads x #loads, weighted
  double objective = 0.0;
};

double squaredLength(const SpringNetwork& network, const NetworkSpring& s) {
  return (network.restPoints[s.b] - network.restPoints[s.a]).squaredNorm();
}

Responder makeResponder(SpringNetwork& network, const SolidResponses& wanted, const SpringLimits& limits) {
  const auto count = static_cast<Index>(network.springs.size());
  Responder r{network, wanted, VectorXd(count), VectorXd(count), VectorXd(count), VectorXd(count)};
  for (Index i = 0; i < count; ++i) {
    const NetworkSpring& s = network.springs[std::size_t(i)];
    r.start[i] = std::log(s.stiffnessScale);
    r.shares[i] = s.stiffnessScale * squaredLength(network, s);
    r.smallest[i] = std::log(limits.smallest[std::size_t(i)]);
    r.largest[i] = std::log(limits.largest[std::size_t(i)]);
  }
  r.shares *= kChangeWeight / r.shares.sum();
  return r;
}

/// Sets the springs and measures the response.
Trial respond(const Responder& r, VectorXd logs) {
  for (Index i = 0; i < logs.size(); ++i)
    r.network.springs[std::size_t(i)].stiffnessScale = std::exp(logs[i]);
  Trial trial{std::move(logs), LinearResponse({r.network}).displacements(r.wanted.loads), {}, 0.0};
  const MatrixXd compliance = transposedProduct(r.wanted.loads, trial.displacements);
  trial.misfit = (compliance - r.wanted.compliance).cwiseProduct(r.wanted.weights);
  trial.objective = trial.misfit.squaredNorm() + r.shares.dot((trial.logs - r.start).cwiseAbs2());
  return trial;
}

/// Returns the springs' extensions under the loads times the root of the constant, #springs x #loads.
MatrixXd weightedExtensions(const Responder& r, const MatrixXd& displacements) {
  MatrixXd extensions(r.start.size(), displacements.cols());
  for (Index i = 0; i < extensions.rows(); ++i) {
    const NetworkSpring& s = r.network.springs[std::size_t(i)];
    const Eigen::Vector3d along = (r.network.restPoints[s.b] - r.network.restPoints[s.a]).normalized();
    extensions.row(i) =
        std::sqrt(s.stiffnessScale) * along.transpose() *
        (displacements.middleRows<3>(3 * Index(s.b)) - displacements.middleRows<3>(3 * Index(s.a)));
  }
  return extensions;
}

/// The derivative of the weighted misfit with respect to the logarithms of the constants.
struct Derivative {
  MatrixXd extensions;      ///< #springs x #loads, see weightedExtensions()
  const MatrixXd& weights;  ///< #loads x #loads

  MatrixXd times(const VectorXd& change) const {
    const MatrixXd scaled = change.asDiagonal() * extensions;
    return -transposedProduct(extensions, scaled).cwiseProduct(weights);
  }
  VectorXd transposedTimes(const MatrixXd& misfit) const {
    const MatrixXd weighted = misfit.cwiseProduct(weights);
    return -extensions.cwiseProduct(product(extensions, weighted)).rowwise().sum();
  }
};

/// Returns 1 for springs that may follow the gradient, 0 for those that are held by a limit.
VectorXd freeSprings(const Responder& r, const VectorXd& logs, const VectorXd& gradient) {
  VectorXd isFree = VectorXd::Ones(logs.size());
  for (Index i = 0; i < logs.size(); ++i)
    if ((logs[i] <= r.smallest[i] && gradient[i] > 0.0) || (logs[i] >= r.largest[i] && gradient[i] < 0.0))
      isFree[i] = 0.0;
  return isFree;
}

/// Solves  (J^T J + diagonal) step = right  for the free springs by conjugate gradients.
VectorXd solveStep(const Derivative& derivative, const VectorXd& diagonal, const VectorXd& isFree,
                   const VectorXd& right) {
  VectorXd step = VectorXd::Zero(right.size()), residual = right,
           direction = residual.cwiseQuotient(diagonal);
  double squared = residual.dot(direction);
  const double sufficient = kGradientTolerance * squared;
  for (int i = 0; i < kMaxGradients && squared > sufficient; ++i) {
    const VectorXd image = isFree.cwiseProduct(derivative.transposedTimes(derivative.times(direction))) +
                           diagonal.cwiseProduct(direction);
    const double length = squared / direction.dot(image);
    step += length * direction;
    residual -= length * image;
    const VectorXd preconditioned = residual.cwiseQuotient(diagonal);
    const double next = residual.dot(preconditioned);
    direction = preconditioned + next / squared * direction;
    squared = next;
  }
  return step;
}

}  // namespace

void fitResponses(SpringNetwork& network, const SolidResponses& wanted, const SpringLimits& limits,
                  const std::function<bool(double)>& goOn) {
  const Responder r = makeResponder(network, wanted, limits);
  Trial best = respond(r, r.start.cwiseMax(r.smallest).cwiseMin(r.largest));
  const double sufficient = kSufficientError * kSufficientError * wanted.weights.diagonal().squaredNorm();
  double damping = kFirstDamping;
  bool hasNewDerivative = true;
  Derivative derivative{{}, wanted.weights};
  VectorXd gradient, isFree;
  for (int i = 0; i < kMaxTrials && damping < kMaxDamping && best.misfit.squaredNorm() > sufficient; ++i) {
    if (goOn && !goOn(static_cast<double>(i) / kMaxTrials)) break;
    if (hasNewDerivative) {
      derivative.extensions = weightedExtensions(r, best.displacements);
      gradient = derivative.transposedTimes(best.misfit) + r.shares.cwiseProduct(best.logs - r.start);
      isFree = freeSprings(r, best.logs, gradient);
    }
    const VectorXd step =
        solveStep(derivative, (1.0 + damping) * r.shares, isFree, -gradient.cwiseProduct(isFree));
    Trial trial = respond(r, (best.logs + step).cwiseMax(r.smallest).cwiseMin(r.largest));
    hasNewDerivative = trial.objective < best.objective;
    damping *= hasNewDerivative ? kLessDamping : kMoreDamping;
    if (!hasNewDerivative) continue;
    const bool isLast = trial.objective > (1.0 - kMinProgress) * best.objective;
    best = std::move(trial);
    if (isLast) break;
  }
  for (Index i = 0; i < best.logs.size(); ++i)
    network.springs[std::size_t(i)].stiffnessScale = std::exp(best.logs[i]);
}

}  // namespace limber

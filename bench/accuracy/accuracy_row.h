// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

namespace limber::bench {

/// One error of one engine in one scene, with one length of the ticks.
struct AccuracyRow {
  std::string scene, engine, setting;
  double dt = 0.0;                ///< s
  double error = 0.0;             ///< infinite: the points are lost
  double tickMicroseconds = 0.0;  ///< median, for the whole world
  double stepMicroseconds = 0.0;  ///< median, for the springs; in other engines for the whole tick
  std::uint64_t hash = 0;         ///< of the final state
  double noise = 0.0;             ///< us; half of the ticks deviate less than this from the median
  Kind kind = Kind::Free;
  std::string measure;   ///< name of the error
  int substeps = 1;      ///< multiple of the stable number of substeps, in Limber's finer runs
  bool ordered = false;  ///< errors should shrink with the step
};

std::vector<std::string> accuracyColumns();
std::vector<std::string> accuracyCells(const AccuracyRow& row);

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

namespace limber::bench {

/// One error of one engine in one scene at one tick.
struct AccuracyRow {
  std::string scene, engine, setting;
  double dt = 0.0;                ///< s
  double error = 0.0;             ///< infinite: it has flown apart
  double tickMicroseconds = 0.0;  ///< the whole world's, median
  double stepMicroseconds = 0.0;  ///< the springs', median; of other engines the whole tick
  std::uint64_t hash = 0;         ///< of the final state
  double noise = 0.0;             ///< us, half the ticks are nearer to the median than this
  Kind kind = Kind::Free;
  std::string measure;   ///< what the error is of
  int substeps = 1;      ///< times the stable number, where Limber is asked for finer ones
  bool ordered = false;  ///< errors should shrink with the step
};

std::vector<std::string> accuracyColumns();
std::vector<std::string> accuracyCells(const AccuracyRow& row);

}  // namespace limber::bench

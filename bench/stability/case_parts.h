// SPDX-License-Identifier: Zlib
#pragma once

#include "stability/hard_case.h"

#include <random>

namespace limber::bench {

/// Numbers that are the same with every standard library.
class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double within(double reach);  ///< -reach to reach
  Eigen::Vector3d vector(double reach);
  Eigen::Matrix3Xd vectors(Eigen::Index count, double reach);
  Eigen::Quaterniond rotation();
  Eigen::Vector3d direction();

 private:
  std::mt19937 engine_;
};

/// The fully connected cube of 28 springs with edges of `size`; `damping` as a share of the critical damping
/// of a single spring between two of its points, 2 sqrt(k m / 2).
BodySetup hardCube(double stiffness, double damping, double size = 1.0, double mass = 1.0);

/// Rest positions where the settings put them.
Eigen::Matrix3Xd restPositions(const BodySetup& body);

/// s in which the cube's slowest oscillation fades to some 1e-4 or less.
///
/// With springs of k and dampers of c in the same places, a mode of frequency w fades at the rate
/// c w^2 / (2 k) if that is below w, else as slowly as k / c. The slowest w of the cube is not below
/// sqrt(k / m) of a single spring and point; ten of the longer time constant.
double settleTime(const BodySetup& cube);

/// A case with this one cube.
HardCase caseOf(const std::string& group, const std::string& name, unsigned seed, const BodySetup& cube);

/// Sets the case free: a slow flight, a tenth of a size per second, through nothing.
void setFree(HardCase& hard, Dice& dice);

/// Asks for the rest shape, and gives the time for it; engines without dampers along the springs get a drag
/// that fades e^-20 in that time.
void letSettle(HardCase& hard);

/// With gravity, for so many seconds, and no more drag than falling bears.
void letFall(HardCase& hard, double seconds);

std::string exponentName(const char* what, double value);  ///< "k 1e+04"

}  // namespace limber::bench

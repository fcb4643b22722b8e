// SPDX-License-Identifier: Zlib
#pragma once

#include "contact/contact_scene.h"

namespace limber::bench {

/// An engine of this bench with its name.
struct ContactEngine {
  std::string name;  ///< "btSoftBody 4 it"
  std::function<std::unique_ptr<Engine>(const ContactScene&)> make;
  bool isReference = false;  ///< times are reported relative to this engine's
  bool isSpheres = false;    ///< loose spheres; times are also reported relative to theirs
  bool sleeps = true;        ///< its bodies can fall asleep
  bool isBudget = false;     ///< Limber with a limited number of substeps
  bool isOther = true;       ///< neither Limber nor loose spheres
};

/// Returns Limber with each of its kinds of collision, and within budgets of substeps; btSoftBody with 1, 4
/// (the reference) and 10 iterations; btDeformable; loose spheres.
///
/// btSoftBody's flags are the cheapest ones without loss, as measured by contactFlags() (4 iterations, times
/// relative to SDF_RS | VF_SS, depth in the pile as a share of a body's size):
///
///                   512 cubes at rest   cloth   dense body   pile of 200, and how deep
///   SDF_RS                0.97          0.81       0.97       0.20   50 %: nothing holds them apart
///   SDF_RS | VF_SS        1             1          1          1      47 %
///   SDF_RS | CL_SS        1.9           0.82       0.98       4.4    42 %
///   CL_RS | CL_SS         3.7           0.67       1.06       4.5    23 %
///
/// SDF_RS is used where bodies do not touch each other, and SDF_RS | VF_SS in the pile. With CL_RS the cloth
/// is cheaper, but slips off the ball.
std::vector<ContactEngine> contactEngines();

/// Returns Limber's names among them.
std::vector<std::string> limberNames();

/// Returns btSoftBody with 4 iterations and each kind of contacts.
std::vector<ContactEngine> contactFlags();

}  // namespace limber::bench

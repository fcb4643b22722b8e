// SPDX-License-Identifier: Zlib
#pragma once

#include "contact/contact_scene.h"

namespace limber::bench {

/// An engine of this bench, under one name.
struct ContactEngine {
  std::string name;  ///< "btSoftBody 4 it"
  std::function<std::unique_ptr<Engine>(const ContactScene&)> make;
  bool isReference = false;  ///< times are told relative to its
  bool isSpheres = false;    ///< loose spheres, which times are told relative to as well
  bool sleeps = true;        ///< its bodies can fall asleep
  bool isOther = true;       ///< neither Limber nor loose spheres
};

/// Limber with each of its kinds of collision; btSoftBody with 1, 4 (the reference) and 10 iterations;
/// btDeformable; loose spheres.
///
/// btSoftBody's flags are those that cost it least without loss, as contactFlags() measures them (4
/// iterations, times over those of SDF_RS | VF_SS, depth in the pile as a share of a body's size):
///
///                   512 cubes at rest   cloth   dense body   pile of 200, and how deep
///   SDF_RS                0.97          0.81       0.97       0.20   50 %: nothing holds them apart
///   SDF_RS | VF_SS        1             1          1          1      47 %
///   SDF_RS | CL_SS        1.9           0.82       0.98       4.4    42 %
///   CL_RS | CL_SS         3.7           0.67       1.06       4.5    23 %
///
/// SDF_RS where bodies do not meet, and SDF_RS | VF_SS in the pile. With CL_RS the cloth is cheaper, but
/// slips off the ball.
std::vector<ContactEngine> contactEngines();

/// Limber's names among them.
std::vector<std::string> limberNames();

/// btSoftBody with 4 iterations and each kind of contacts.
std::vector<ContactEngine> contactFlags();

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#include "stability/hard_case.h"

namespace limber::bench {

std::vector<HardCase> allHardCases(bool quick) {
  std::vector<HardCase> cases;
  addFreeCases(cases, quick);
  addShapeCases(cases, quick);
  addContactCases(cases, quick);
  addRestCases(cases, quick);
  return cases;
}

}  // namespace limber::bench

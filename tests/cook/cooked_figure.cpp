// SPDX-License-Identifier: Zlib
#include "cook/cooked_figure.h"

#include "support/test_shapes.h"

namespace limber::test {

const CookedMesh& cookedFigure() {
  static const CookedMesh cooked = *cook(test_shapes::figure());
  return cooked;
}

}  // namespace limber::test

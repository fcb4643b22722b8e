// SPDX-License-Identifier: Zlib
#pragma once

#include "core/contact_rows.h"
#include "core/verlet_kernel.h"

#include <vector>

namespace limber {

/// A body's contacts as the kernels call them. `points` must hold the state of the start of the tick by the
/// time calls() is called.
struct BodyContacts {
  std::vector<ContactRow>* rows;  ///< may be nullptr
  PointView points;

  kernel::ContactCalls calls() {
    const bool touches = rows && !rows->empty();
    if (touches) prepareContacts(*rows, points);
    return {touches ? this : nullptr, &BodyContacts::stop, &BodyContacts::settle};
  }

 private:
  static void stop(void* context, double time, double dt) {
    auto& self = *static_cast<BodyContacts*>(context);
    stopAtContacts(*self.rows, self.points, time, dt);
  }
  static void settle(void* context) {
    auto& self = *static_cast<BodyContacts*>(context);
    settleContacts(*self.rows, self.points);
  }
};

}  // namespace limber

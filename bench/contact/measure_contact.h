// SPDX-License-Identifier: Zlib
#pragma once

#include "contact/contact_engines.h"
#include "contact/contact_row.h"
#include "row_progress.h"

namespace limber::bench {

struct ContactLimits {
  int repeats = 3;
  double timeLimit = 120.0;  ///< s of the thread for one engine and repeat; slower engines are given up
};

/// Returns a row for each engine, in their order. All engines are open at once and take turns in an order
/// that rotates with each turn and each repeat. The medians of the repeats are reported.
std::vector<ContactRow> measureContact(const ContactScene& scene, const std::vector<ContactEngine>& engines,
                                       const ContactLimits& limits, RowProgress& progress);

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#pragma once

#include "contact/contact_engines.h"
#include "contact/contact_row.h"
#include "row_progress.h"

namespace limber::bench {

struct ContactLimits {
  int repeats = 3;
  double timeLimit = 120.0;  ///< of the thread, of an engine in one repeat of a scene, then it is given up
};

/// A row for each engine, in their order. All of them are open at once and take turns, in an order that
/// rotates with each turn and each repeat; the medians of the repeats count.
std::vector<ContactRow> measureContact(const ContactScene& scene, const std::vector<ContactEngine>& engines,
                                       const ContactLimits& limits, RowProgress& progress);

}  // namespace limber::bench

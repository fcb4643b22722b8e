// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/surface_contacts.h"

namespace limber {

/// The contacts of two surfaces as a search has found them, and where the surfaces were then.
struct KeptContacts {
  std::vector<SurfaceContact> contacts;
  Points a, b;                                                       ///< m, positions at the search
  const SurfaceTopology *topologyA = nullptr, *topologyB = nullptr;  ///< nullptr: nothing is kept
};

/// Whether a search with the same margin would find the same places again: no point has moved by more than a
/// small share of the margin since, and what was farther apart than the margin does not meet in this tick,
/// common motion apart. Then their weights, normals and gaps are made those of now; else the contacts are to
/// be searched for. Boxes need not be fitted.
bool refreshContacts(const MovingSurface& a, const MovingSurface& b, double margin, KeptContacts& kept);

/// Keeps what a search has just found.
void keepContacts(const MovingSurface& a, const MovingSurface& b, const std::vector<SurfaceContact>& found,
                  KeptContacts& kept);

}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "collide/surface_contacts.h"

#include "collide/contact_reduction.h"
#include "collide/inside_vertices.h"
#include "collide/near_features.h"

namespace limber {
namespace {

void searchNear(const SurfacePair& pair, ContactSearch& search, std::vector<SurfaceContact>& found) {
  search.candidates.clear();
  search.behind.clear();
  meetNearFeatures(pair, search);
  addInsideVertices(pair, search);
  reduceContacts(search.candidates, found);
}

}  // namespace

void findSurfaceContacts(const MovingSurface& a, const MovingSurface& b, double margin, ContactSearch& search,
                         std::vector<SurfaceContact>& found) {
  findNearLeaves(a, b, margin, search.waiting, search.near);
  searchNear({a, b, margin, false, 0.0}, search, found);
}

void findSelfContacts(const MovingSurface& surface, double margin, ContactSearch& search,
                      std::vector<SurfaceContact>& found, double farther) {
  findNearLeaves(surface, margin + farther, search.waiting, search.near);
  searchNear({surface, surface, margin + farther, true, farther}, search, found);
}

}  // namespace limber

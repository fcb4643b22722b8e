// SPDX-License-Identifier: Zlib
#include "collide/contact_reduction.h"

#include "collide/contact_candidates.h"

#include <algorithm>
#include <tuple>

namespace limber {
namespace {

/// Cosine of the angle between directions that are the same.
constexpr double kSameDirection = 0.995;
/// Share of the features' size within which places are the same.
constexpr double kOneSpot = 1e-3;

using Candidates = std::vector<ContactCandidate>;

bool haveSameDirection(const ContactCandidate& x, const ContactCandidate& y) {
  return x.contact.normal.dot(y.contact.normal) > kSameDirection;
}

template <class Order>
void sortBy(Candidates& candidates, Order&& order) {
  std::sort(candidates.begin(), candidates.end(),
            [&](const ContactCandidate& x, const ContactCandidate& y) { return order(x) < order(y); });
}

void eraseDropped(Candidates& candidates) {
  const auto dropped = [](const ContactCandidate& x) { return x.dropped; };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), dropped), candidates.end());
}

/// Two vertices are each other's contact only where neither has another in that direction.
void reduceVertexPairs(Candidates& candidates) {
  for (ContactCandidate& x : candidates) {
    if (x.vertex != kNoVertex || x.rank != kVertexVertex) continue;
    const std::uint64_t a = std::uint64_t{x.contact.a.feature} * 2, b = std::uint64_t{x.contact.b.feature} * 2 + 1;
    x.dropped = std::any_of(candidates.begin(), candidates.end(), [&](const ContactCandidate& y) {
      return (y.vertex == a || y.vertex == b) && !y.dropped && haveSameDirection(x, y);
    });
  }
}

/// Of each vertex and direction only the contact that comes first stays.
void reduceVertices(Candidates& candidates) {
  sortBy(candidates, [](const ContactCandidate& x) {
    return std::make_tuple(x.vertex, x.contact.time, x.contact.gap, x.contact.key);
  });
  for (std::size_t first = 0, i = 0; i < candidates.size(); ++i) {
    if (candidates[i].vertex == kNoVertex) break;
    if (candidates[i].vertex != candidates[first].vertex) first = i;
    for (std::size_t j = first; j < i && !candidates[i].dropped; ++j)
      candidates[i].dropped = !candidates[j].dropped && haveSameDirection(candidates[i], candidates[j]);
  }
  reduceVertexPairs(candidates);
  eraseDropped(candidates);
}

bool haveSamePlace(const ContactCandidate& x, const ContactCandidate& y) {
  const double near = kOneSpot * std::min(x.scale, y.scale);
  return (x.place - y.place).squaredNorm() <= near * near;
}

/// Sweeps along x.
void reducePlaces(Candidates& candidates) {
  sortBy(candidates, [](const ContactCandidate& x) { return std::make_tuple(x.place.x(), x.contact.key); });
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    ContactCandidate& x = candidates[i];
    const double end = x.place.x() + kOneSpot * x.scale;
    for (std::size_t j = i + 1; j < candidates.size() && candidates[j].place.x() <= end; ++j) {
      ContactCandidate& y = candidates[j];
      if (x.dropped || y.dropped || !haveSamePlace(x, y) || !haveSameDirection(x, y)) continue;
      (x.contact.key <= y.contact.key ? y : x).dropped = true;
    }
  }
  eraseDropped(candidates);
}

}  // namespace

void reduceContacts(Candidates& candidates, std::vector<SurfaceContact>& found) {
  reduceVertices(candidates);
  reducePlaces(candidates);
  sortBy(candidates, [](const ContactCandidate& x) { return x.contact.key; });
  found.clear();
  for (const ContactCandidate& x : candidates) found.push_back(x.contact);
}

}  // namespace limber

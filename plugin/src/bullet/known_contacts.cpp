// SPDX-License-Identifier: Zlib
#include "bullet/known_contacts.h"

#include <algorithm>
#include <utility>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Id = std::pair<int, std::uint64_t>;

Id idOf(const KnownContact& known) { return {known.partner, known.key}; }

Id idOf(const ContactSource& source) { return {source.partner.id, source.key}; }

}  // namespace

void guessBearings(TickContacts& contacts) {
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    const ContactSource& source = contacts.sources[i];
    if (!source.body) continue;
    const Id id = idOf(source);
    const std::vector<KnownContact>& known = source.body->knownContacts;
    const auto it = std::lower_bound(known.begin(), known.end(), id,
                                     [](const KnownContact& k, const Id& other) { return idOf(k) < other; });
    if (it != known.end() && idOf(*it) == id && it->object == source.partner.object)
      contacts.contacts[i].stopping = it->bearing;
  }
}

void rememberBearings(const std::vector<SoftBodyData*>& bodies, const TickContacts& contacts) {
  for (SoftBodyData* body : bodies) body->knownContacts.clear();
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    const ContactSource& source = contacts.sources[i];
    if (!source.body) continue;
    const PairContact& c = contacts.contacts[i];
    // with the normal that it began with, as the next tick's search finds it: what it bore may have turned away
    const double along = c.normal.dot(c.impulse.sum);
    const Id id = idOf(source);
    source.body->knownContacts.push_back(
        {id.first, source.partner.object, id.second, {along, c.impulse.sum - along * c.normal}});
  }
  const auto before = [](const KnownContact& k, const KnownContact& l) { return idOf(k) < idOf(l); };
  for (SoftBodyData* body : bodies) std::sort(body->knownContacts.begin(), body->knownContacts.end(), before);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

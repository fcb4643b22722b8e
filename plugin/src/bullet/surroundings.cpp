// SPDX-License-Identifier: Zlib

// This file is what users of a SoftBodySystem set around its bodies.

#include "bullet/body_in_world.h"
#include "bullet/body_medium.h"
#include "bullet/system_impl.h"

#include <algorithm>
#include <utility>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

void SoftBodySystem::Impl::wakeAll() {
  for (auto& body : bodies) body->wake();
}

void SoftBodySystem::Impl::dropFields(const SoftBodyData& body) {
  auto& fields = surroundings.fields;
  const auto actsOnIt = [&](const ActingField& field) { return field.body == &body; };
  fields.erase(std::remove_if(fields.begin(), fields.end(), actsOnIt), fields.end());
}

Result<void> SoftBodySystem::setAir(const Air& air) {
  if (Result<void> valid = validate(air); !valid) return Error{"air: " + valid.error()};
  Air& present = impl_->surroundings.air;
  const bool changes =
      air.windAt || present.windAt || air.density != present.density || air.wind != present.wind;
  // bodies without drag may have some in the other air
  const auto wakeIfBlown = [&] {
    for (auto& body : impl_->bodies)
      if (changes && hasDragInAir(*body->data_)) body->wake();
  };
  wakeIfBlown();
  present = air;
  wakeIfBlown();
  return {};
}

Result<void> SoftBodySystem::setWater(const std::optional<Water>& water) {
  if (water)
    if (Result<void> valid = validate(*water); !valid) return Error{"water: " + valid.error()};
  std::optional<Water>& present = impl_->surroundings.water;
  const bool same = water.has_value() == present.has_value() &&
                    (!water || (water->density == present->density && water->level == present->level &&
                                water->flow == present->flow));
  if (!same) impl_->wakeAll();
  present = water;
  return {};
}

const Air& SoftBodySystem::air() const { return impl_->surroundings.air; }
const std::optional<Water>& SoftBodySystem::water() const { return impl_->surroundings.water; }

Result<std::uint64_t> SoftBodySystem::addField(ForceField field, SoftBody* body) {
  if (!field) return Error{"the field is an empty function"};
  if (body && !impl_->owns(body)) return Error{"the soft body is not, or no longer, one of this system"};
  Surroundings& around = impl_->surroundings;
  around.fields.push_back({++around.lastField, std::move(field), body ? body->data_.get() : nullptr});
  if (body)
    body->wake();
  else
    impl_->wakeAll();
  return around.lastField;
}

Result<void> SoftBodySystem::removeField(std::uint64_t field) {
  auto& fields = impl_->surroundings.fields;
  const auto it =
      std::find_if(fields.begin(), fields.end(), [&](const ActingField& f) { return f.id == field; });
  if (it == fields.end()) return Error{"there is no field " + std::to_string(field)};
  for (auto& body : impl_->bodies)
    if (!it->body || it->body == body->data_.get()) body->wake();
  fields.erase(it);
  return {};
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

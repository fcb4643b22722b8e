// SPDX-License-Identifier: Zlib
#include "bullet/tick_contacts.h"

#include "bullet/bullet_objects.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

std::uint32_t TickContacts::find(const btRigidBody& body) const {
  const auto place = static_cast<std::size_t>(body.getWorldArrayIndex());
  return place < numbers_.size() ? numbers_[place] : kNone;
}

std::uint32_t TickContacts::add(btRigidBody& body) {
  if (const std::uint32_t number = find(body); number != kNone) return number;
  const auto place = static_cast<std::size_t>(body.getWorldArrayIndex());
  if (place >= numbers_.size()) numbers_.resize(place + 1, kNone);
  numbers_[place] = static_cast<std::uint32_t>(rigids.size());
  rigids.push_back(makePartner(body));
  return numbers_[place];
}

void TickContacts::add(const PairContact& contact, const ContactSource& source) {
  contacts.push_back(contact);
  sources.push_back(source);
}

void TickContacts::clear(double comingTick) {
  tick = comingTick;
  for (const RigidPartner& rigid : rigids) numbers_[static_cast<std::size_t>(rigid.mark.place)] = kNone;
  rigids.clear();
  contacts.clear();
  sources.clear();
  meetings.clear();
  joints.clear();
  jointSources.clear();
}

Eigen::Vector3d velocityOf(const btCollisionObject& object, const btVector3& place, double tick) {
  if (isKinematic(object)) return kinematicWay(object, toEigen(place)) / tick;
  const btRigidBody* rigid = btRigidBody::upcast(&object);
  if (!rigid || rigid->isStaticObject() || !rigid->isActive()) return Eigen::Vector3d::Zero();
  return toEigen(rigid->getVelocityInLocalPoint(place - rigid->getWorldTransform().getOrigin()));
}

ContactPlace placeOn(TickContacts& contacts, const btCollisionObject& object, const btVector3& place) {
  ContactPlace found;
  btRigidBody* rigid = btRigidBody::upcast(const_cast<btCollisionObject*>(&object));
  if (rigid && isFree(*rigid)) {
    found.kind = ContactPlace::Kind::Rigid;
    found.body = contacts.add(*rigid);
    found.arm = toEigen(place) - toEigen(rigid->getWorldTransform().getOrigin());
  } else {
    found.velocity = velocityOf(object, place, contacts.tick);
  }
  return found;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

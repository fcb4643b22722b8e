// SPDX-License-Identifier: Zlib
#include "bullet/cluster_rows.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Points that something else than what is held touches, or may touch within the tick: solved apart from it their rows
/// would give way.
void markCoupledPoints(Cluster& cluster) {
  for (SoftBodyData* body : cluster.softBodies) body->coupled.assign(body->masses.bodies.size(), 0);
  for (const ClusterMeeting& m : cluster.meetings)
    for (SoftBodyData* body : {m.surfaces->body, m.surfaces->other})
      if (m.moves() && !m.surfaces->held && body) body->coupled.assign(body->coupled.size(), 1);
  for (const PairContact& c : cluster.step.pairs.contacts)
    for (const ContactPlace* place : {&c.a, &c.b})
      if (place->kind == ContactPlace::Kind::Soft)
        for (std::uint32_t i = 0; i < place->count; ++i)
          cluster.softBodies[place->body]->coupled[place->point[i]] = 1;
  for (const LinkAnchor& anchor : cluster.step.links.anchors)
    cluster.softBodies[anchor.point.body]->coupled[anchor.point.point] = 1;
}

PairContact pairOf(const ContactRow& row, const SoftBodyData& body, std::uint32_t place) {
  PairContact c;
  c.a.kind = ContactPlace::Kind::Soft;
  c.a.body = place;
  c.a.point[0] = row.point;
  c.b.velocity = row.surfaceVelocity;
  c.normal = row.normal;
  c.gap = row.normal.dot(body.state.position.col(row.point) - row.touch);
  c.held = row.around ? &row : nullptr;
  c.friction = row.friction;
  c.restitution = row.restitution;
  c.bounceThreshold = row.bounceThreshold;
  c.recoverySpeed = row.recoverySpeed;
  return c;
}

}  // namespace

void appendRows(Cluster& cluster) {
  markCoupledPoints(cluster);
  for (std::uint32_t place = 0; place < cluster.softBodies.size(); ++place) {
    SoftBodyData& body = *cluster.softBodies[place];
    for (ContactRow& row : body.contacts) {
      row.coupled = body.coupled[row.point] != 0;
      if (!row.coupled) continue;
      cluster.rows.push_back(&row);
      cluster.step.pairs.contacts.push_back(pairOf(row, body, place));
    }
  }
}

void reportRows(Cluster& cluster) {
  for (std::size_t i = 0; i < cluster.rows.size(); ++i)
    cluster.rows[i]->impulse = cluster.step.pairs.contacts[cluster.contacts.size() + i].impulse;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

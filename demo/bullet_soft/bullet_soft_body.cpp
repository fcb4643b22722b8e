// SPDX-License-Identifier: Zlib
#include "bullet_soft/bullet_soft_body.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace limber::bullet_soft {
namespace {

/// Orders pinned points last: btDeformable applies its explicit forces to the wrong nodes after a pinned one.
std::vector<std::uint32_t> pinnedLast(const BodySetup& setup, std::size_t count) {
  std::vector<std::uint32_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = static_cast<std::uint32_t>(i);
  std::stable_partition(order.begin(), order.end(), [&](std::uint32_t point) {
    return std::find(setup.pins.begin(), setup.pins.end(), point) == setup.pins.end();
  });
  return order;
}

void addLinksAndFaces(const BodySetup& setup, const BodyStart& start, BulletSoftBody& soft) {
  for (const NetworkSpring& spring : setup.network->springs) {
    soft.body->appendLink(soft.nodeOfPoint[spring.a], soft.nodeOfPoint[spring.b]);
    auto& link = soft.body->m_links[soft.body->m_links.size() - 1];
    link.m_bbending = spring.kind == SpringKind::Bending ? -1 : 0;  // one signed bit
  }
  for (const Triangle& t : setup.network->surface)
    soft.body->appendFace(soft.nodeOfPoint[t[0]], soft.nodeOfPoint[t[1]], soft.nodeOfPoint[t[2]]);
  soft.body->updateConstants();
  for (int s = 0; s < soft.body->m_links.size(); ++s) {
    auto& link = soft.body->m_links[s];
    link.m_rl = static_cast<btScalar>(start.restLengths[s]);
    link.m_c1 = link.m_rl * link.m_rl;
  }
  // otherwise the first tick would use the present lengths as rest lengths
  soft.body->m_bUpdateRtCst = false;
  if (!setup.network->surface.empty()) soft.body->initializeFaceTree();
}

void setVelocities(const BodyStart& start, BulletSoftBody& soft) {
  for (std::uint32_t i = 0; i < soft.nodeOfPoint.size(); ++i) {
    soft.node(i).m_v = toBullet(start.velocities.col(i));
    soft.node(i).m_vn = soft.node(i).m_v;  // btDeformable starts with this one
  }
}

}  // namespace

BulletSoftBody makeBulletSoftBody(const BodySetup& setup, const BodyStart& start, btSoftBodyWorldInfo& info) {
  const auto count = static_cast<std::size_t>(start.positions.cols());
  BulletSoftBody soft;
  soft.masses = start.masses;
  soft.nodeOfPoint.resize(count);
  std::vector<btVector3> nodes;
  std::vector<btScalar> masses;
  for (const std::uint32_t point : pinnedLast(setup, count)) {
    soft.nodeOfPoint[point] = static_cast<int>(nodes.size());
    nodes.push_back(toBullet(start.positions.col(point)));
    masses.push_back(static_cast<btScalar>(start.masses[point]));
  }
  soft.body = std::make_unique<btSoftBody>(&info, static_cast<int>(count), nodes.data(), masses.data());
  const double radius = pointRadius(*setup.network, setup.settings);
  soft.body->getCollisionShape()->setMargin(static_cast<btScalar>(radius));
  soft.body->m_cfg.kDF = static_cast<btScalar>(setup.settings.friction);
  soft.body->setFriction(static_cast<btScalar>(setup.settings.friction));
  addLinksAndFaces(setup, start, soft);
  setVelocities(start, soft);
  for (const std::uint32_t pin : setup.pins) pinNode(soft, pin, true);
  if (!setup.maySleep) soft.body->setActivationState(DISABLE_DEACTIVATION);
  return soft;
}

// A step h of implicit Euler with a spring k between two points of inverse masses w removes
//   k h^2 (wa + wb) / (1 + k h^2 (wa + wb))  of its error; kLST is the corresponding share of one iteration.
void calibrateLinks(BulletSoftBody& soft, const SpringNetwork& network, const BodyStart& start,
                    int iterations, double dt) {
  std::map<btScalar, btSoftBody::Material*> materials;
  btSoftBody& body = *soft.body;
  for (int m = 0; m < body.m_materials.size(); ++m)
    materials.emplace(body.m_materials[m]->m_kLST, body.m_materials[m]);
  for (int s = 0; s < body.m_links.size(); ++s) {
    const NetworkSpring& spring = network.springs[static_cast<std::size_t>(s)];
    const auto inverseMass = [&](std::uint32_t i) { return double(soft.node(i).m_im); };
    const double stiff = start.stiffnesses[s] * dt * dt * (inverseMass(spring.a) + inverseMass(spring.b));
    const auto share = static_cast<btScalar>(1.0 - std::pow(1.0 / (1.0 + stiff), 1.0 / iterations));
    btSoftBody::Material*& material = materials[share];
    if (!material) material = body.appendMaterial();
    material->m_kLST = share;
    body.m_links[s].m_material = material;
  }
  body.updateLinkConstants();
}

Eigen::Matrix3Xd nodePositions(const BulletSoftBody& soft) {
  Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(soft.nodeOfPoint.size()));
  for (std::uint32_t i = 0; i < soft.nodeOfPoint.size(); ++i) all.col(i) = fromBullet(soft.node(i).m_x);
  return all;
}

Eigen::Matrix3Xd nodeVelocities(const BulletSoftBody& soft) {
  Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(soft.nodeOfPoint.size()));
  for (std::uint32_t i = 0; i < soft.nodeOfPoint.size(); ++i) all.col(i) = fromBullet(soft.node(i).m_v);
  return all;
}

void pinNode(const BulletSoftBody& soft, std::uint32_t point, bool pinned) {
  soft.node(point).m_im = pinned ? btScalar(0) : static_cast<btScalar>(1 / soft.masses[point]);
  if (pinned) soft.node(point).m_v = soft.node(point).m_vn = btVector3(0, 0, 0);
  for (int s = 0; s < soft.body->m_links.size(); ++s) {
    auto& link = soft.body->m_links[s];
    link.m_c0 = (link.m_n[0]->m_im + link.m_n[1]->m_im) / link.m_material->m_kLST;
  }
}

}  // namespace limber::bullet_soft

// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet_soft/body_start.h"

#include <BulletSoftBody/btSoftBody.h>

#include <memory>
#include <vector>

namespace limber::bullet_soft {

/// A btSoftBody and the node of each point.
struct BulletSoftBody {
  std::unique_ptr<btSoftBody> body;
  std::vector<int> nodeOfPoint;  ///< #points
  Eigen::VectorXd masses;        ///< #points, kg

  btSoftBody::Node& node(std::uint32_t point) const { return body->m_nodes[nodeOfPoint[point]]; }
};

/// Creates a btSoftBody with the set-up's points and springs: links in the order of the springs, rest lengths
/// as given, and contacts at the nodes with the same radius and friction as Limber's points.
BulletSoftBody makeBulletSoftBody(const BodySetup& setup, const BodyStart& start, btSoftBodyWorldInfo& info);

/// Gives each link the kLST with which so many iterations in a tick of dt seconds act like a step of implicit
/// Euler on a single spring of its stiffness.
void calibrateLinks(BulletSoftBody& soft, const SpringNetwork& network, const BodyStart& start,
                    int iterations, double dt);

Eigen::Matrix3Xd nodePositions(const BulletSoftBody& soft);
Eigen::Matrix3Xd nodeVelocities(const BulletSoftBody& soft);
void pinNode(const BulletSoftBody& soft, std::uint32_t point, bool pinned);

}  // namespace limber::bullet_soft

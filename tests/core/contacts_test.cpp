// SPDX-License-Identifier: Zlib
// Contacts between soft bodies and with moving rigid bodies, in the substeps: forces at rest compared with
// weights, conservation laws, and Coulomb's law.
#include "solver/contacts.h"
#include "solver/point_state.h"
#include "solver/verlet_step.h"
#include "support/networks.h"
#include "support/stepped_body.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

namespace limber {
namespace {

using Eigen::Vector3d;
using test::SteppedTestBody;

constexpr double kTick = 1.0 / 60.0;
constexpr double kGravity = 9.81;

ContactPoint point(std::uint32_t body, std::uint32_t i) {
  ContactPoint contact;
  contact.kind = ContactPoint::Kind::Soft;
  contact.body = body;
  contact.point = {i, 0, 0};
  return contact;
}

ContactPoint corner(std::uint32_t rigid, const Vector3d& arm) {
  ContactPoint contact;
  contact.kind = ContactPoint::Kind::Rigid;
  contact.body = rigid;
  contact.arm = arm;
  return contact;
}

/// An island that is built directly.
struct Scene {
  SolverIsland island;
  std::deque<SteppedTestBody> soft;

  std::uint32_t addCube(double stiffness, double damping, const Vector3d& position) {
    soft.emplace_back(test::fullCubeNetwork(), stiffness, damping);
    SteppedTestBody& cube = soft.back();
    cube.state.position.colwise() += position;
    cube.state.acceleration.row(1).setConstant(-kGravity);
    island.bodies.push_back(cube.stepped());
    island.links.points.push_back(&cube.state);
    return static_cast<std::uint32_t>(soft.size() - 1);
  }

  std::uint32_t addBox(double mass, const Vector3d& position) {
    RigidState box;
    box.position = position;
    box.acceleration.y() = -kGravity;
    box.inverseMass.setConstant(1.0 / mass);
    box.inverseInertiaLocal.setConstant(6.0 / mass);  // of a cube of 1 m
    island.links.rigids.push_back(box);
    return static_cast<std::uint32_t>(island.links.rigids.size() - 1);
  }

  void add(const ContactPoint& a, const ContactPoint& b, double gap,
           const Vector3d& normal = Vector3d::UnitY()) {
    Contact c;
    c.a = a, c.b = b, c.gap = gap, c.normal = normal, c.friction = 0.5;
    island.pairs.contacts.push_back(c);
  }

  /// Adds contacts for the four lower corners of a cube; `support(i)` is the other side. The upper corners
  /// are those with i & 2.
  template <class Support>
  void addSupport(std::uint32_t cube, Support support) {
    for (std::uint32_t i = 0; i < 8; ++i)
      if (!(i & 2)) add(point(cube, i), support(i), 0.0);
  }

  void run(double time, int substeps) {
    for (double t = 0.0; t < time - 0.5 * kTick; t += kTick) stepVerlet(island, kTick, substeps);
  }

  /// Returns the upward force (N) of the contacts from `first` to before `last`.
  double force(std::size_t first, std::size_t last) const {
    double sum = 0.0;
    for (std::size_t i = first; i < last; ++i) sum += island.pairs.contacts[i].impulse.sum.y() / kTick;
    return sum;
  }
};

const auto kFloor = [](std::uint32_t) { return ContactPoint(); };

TEST(PairContacts, carryATowerOfCubes) {
  for (const double stiffness : {1e3, 1e5}) {
    SCOPED_TRACE(stiffness);
    Scene scene;
    const std::size_t count = 5;
    for (std::uint32_t c = 0; c < count; ++c) {
      scene.addCube(stiffness, 2.0, {0, 0.5 + c, 0});
      if (c == 0)
        scene.addSupport(c, kFloor);
      else
        scene.addSupport(c, [&](std::uint32_t i) { return point(c - 1, i | 2); });
    }
    scene.run(20.0, 40);
    for (std::size_t c = 0; c < count; ++c)
      EXPECT_NEAR(scene.force(4 * c, 4 * c + 4) / (kGravity * static_cast<double>(count - c)), 1.0, 1e-5)
          << c;
    // a contact yields by 0.4 % of the motion of a free point: with four cubes above, 0.4 % of 16 g dt
    for (const SteppedTestBody& cube : scene.soft) EXPECT_LT(cube.state.velocity.cwiseAbs().maxCoeff(), 3e-4);
    for (const Contact& c : scene.island.pairs.contacts) EXPECT_NEAR(c.gap, 0.0, 1e-6);
  }
}

TEST(PairContacts, carryBoxesLightAndHeavyAndLieOnThem) {
  for (const double mass : {0.01, 1.0, 100.0}) {
    SCOPED_TRACE(mass);
    Scene scene;  // floor, box, cube, box
    const std::uint32_t cube = scene.addCube(1e5, std::max(5.0, 10.0 * mass), {0, 1.5, 0});
    const std::uint32_t lowerBox = scene.addBox(mass, {0, 0.5, 0}),
                        upperBox = scene.addBox(mass, {0, 2.5, 0});
    for (std::uint32_t i = 0; i < 8; ++i) {
      const Vector3d arm((i & 1) - 0.5, i & 2 ? 0.5 : -0.5, (i >> 2) - 0.5);
      if (i & 2)
        scene.add(point(cube, i - 2), corner(lowerBox, arm), 0.0);
      else
        scene.add(corner(lowerBox, arm), ContactPoint(), 0.0);
    }
    for (std::uint32_t i = 0; i < 8; ++i)
      if (i & 2)
        scene.add(corner(upperBox, Vector3d((i & 1) - 0.5, -0.5, (i >> 2) - 0.5)), point(cube, i), 0.0);
    scene.run(10.0, 60);
    const double below = scene.force(0, 2) + scene.force(4, 6),
                 middle = scene.force(2, 4) + scene.force(6, 8);
    // each solve has an error of up to IslandConstraints::tolerance in the velocities: for the light boxes
    // between heavier points up to 4 % of the velocity that gravity adds in a substep
    EXPECT_NEAR(middle / (kGravity * (1.0 + mass)), 1.0, 1e-2);
    EXPECT_NEAR(below / (kGravity * (1.0 + 2.0 * mass)), 1.0, 1e-2);
    EXPECT_NEAR(scene.force(8, 12) / (kGravity * mass), 1.0, 1e-2);
    for (const Contact& c : scene.island.pairs.contacts) EXPECT_NEAR(c.gap, 0.0, 2e-6);
  }
}

TEST(PairContacts, lightPointsOnTheFloorPassALoadOnAtOnce) {
  // a box that turns on 20 points in a row: without supports the solve ends unfinished after 50 sweeps
  constexpr std::uint32_t kCount = 20;
  constexpr double kMass = 20.0, kDt = kTick / 10.0;
  PointState cloth;
  cloth.resize(kCount);
  cloth.inverseMass.setConstant(1000.0);
  Scene scene;
  LinkedBodies& links = scene.island.links;
  IslandConstraints& rows = scene.island.pairs;
  links.points.push_back(&cloth);
  links.views.push_back(viewOf(cloth));
  const std::uint32_t box = scene.addBox(kMass, {0, 0.5, 0});
  for (std::uint32_t i = 0; i < kCount; ++i) {
    cloth.position.col(i) = Vector3d(0.05 * i - 0.475, 0, 0.3 * (i % 2));
    scene.add(point(0, i), {}, 0.0);
    scene.add(point(0, i), corner(box, cloth.position.col(i) - Vector3d(0, 0.5, 0)), 0.0, -Vector3d::UnitY());
  }
  for (RigidState& rigid : links.rigids) {
    rigid.turn();
    rigid.velocity = {0.01, -kGravity * kDt, 0};
    rigid.angularVelocity = {0.02, 0.0, 0.03};
  }
  prepareConstraints(rows, links);
  Team alone;
  rows.tolerance = 1e-4;
  const int sweeps = solvePositions(rows, links, alone, kDt, kTick);
  EXPECT_LT(sweeps, 35);
  EXPECT_GT(cloth.velocity.row(1).minCoeff(), -rows.tolerance);
  double floor = 0.0;
  for (const ContactConstraint& row : rows.rows) {
    EXPECT_GE(row.positionImpulse.n, 0.0);
    if (row.axes[0][1] > 0.0) floor += row.positionImpulse.n;
  }
  const double change = links.rigids[box].velocity.y() + kGravity * kDt;
  EXPECT_NEAR(floor, kMass * change + 1e-3 * cloth.velocity.row(1).sum(), 1e-12);
}

TEST(PairContacts, keepMomentumAndLoseEnergyInFreeFlight) {
  Scene scene;
  const std::uint32_t left = scene.addCube(1e4, 0.1, {0, 0, 0}),
                      right = scene.addCube(1e4, 0.1, {1.01, 0.1, 0.2});
  for (SteppedTestBody& cube : scene.soft) cube.state.acceleration.setZero();
  scene.soft[0].state.velocity.row(0).setConstant(3.0);
  // a corner of the right cube touches the triangle of three corners of the left one's side
  ContactPoint side = point(left, 1);
  side.count = 3;
  side.point = {1, 3, 5};
  const Vector3d cornerPosition = scene.soft[right].state.position.col(0);
  side.weight = {1.0 - (cornerPosition.y() + 0.5) - (cornerPosition.z() + 0.5), cornerPosition.y() + 0.5,
                 cornerPosition.z() + 0.5};
  scene.add(side, point(right, 0), 0.01, -Vector3d::UnitX());
  const auto linear = [&]() -> Vector3d {
    return linearMomentum(scene.soft[0].state) + linearMomentum(scene.soft[1].state);
  };
  const auto angular = [&]() -> Vector3d {
    return angularMomentum(scene.soft[0].state) + angularMomentum(scene.soft[1].state);
  };
  const Vector3d momentum = linear(), spin = angular();
  const double energy = scene.soft[0].energy() + scene.soft[1].energy();
  scene.run(0.1, 30);
  EXPECT_LT((linear() - momentum).norm(), 1e-13);
  EXPECT_GT(linearMomentum(scene.soft[1].state).x(), 0.5) << "they have met";
  EXPECT_LT(scene.soft[0].energy() + scene.soft[1].energy(), energy);
  EXPECT_LT((angular() - spin).norm(), 1e-12 * momentum.norm());
}

TEST(PairContacts, slideByCoulombsLaw) {
  for (const double ratio : {0.97, 1.03}) {
    Scene scene;
    const double angle = std::atan(0.5 * ratio);
    scene.addBox(3.0, {0, 0.5, 0});
    // the floor is level, and gravity is tilted instead
    scene.island.links.rigids[0].acceleration = kGravity * Vector3d(std::sin(angle), -std::cos(angle), 0);
    for (const double x : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5}) scene.add(corner(0, {x, -0.5, z}), ContactPoint(), 0.0);
    scene.run(1.0, 10);
    const double expected = std::max(0.0, kGravity * (std::sin(angle) - 0.5 * std::cos(angle)));
    EXPECT_NEAR(scene.island.links.rigids[0].velocity.x(), expected, 1e-4 + 1e-3 * expected) << ratio;
  }
}

/// Sweeps that a tower needs leave out the sliding box, which a few sweeps have solved.
TEST(PairContacts, solveATowerAndASlidingBoxAtOnce) {
  const double speed = 3.0, time = 0.25;
  const auto slide = [&](Scene& scene) -> double {
    const std::uint32_t box = scene.addBox(1.0, {0, 0.5, 5});
    scene.island.links.rigids[box].velocity.x() = speed;
    for (const double x : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5}) scene.add(corner(box, {x, -0.5, z}), ContactPoint(), 0.0);
    scene.run(time, 10);
    return scene.island.links.rigids[box].velocity.x();
  };
  Scene alone, both;
  const std::size_t count = 6;
  for (std::uint32_t c = 0; c < count; ++c) {
    both.addCube(1e4, 20.0, {0, 0.5 + c, 0});
    if (c == 0)
      both.addSupport(c, kFloor);
    else
      both.addSupport(c, [&](std::uint32_t i) { return point(c - 1, i | 2); });
  }
  const double slower = slide(both);
  EXPECT_NEAR(slower, slide(alone), both.island.pairs.tolerance);
  EXPECT_NEAR(slower, speed - 0.5 * kGravity * time, 1e-3 * speed);
  both.run(20.0, 20);
  EXPECT_EQ(both.island.links.rigids[0].velocity.x(), 0.0);
  for (std::size_t c = 0; c < count; ++c)
    EXPECT_NEAR(both.force(4 * c, 4 * c + 4) / (kGravity * static_cast<double>(count - c)), 1.0, 1e-4) << c;
}

TEST(PairContacts, leaveAPointThatIsCarriedToItsAnchor) {
  Scene scene;
  const std::uint32_t cube = scene.addCube(1e3, 2.0, {0, 0.5, 0});
  LinkedBodies& links = scene.island.links;
  RigidState holder;
  holder.position = scene.soft[0].state.position.col(0);
  holder.velocity = {0, -1, 0};
  links.rigids.push_back(holder);
  links.anchors.push_back(
      {{LinkEnd::Kind::Point, cube, 0, {}}, {LinkEnd::Kind::Rigid, 0, 0, Vector3d::Zero()}});
  scene.add(point(cube, 0), ContactPoint(), 0.0);
  scene.run(0.1, 20);
  EXPECT_EQ(scene.force(0, 1), 0.0) << "both would push as long as they are let";
  EXPECT_LT((endPosition(links, links.anchors[0].point) - links.rigids[0].position).norm(), 1e-9);
}

TEST(PairContacts, drawApartGentlyWhatOverlaps) {
  Scene scene;
  scene.addCube(1e4, 1.0, {0, 0.5, 0});
  scene.addSupport(0, kFloor);
  for (Contact& c : scene.island.pairs.contacts) c.gap = -0.05, c.friction = 0.0, c.recoverySpeed = 0.5;
  double fastest = 0.0;
  for (int i = 0; i < 60; ++i) {
    stepVerlet(scene.island, kTick, 10);
    fastest = std::max(fastest, scene.soft[0].state.velocity.row(1).maxCoeff());
  }
  EXPECT_NEAR(scene.island.pairs.contacts[0].gap, 0.0, 1e-3);
  EXPECT_LT(fastest, 1.0);
}

}  // namespace
}  // namespace limber

// SPDX-License-Identifier: Zlib
// Bodies stepped side by side in lanes must equal the same bodies stepped one by one, bit for bit, with every
// instruction set.
#include "solver/simd_steps.h"
#include "solver/verlet_step.h"
#include "support/networks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <vector>

namespace limber {
namespace {

/// Finds a floor below points that leave their regions.
struct FloorWatch : ContactWatch {
  Points center;
  std::vector<double> distance;

  void start(const Points& position) {
    center = position;
    distance.assign(8, 0.05);
    rows.clear();
  }
  bool leaves(const PointView& points, double dt, std::uint32_t i) const {
    const Eigen::Vector3d next = points.positionOf(i) + dt * points.velocityOf(i);
    return (next - center.col(i)).squaredNorm() > distance[i] * distance[i] &&
           !points.inverseMassOf(i).isZero(0.0);
  }
  Regions regions() const override { return {&center, &distance}; }
  bool anyLeaves(const PointView& points, double dt, std::uint32_t begin, std::uint32_t end) const override {
    for (std::uint32_t i = begin; i < end; ++i)
      if (leaves(points, dt, i)) return true;
    return false;
  }
  void look(const PointView& points, double, double dt) override {
    for (std::uint32_t i = 0; i < 8; ++i) {
      if (!leaves(points, dt, i)) continue;
      PlaneContact row;
      row.point = i;
      row.touch = Eigen::Vector3d(0.0, -0.6, 0.0);
      rows.push_back(row);
      distance[i] = HUGE_VAL;
    }
    std::sort(rows.begin(), rows.end(),
              [](const PlaneContact& a, const PlaneContact& b) { return a.point < b.point; });
    prepareContacts(rows, points);
  }
  void merge() override {}
};

struct LaneBody {
  PointState state;
  SpringArrays springs;
  VolumeArrays volumes;
  TetrahedronVolumes tetrahedra;
  std::vector<PlaneContact> contacts;
  std::shared_ptr<RestShape> rest;
  MotionSums sums;
  FloorWatch watch;
  SolverIsland island;

  SolverBody stepped() {
    SolverBody body{&state, &springs, &contacts, volumes.empty() ? nullptr : &volumes,
                    tetrahedra.empty() ? nullptr : &tetrahedra};
    body.rest = rest.get();
    body.sums = &sums;
    body.watch = &watch;
    return body;
  }
};

/// Makes the parts that bodies in lanes share.
LaneBody makeModel(const SharedNetwork& network, double damping) {
  SoftBodySettings settings;
  settings.extensionStiffness = 500.0;
  settings.compressionStiffness = damping > 0.0 ? 0.0 : 700.0;
  settings.damping = damping;
  settings.pressure = network->surface.empty() ? 0.0 : 10.0;
  settings.ambientPressure = network->surface.empty() ? 0.0 : 30.0;
  if (!network->tetrahedra.empty())
    settings.volumeModulus = 1e6;  // its force is scaled down to the stable one
  LaneBody body;
  body.springs = makeSprings(*network, settings);
  body.volumes = makeVolumes(*network, settings);
  body.tetrahedra = makeTetrahedronVolumes(*network, settings);
  const Points rest = scaledRest(*network, settings.scale);
  body.rest = std::make_shared<RestShape>(RestShape{network->massFractions, 0.125 * rest, 0.0});
  return body;
}

/// Fills in a cube. Cubes of different `index` differ in position, velocity and contacts; even ones have
/// none.
void fill(LaneBody& body, const SharedNetwork& network, int index) {
  body.state.resize(8);
  for (std::uint32_t i = 0; i < 8; ++i) {
    const Eigen::Vector3d x = network->restPoints[i];
    body.state.position.col(i) = (1.0 + 0.05 * index) * x + Eigen::Vector3d(3.0 * index, 0.02 * i, 0.0);
    body.state.velocity.col(i) = Eigen::Vector3d(index, -1.0, 0.5).cross(x);
    body.state.acceleration.col(i) = Eigen::Vector3d(0.0, -9.81, 0.0);
    body.state.inverseMass.col(i).setConstant(i == 4 ? 0.0 : 8.0);
  }
  if (!body.tetrahedra.empty()) tetrahedronFrequencyBoundSquared(body.tetrahedra, body.state);
  if (index == 5) body.state.position.col(1) = body.state.position.col(0);  // coincident ends
  for (std::uint32_t i = 0; i < 8 && index % 2 == 1; i += 3) {
    PlaneContact row;
    row.point = i;
    row.friction = 0.4;
    row.touch = Eigen::Vector3d(0.0, -0.4 - 0.05 * i, 0.0);
    row.surfaceVelocity = Eigen::Vector3d(0.1, 0.3, 0.0);
    if (index == 3) row.friction = 0.0, row.recoverySpeed = 0.2, row.touch.y() += 0.3;
    if (index == 5) row.restitution = 0.5;  // not in planes of lanes
    body.contacts.push_back(row);
    if (index != 7) continue;  // a corner: not in planes of lanes either
    row.normal = Eigen::Vector3d(0.6, 0.8, 0.0);
    body.contacts.push_back(row);
  }
  body.watch.on = index % 3 == 0;
  body.watch.start(body.state.position);
  body.island.bodies.push_back(body.stepped());
  body.island.links.points.push_back(&body.state);
}

std::deque<LaneBody> makeBodies(const SharedNetwork& network, int count, double damping) {
  std::deque<LaneBody> bodies(static_cast<std::size_t>(count));
  const LaneBody model = makeModel(network, damping);
  for (int i = 0; i < count; ++i) {
    LaneBody& body = bodies[static_cast<std::size_t>(i)];
    body.springs = model.springs, body.volumes = model.volumes, body.tetrahedra = model.tetrahedra;
    body.rest = model.rest;
    fill(body, network, i);
  }
  return bodies;
}

bool sameBits(const Points& a, const Points& b) { return (a.array() == b.array()).all(); }

bool sameBits(const MotionSums& a, const MotionSums& b) {
  constexpr auto kCount = static_cast<Eigen::Index>(sizeof(MotionSums) / sizeof(double));
  using Numbers = Eigen::Map<const Eigen::ArrayXd>;
  return (Numbers(a.low, kCount) == Numbers(b.low, kCount)).all();
}

std::vector<SolverBody*> lanesOf(std::deque<LaneBody>& bodies) {
  std::vector<SolverBody*> lanes;
  for (LaneBody& body : bodies) lanes.push_back(&body.island.bodies[0]);
  return lanes;
}

class Lanes : public testing::TestWithParam<InstructionSet> {};

TEST_P(Lanes, giveTheBitsOfSingleBodies) {
  const InstructionSet set = GetParam();
  if (!isAvailable(set)) GTEST_SKIP() << "this machine has no " << nameOf(set);
  std::size_t found = 0;
  const std::vector<std::pair<SharedNetwork, double>> kinds = {{test::cubeNetwork(), 0.0},
                                                               {test::cubeNetwork(), 0.7},
                                                               {test::closedCubeNetwork(), 0.7},
                                                               {test::tetrahedralCubeNetwork(), 0.7}};
  for (const auto& [network, damping] : kinds)
    for (int count = 1; count <= laneCount(set); ++count) {
      std::deque<LaneBody> single = makeBodies(network, count, damping);
      std::deque<LaneBody> laned = makeBodies(network, count, damping);
      LaneScratch scratch;
      std::vector<SolverBody*> lanes = lanesOf(laned);
      Points start;
      for (int tick = 0; tick < 20; ++tick) {
        start = single.back().state.position;
        for (auto* bodies : {&single, &laned})
          for (LaneBody& body : *bodies) body.watch.start(body.state.position);
        for (LaneBody& body : single) stepVerlet(body.island, 1.0 / 60.0, 7);
        stepLanes(lanes.data(), lanes.size(), scratch, 1.0 / 60.0, 7, set);
      }
      EXPECT_TRUE(sameBits(motionSums(single.back().state, start, *laned.back().rest), laned.back().sums));
      for (std::size_t i = 0; i < single.size(); ++i) {
        SCOPED_TRACE(testing::Message() << "damping " << damping << ", body " << i << " of " << count);
        EXPECT_TRUE(sameBits(single[i].state.position, laned[i].state.position));
        EXPECT_TRUE(sameBits(single[i].state.velocity, laned[i].state.velocity));
        EXPECT_EQ(single[i].island.bodies[0].errorRate, lanes[i]->errorRate);
        EXPECT_TRUE(single[i].state.position.allFinite());
        for (std::size_t c = 0; c < single[i].contacts.size(); ++c) {
          const TickImpulse &a = single[i].contacts[c].impulse, &b = laned[i].contacts[c].impulse;
          EXPECT_EQ(a.sum, b.sum);
          EXPECT_EQ(a.pressing, b.pressing);
          EXPECT_EQ(a.along, b.along);
        }
        found += laned[i].watch.rows.size();
      }
    }
  EXPECT_GT(found, 0u);
}

INSTANTIATE_TEST_SUITE_P(Sets, Lanes,
                         testing::Values(InstructionSet::Sse2, InstructionSet::Avx2, InstructionSet::Avx512,
                                         InstructionSet::Neon),
                         [](const auto& i) {
                           return std::string(i.param == InstructionSet::Avx512 ? "AVX512" : nameOf(i.param));
                         });

TEST(Lanes, takeUpDampersWhenTheSubstepChanges) {
  const InstructionSet set = bestInstructionSet();
  if (set == InstructionSet::Scalar) GTEST_SKIP() << "this processor has no lanes";
  std::deque<LaneBody> single = makeBodies(test::cubeNetwork(), 2, 0.5),
                       laned = makeBodies(test::cubeNetwork(), 2, 0.5);
  LaneScratch scratch;
  std::vector<SolverBody*> lanes = lanesOf(laned);
  for (const int substeps : {4, 9, 4}) {  // the damping factors depend on the number of substeps
    for (LaneBody& body : single) stepVerlet(body.island, 1.0 / 60.0, substeps);
    stepLanes(lanes.data(), lanes.size(), scratch, 1.0 / 60.0, substeps, set);
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_TRUE(sameBits(single[i].state.velocity, laned[i].state.velocity)) << substeps;
  }
}

TEST(Lanes, areSharedByEqualBodiesOnly) {
  std::deque<LaneBody> bodies = makeBodies(test::closedCubeNetwork(), 3, 0.5);
  const std::vector<SolverBody*> lanes = lanesOf(bodies);
  EXPECT_TRUE(canShareLanes(*lanes[0], *lanes[1]));
  bodies[1].state.inverseMass.col(2).setConstant(0.5);
  EXPECT_FALSE(canShareLanes(*lanes[0], *lanes[1])) << "another mass";
  bodies[2].springs = makeModel(test::closedCubeNetwork(), 0.7).springs;
  EXPECT_FALSE(canShareLanes(*lanes[0], *lanes[2])) << "other springs";
}

MotionSums sumsOf(const LaneBody& body) { return motionSums(body.state, body.state.position, *body.rest); }

/// A rigid motion about the centre of mass, and the rest shape as it is: all sums are known.
TEST(MotionSums, ofARigidMotion) {
  LaneBody cube = makeBodies(test::cubeNetwork(), 1, 0.0).front();
  const Eigen::Vector3d center(1.0, -2.0, 3.0), velocity(0.5, 0.0, -1.0), spin(0.1, 0.2, 0.3);
  const Points rest = 8.0 * cube.rest->weighted;
  cube.state.inverseMass.setConstant(8.0);
  cube.state.position = rest.colwise() + center;
  for (Eigen::Index i = 0; i < 8; ++i)
    cube.state.velocity.col(i) = velocity + spin.cross(Eigen::Vector3d(rest.col(i)));
  const MotionSums s = sumsOf(cube);
  using Vector = Eigen::Map<const Eigen::Vector3d>;
  const Eigen::Vector3d offset = -rest.col(0);
  EXPECT_NEAR(s.mass, 1.0, 1e-15);
  EXPECT_NEAR((Vector(s.low) - (center.array() - 0.5).matrix()).norm(), 0.0, 1e-15);
  EXPECT_NEAR((Vector(s.high) - (center.array() + 0.5).matrix()).norm(), 0.0, 1e-15);
  EXPECT_NEAR((Vector(s.meanOffset) - offset).norm(), 0.0, 1e-15);
  EXPECT_NEAR((Vector(s.meanVelocity) - velocity).norm(), 0.0, 1e-15);
  EXPECT_NEAR((Vector(s.momentum) - velocity).norm(), 0.0, 1e-15);
  // inertia of eight corners: sum m (y^2 + z^2) = 1/2
  EXPECT_NEAR((Vector(s.angular) - offset.cross(velocity) - 0.5 * spin).norm(), 0.0, 1e-15);
  EXPECT_NEAR((Eigen::Map<const Eigen::Matrix3d>(s.moments) - 0.25 * Eigen::Matrix3d::Identity()).norm(), 0.0,
              1e-15);
  EXPECT_EQ(s.farthest, 0.0);
  const double fastest = (cube.state.velocity.colwise() - velocity).colwise().squaredNorm().maxCoeff();
  EXPECT_NEAR(s.fastest, fastest, 1e-15);
  EXPECT_TRUE(std::isfinite(s.magnitude));
  cube.state.velocity(1, 3) = std::nan("");
  EXPECT_FALSE(std::isfinite(sumsOf(cube).magnitude));
}

}  // namespace
}  // namespace limber

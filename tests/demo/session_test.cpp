// SPDX-License-Identifier: Zlib
// What a user does in the window, without one.
#include "window/session.h"

#include "scene_renderer.h"
#include "window/controls.h"
#include "window/recording.h"
#include "window/run_window.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace limber::demo {
namespace {

const WindowSize kSize{1280, 720};

std::unique_ptr<Session> sessionOf(const char* scene, std::uint32_t count = 1) {
  SceneChoice choice;
  choice.name = scene;
  if (count > 0) choice.options.count = count;
  Result<std::unique_ptr<Session>> session = Session::create(choice, kSize);
  EXPECT_TRUE(session) << session.error();
  return std::move(*session);
}

Eigen::Vector3d centreOf(const Session& session) { return session.scene().soft->body(0)->centerOfMass(); }

Ray rayTo(const Session& session, const Eigen::Vector3d& place) {
  const Eigen::Vector3d eye = session.camera().eye();
  return {eye, (place - eye).normalized()};
}

void ticks(Session& session, int count) {
  for (int i = 0; i < count; ++i) session.tick();
}

Command plain(Action action) { return {action, {}, {}}; }

TEST(Session, aPulledCubeFollowsTheRay) {
  const auto session = sessionOf("cubes");
  ticks(*session, 60);
  const Eigen::Vector3d start = centreOf(*session), aside(0.8, 0.5, 0.0);
  EXPECT_EQ(session->perform(rayCommand(Action::Grab, rayTo(*session, start))).rfind("body 0", 0), 0u);
  ASSERT_TRUE(session->hand().holds());
  const Eigen::Vector3d held = session->hand().held();
  session->perform(rayCommand(Action::Drag, rayTo(*session, start + aside)));
  ticks(*session, 120);
  EXPECT_GT(session->hand().held().x(), held.x() + 0.2);  // the cube swings below it
  EXPECT_LT((session->hand().held() - session->hand().place()).norm(), 0.1);
  session->perform(plain(Action::Release));
  EXPECT_FALSE(session->hand().holds());
}

TEST(Session, aPulledBallFollowsTheRay) {
  const auto session = sessionOf("cubes");
  session->perform(rayCommand(Action::Shoot, {{0, 0.3, 5}, {0, 0, 1}}));
  ticks(*session, 1);
  btRigidBody& ball = *session->scene().world->movables.back();
  const Eigen::Vector3d start = scenes::fromBullet(ball.getCenterOfMassPosition());
  const Ray from{start + Eigen::Vector3d(0, 3, 0), {0, -1, 0}};
  EXPECT_EQ(session->perform(rayCommand(Action::Grab, from)).rfind("rigid body", 0), 0u);
  session->perform(rayCommand(Action::Drag, {from.origin + Eigen::Vector3d(0.5, 0.5, 0.0), from.direction}));
  ticks(*session, 120);
  EXPECT_NEAR(double(ball.getCenterOfMassPosition().x()), start.x() + 0.5, 0.1);
  EXPECT_LT((session->hand().held() - session->hand().place()).norm(), 0.1);
}

TEST(Session, aRayIntoTheSkyHitsNothing) {
  const auto session = sessionOf("cubes");
  const Ray sky{session->camera().eye(), Eigen::Vector3d::UnitY()};
  EXPECT_EQ(session->perform(rayCommand(Action::Grab, sky)), "nothing there");
  EXPECT_EQ(session->perform(rayCommand(Action::Pin, sky)), "nothing there");
  EXPECT_FALSE(session->hand().holds());
}

TEST(Session, aPinHoldsAPointUntilItIsTakenAway) {
  const auto session = sessionOf("cubes");
  const SoftBody& cube = *session->scene().soft->body(0);
  const Ray ray = rayTo(*session, centreOf(*session));
  EXPECT_EQ(session->perform(rayCommand(Action::Pin, ray)).rfind("pinned body 0", 0), 0u);
  std::uint32_t point = 0;
  while (point < cube.pointCount() && !cube.pinned(point)) ++point;
  const Eigen::Vector3d place = cube.position(point);
  ticks(*session, 30);
  EXPECT_TRUE(cube.position(point).isApprox(place, 1e-6));
  session->perform(rayCommand(Action::Pin, rayTo(*session, place)));
  EXPECT_FALSE(cube.pinned(point));
}

TEST(Session, aCutDividesACloth) {
  const auto session = sessionOf("cloth", 0);
  const SoftBody& cloth = *session->scene().soft->body(0);
  const std::uint32_t before = cloth.pointCount();
  const Pixel middle = *session->camera().pixelOf(centreOf(*session), kSize);
  Command cut = rayCommand(Action::Cut, session->camera().ray({middle.x - 600, middle.y}, kSize));
  const Eigen::Vector3d to = session->camera().ray({middle.x + 600, middle.y}, kSize).direction;
  cut.numbers.insert(cut.numbers.end(), {to.x(), to.y(), to.z()});
  const std::string outcome = session->perform(cut);
  EXPECT_NE(outcome.find("points divided"), std::string::npos);
  EXPECT_GT(cloth.pointCount(), before) << outcome;
}

TEST(Session, settingsAreTimesThoseOfTheSceneAndStayAfterARestart) {
  const auto session = sessionOf("cubes", 2);
  const double made = session->scene().soft->body(1)->settings().extensionStiffness;
  EXPECT_EQ(session->perform({Action::Set, {3.0}, "stiffness"}), "");
  EXPECT_EQ(session->perform({Action::Set, {2.0}, "stiffness"}), "");
  EXPECT_DOUBLE_EQ(session->scene().soft->body(1)->settings().extensionStiffness, 2.0 * made);
  session->perform({Action::Set, {4.0}, "gravity"});
  session->perform({Action::Set, {12.0}, "max-substeps"});
  session->perform(plain(Action::Restart));
  const SoftBody& cube = *session->scene().soft->body(1);
  EXPECT_DOUBLE_EQ(cube.settings().extensionStiffness, 2.0 * made);
  EXPECT_EQ(cube.settings().stepping.maxSubsteps, 12);
  EXPECT_FLOAT_EQ(float(session->scene().world->dynamics.getGravity().y()), -4.0f);
  session->perform({Action::Scene, {}, "rope"});
  EXPECT_EQ(session->settings()[Setting::Stiffness], 1.0);
}

// The colours of two cubes with the layer of islands.
std::array<render::Vec3, 2> islandColours(const Session& session) {
  const SoftBodySystem& soft = *session.scene().soft;
  return {islandColour(soft.body(0)->island()), islandColour(soft.body(1)->island())};
}

TEST(Session, touchingBodiesHaveTheColourOfTheirIslandAndOthersDiffer) {
  const auto same = [](const render::Vec3& a, const render::Vec3& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
  };
  const auto apart = sessionOf("cubes", 2), stacked = sessionOf("stack", 2);
  ticks(*apart, 10);
  ticks(*stacked, 10);
  EXPECT_FALSE(same(islandColours(*apart)[0], islandColours(*apart)[1]));
  EXPECT_TRUE(same(islandColours(*stacked)[0], islandColours(*stacked)[1]));
  ticks(*apart, 600);
  ASSERT_TRUE(apart->scene().soft->body(0)->sleeping());
  EXPECT_TRUE(same(islandColours(*apart)[0], islandColours(*apart)[1])) << "asleep: grey";
}

double heightOf(const bullet_soft::BulletTwin& twin, std::size_t body) { return twin.center(body).y(); }

std::unique_ptr<Session> splitOf(const char* scene, std::uint32_t count = 1) {
  auto session = sessionOf(scene, count);
  session->perform({Action::Show, {1.0}, "split"});
  return session;
}

TEST(Split, bothEnginesBeginAlikeAndFall) {
  const auto session = sessionOf("cubes", 2);
  ticks(*session, 20);
  session->perform({Action::Show, {1.0}, "split"});
  const bullet_soft::BulletTwin& twin = *session->bulletTwin();
  ASSERT_EQ(twin.bodyCount(), 2u);
  for (std::uint32_t i = 0; i < twin.pointCount(1); ++i)
    EXPECT_TRUE(twin.position(1, i).isApprox(session->scene().soft->body(1)->position(i), 1e-5)) << i;
  const double start = heightOf(twin, 0);
  ticks(*session, 12);
  EXPECT_NEAR(heightOf(twin, 0), session->scene().soft->body(0)->centerOfMass().y(), 0.03) << "free fall";
  EXPECT_LT(heightOf(twin, 0), start - 0.15);
  EXPECT_GT(twin.tickMs(), 0.0);
  ticks(*session, 300);
  EXPECT_NEAR(heightOf(twin, 0), 0.5, 0.1) << "on the floor";
}

TEST(Split, theSameScenesArePlayedAndTheOthersSayWhyNot) {
  for (const char* scene : {"cubes", "cloth", "rope", "pile", "stack", "curtain", "flag"}) {
    const auto session = splitOf(scene, std::string(scene) == "cloth" ? 0 : 2);
    ASSERT_TRUE(session->bulletTwin()) << scene << ": " << session->bulletProblem();
    ticks(*session, 20);
    EXPECT_EQ(session->bulletProblem(), "") << scene;
    EXPECT_GT(session->bulletTwin()->figures().kinetic, 0.0) << scene;
    EXPECT_LT(session->bulletTwin()->figures().stretch, 0.2) << scene;
  }
  for (const auto& [scene, reason] : {std::pair("pool", "btSoftBody has no water that carries bodies"),
                                      std::pair("tear", "btSoftBody has no springs that break")}) {
    const auto session = splitOf(scene, 0);
    EXPECT_FALSE(session->bulletTwin()) << scene;
    EXPECT_EQ(session->bulletProblem(), reason);
  }
}

TEST(Split, followsPullsPinsBallsAndSettings) {
  const auto session = splitOf("cubes");
  const bullet_soft::BulletTwin& twin = *session->bulletTwin();
  ticks(*session, 60);
  const Eigen::Vector3d start = centreOf(*session);
  session->perform(rayCommand(Action::Grab, rayTo(*session, start)));
  session->perform(rayCommand(Action::Drag, rayTo(*session, start + Eigen::Vector3d(0.8, 0.5, 0.0))));
  const std::uint32_t held = session->hand().point();
  ticks(*session, 120);
  EXPECT_LT((twin.position(0, held) - session->hand().place()).norm(), 0.2);
  session->perform(plain(Action::Release));
  session->perform(rayCommand(Action::Pin, rayTo(*session, centreOf(*session))));
  session->perform(rayCommand(Action::Shoot, {{0, 0.3, 5}, {0, 0, 1}}));
  session->perform({Action::Set, {20.0}, "bt-iterations"});
  session->perform({Action::Set, {0.5}, "bt-stiffness"});
  ticks(*session, 1);
  bool anyPinned = false;
  for (std::uint32_t i = 0; i < twin.pointCount(0); ++i) anyPinned = anyPinned || twin.isPinned(0, i);
  EXPECT_TRUE(anyPinned);
  EXPECT_EQ(twin.body(0).m_cfg.piterations, 20);
  EXPECT_FLOAT_EQ(float(twin.body(0).m_links[0].m_material->m_kLST), 0.5f);
  EXPECT_EQ(twin.scene().world->movables.size(), session->scene().world->movables.size());
}

TEST(Split, theRightHalfHasTheSameRaysAndOnlyOrbits) {
  const auto session = splitOf("cubes");
  Controls controls(*session, kSize);
  const ViewLayout layout = session->layout(kSize);
  const Pixel cube = *session->camera().pixelOf(centreOf(*session), layout.view);
  controls.move({cube.x + layout.left + layout.view.width, cube.y});
  controls.press(Button::Left, {});
  EXPECT_FALSE(session->hand().holds());
  controls.release(Button::Left);
  controls.move({cube.x + layout.left, cube.y});
  controls.press(Button::Left, {});
  EXPECT_TRUE(session->hand().holds());
}

TEST(Split, aCutEndsIt) {
  const auto session = splitOf("cloth", 0);
  ASSERT_TRUE(session->scene().soft->body(0)->cut(scenes::toBullet(centreOf(*session)), btVector3(1, 0, 0)));
  ticks(*session, 2);
  EXPECT_EQ(session->bulletProblem(), "btSoftBody cannot be cut or torn like this");
}

TEST(Session, windBlowsWhereItIsTold) {
  const auto session = sessionOf("flag");
  EXPECT_GT(session->settings()[Setting::Wind], 5.0);
  session->perform({Action::Set, {3.0}, "wind"});
  session->perform({Action::Set, {90.0}, "wind-direction"});
  EXPECT_TRUE(session->scene().soft->air().wind.isApprox(Eigen::Vector3d(0, 0, 3), 1e-12));
}

TEST(Session, pressureIsForClosedBodiesOnly) {
  const auto cubes = sessionOf("cubes");
  EXPECT_EQ(cubes->perform({Action::Set, {50.0}, "pressure"}), "");
  EXPECT_EQ(cubes->scene().soft->body(0)->settings().pressure, 50.0);
  const auto cloth = sessionOf("cloth", 0);
  EXPECT_NE(cloth->perform({Action::Set, {50.0}, "pressure"}), "");
  EXPECT_EQ(cloth->scene().soft->body(0)->settings().pressure, 0.0);
  EXPECT_EQ(cloth->perform({Action::Set, {12.0}, "max-substeps"}), "");
  EXPECT_EQ(cloth->scene().soft->body(0)->settings().stepping.maxSubsteps, 12);
}

TEST(Session, titleIsTheCommandLineOfTheScene) {
  const auto session = sessionOf("cubes", 3);
  session->perform({Action::Set, {2.5}, "stiffness"});
  session->perform({Action::Show, {1.0}, "strain"});
  session->perform({Action::Show, {1.0}, "boxes"});
  ticks(*session, 2);
  session->perform({Action::Pause, {1.0}, {}});
  const std::string title = titleOf(*session);
  EXPECT_EQ(title.rfind("limber-demo --window --scene cubes --count 3 --set stiffness=2.5 --mode wireframe "
                        "--overlay boxes --camera ",
                        0),
            0u)
      << title;
  EXPECT_NE(title.find("- tick 2, paused"), std::string::npos) << title;
}

TEST(Controls, theMousePullsBodiesAndElseOrbits) {
  const auto session = sessionOf("cubes");
  Controls controls(*session, kSize);
  const Pixel cube = *session->camera().pixelOf(centreOf(*session), kSize);
  controls.move(cube);
  controls.press(Button::Left, {});
  EXPECT_TRUE(session->hand().holds());
  controls.release(Button::Left);
  EXPECT_FALSE(session->hand().holds());
  const double yaw = session->camera().yaw;
  const Eigen::Vector3d target = session->camera().target;
  controls.move({5, 5});
  controls.press(Button::Left, {});
  controls.move({105, 5});
  controls.finishMovement();
  EXPECT_LT(session->camera().yaw, yaw);
  EXPECT_EQ(session->camera().target, target);
}

TEST(Controls, aDragWithControlDrawsALineAndCutsAtItsEnd) {
  const auto session = sessionOf("cloth", 0);
  Controls controls(*session, kSize);
  std::string done;
  session->setListener([&done](const Command& command, const std::string&) { done += textOf(command)[0]; });
  controls.move({100, 100});
  controls.press(Button::Left, {false, true});
  controls.move({900, 500});
  ASSERT_TRUE(controls.cutLine());
  EXPECT_EQ((*controls.cutLine())[1].x, 900);
  EXPECT_EQ(done, "");
  controls.release(Button::Left);
  EXPECT_EQ(done, "c");
  EXPECT_FALSE(controls.cutLine());
}

TEST(Controls, keysOfLayersAndOfThePace) {
  const auto session = sessionOf("cubes");
  Controls controls(*session, kSize);
  controls.press('2');
  EXPECT_TRUE(session->shows(Layer::Contacts));
  controls.press('2');
  EXPECT_FALSE(session->shows(Layer::Contacts));
  controls.press(' ');
  EXPECT_TRUE(session->pace().paused);
  controls.press('.');
  EXPECT_EQ(session->ticksDue(10.0), 1);
  EXPECT_EQ(session->ticksDue(10.0), 0);
  controls.press('M');
  EXPECT_EQ(session->pace().speed, 0.25);
  EXPECT_FALSE(controls.wantsToQuit());
  controls.press(kEscape);
  EXPECT_TRUE(controls.wantsToQuit());
}

TEST(Controls, nextSceneGoesThroughAllButTheMesh) {
  const auto session = sessionOf("skeleton", 0);
  Controls controls(*session, kSize);
  controls.press('N');
  EXPECT_EQ(session->choice().name, "cubes");
  controls.press('N');
  EXPECT_NE(session->choice().name, "mesh");
}

TEST(Pace, followsTheClockAndIsSlowOnSlowMachines) {
  Pace pace;
  int sum = 0;
  for (int i = 0; i < 30; ++i) sum += pace.ticksDue(1.0 / 30.0);
  EXPECT_NEAR(sum, 60, 1);
  pace.speed = 0.25;
  sum = 0;
  for (int i = 0; i < 30; ++i) sum += pace.ticksDue(1.0 / 30.0);
  EXPECT_NEAR(sum, 15, 1);
  EXPECT_LE(pace.ticksDue(1000.0), 5);
  EXPECT_EQ(slowerThan(slowerThan(slowerThan(1.0))), 1.0);
}

TEST(OrbitCamera, raysGoThroughThePixelsOfPlaces) {
  const OrbitCamera camera = orbitOf({3, 2, 5}, {0.5, 0.2, -0.1});
  EXPECT_TRUE(camera.eye().isApprox(Eigen::Vector3d(3, 2, 5), 1e-12));
  const Eigen::Vector3d place(1.0, 0.5, 0.3);
  const Pixel pixel = *camera.pixelOf(place, kSize);
  const Ray ray = camera.ray(pixel, kSize);
  EXPECT_LT((place - ray.origin).cross(ray.direction).norm(), 1e-12);
  EXPECT_FALSE(camera.pixelOf(Eigen::Vector3d(6, 4, 10), kSize));
}

TEST(OrbitCamera, panningMovesThePlaceUnderTheMouseWithIt) {
  const OrbitCamera camera = orbitOf({0, 3, 5}, {0, 0, 0});
  const OrbitCamera moved = panned(camera, {40, -30}, kSize);
  const Pixel pixel = *moved.pixelOf(camera.target, kSize);
  EXPECT_NEAR(pixel.x, 640 + 40, 0.01);
  EXPECT_NEAR(pixel.y, 360 - 30, 0.01);
  EXPECT_LT(zoomed(camera, 3).distance, camera.distance);
}

TEST(Window, aProgramWithoutItNamesThePackages) {
  try {
    runWindow({});
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("libglfw3-dev and libimgui-dev"), std::string::npos);
  }
}

}  // namespace
}  // namespace limber::demo

#include <limber/limber.h>
#include <limber/render/gl_context.h>
#include <limber/render/png_file.h>
#include <limber/view/rigid_view.h>
#include <limber/view/soft_view.h>

void drawWorld(btDiscreteDynamicsWorld& world, limber::SoftBodySystem& soft) {
  using namespace limber;
  auto context = render::createContext();  // or adoptContext(glfwGetProcAddress) in a window of your own
  render::Renderer renderer(*context);
  view::SoftView softBodies(renderer, soft);
  view::RigidView rigidBodies(renderer, world);
  const render::Vec3 low{-2, 0, -2}, high{2, 2, 2};  // what to look at
  const render::Camera camera = render::frameBox(low, high, {0.5f, 0.4f, 1.0f}, 16.0f / 9.0f);

  for (int i = 0; i < 100; ++i) {
    world.stepSimulation(1.f / 144.f);
    softBodies.update();  // bodies may come and go
    rigidBodies.update();
    render::FrameWriter frame = renderer.beginFrame();
    softBodies.write(frame, soft.tickFraction());  // straight into memory that the GPU reads
    rigidBodies.write(frame, soft.tickFraction());
    renderer.draw(frame, camera, render::lightBox(low, high));
  }
  render::writePng("world.png", renderer.readPixels());  // or renderer.blitTo(0, 0, 0, width, height)
}

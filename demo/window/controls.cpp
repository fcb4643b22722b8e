// SPDX-License-Identifier: Zlib
#include "window/controls.h"

#include "scenes/scene_list.h"

#include <algorithm>
#include <cmath>

namespace limber::demo {
namespace {

constexpr double kLeastCut = 8.0;  // pixels: a shorter line is a slip

/// Returns the name of the scene after this one in the list. The scene of a mesh needs its file.
std::string nextSceneName(const SceneChoice& choice) {
  const auto& list = scenes::sceneList();
  std::size_t i = 0;
  while (i < list.size() && list[i].name != choice.name) ++i;
  do {
    i = (i + 1) % list.size();
  } while (std::string(list[i].name) == "mesh");
  return list[i].name;
}

Command plain(Action action) { return {action, {}, {}}; }

}  // namespace

const std::array<KeyInfo, kKeyCount>& keyList() {
  static const std::array<KeyInfo, kKeyCount> list = {{{' ', "Space", "pause"},
                                                       {'.', ".", "one tick, while paused"},
                                                       {'M', "M", "slow motion: 1, 1/4, 1/16"},
                                                       {'R', "R", "restart"},
                                                       {'N', "N", "next scene"},
                                                       {'B', "B", "shoot a ball at the mouse"},
                                                       {'P', "P", "pin or unpin the point at the mouse"},
                                                       {'C', "C", "camera as at first"},
                                                       {'H', "H", "hide the panel"},
                                                       {'Q', "Q", "close"},
                                                       {kEscape, "Esc", "close"}}};
  return list;
}

void Controls::press(Button button, Modifiers modifiers) {
  if (drag_ != Drag::None) return;
  last_ = start_ = mouse_;
  button_ = button;
  if (button == Button::Middle || (button == Button::Right && modifiers.shift))
    drag_ = Drag::Pan;
  else if (button == Button::Right)
    drag_ = Drag::Orbit;
  else if (session_.layout(size_).isSecond(mouse_))
    drag_ = Drag::Orbit;
  else if (modifiers.control)
    drag_ = Drag::Cut;
  else
    grabOrOrbit();
}

// Both views have the same camera. A drag goes on beyond the view in which it began.
Ray Controls::rayThrough(Pixel pixel) const {
  const ViewLayout layout = session_.layout(size_);
  const bool second = layout.isSecond(drag_ == Drag::None ? pixel : start_);
  return session_.camera().ray(second ? layout.inSecond(pixel) : layout.inFirst(pixel), layout.view);
}

void Controls::grabOrOrbit() {
  session_.perform(rayCommand(Action::Grab, mouseRay()));
  drag_ = session_.hand().holds() ? Drag::Body : Drag::Orbit;
}

void Controls::release(Button button) {
  if (drag_ == Drag::None || button != button_) return;
  finishMovement();
  if (drag_ == Drag::Body) session_.perform(plain(Action::Release));
  if (drag_ == Drag::Cut) cut();
  drag_ = Drag::None;
}

void Controls::finishMovement() {
  const Pixel moved{mouse_.x - last_.x, mouse_.y - last_.y};
  last_ = mouse_;
  if (moved.x == 0.0 && moved.y == 0.0) return;
  const OrbitCamera& camera = session_.camera();
  if (drag_ == Drag::Body) session_.perform(rayCommand(Action::Drag, mouseRay()));
  if (drag_ == Drag::Orbit) session_.perform(cameraCommand(orbited(camera, moved, size_)));
  if (drag_ == Drag::Pan) session_.perform(cameraCommand(panned(camera, moved, size_)));
}

void Controls::cut() {
  if (std::hypot(mouse_.x - start_.x, mouse_.y - start_.y) < kLeastCut) return;
  const Ray from = rayThrough(start_), to = mouseRay();
  Command command = rayCommand(Action::Cut, from);
  command.numbers.insert(command.numbers.end(), {to.direction.x(), to.direction.y(), to.direction.z()});
  session_.perform(command);
}

void Controls::scroll(double steps) { session_.perform(cameraCommand(zoomed(session_.camera(), steps))); }

void Controls::press(char key) {
  for (std::size_t i = 0; i < kLayerCount; ++i) {
    const LayerInfo& layer = layerList()[i];
    if (key != layer.key) continue;
    const bool shown = session_.shows(static_cast<Layer>(i));
    session_.perform({Action::Show, {shown ? 0.0 : 1.0}, layer.name});
  }
  switch (key) {
    case ' ':
      session_.perform({Action::Pause, {session_.pace().paused ? 0.0 : 1.0}, {}});
      break;
    case '.':
      session_.perform(plain(Action::Tick));
      break;
    case 'M':
      session_.perform({Action::Speed, {slowerThan(session_.pace().speed)}, {}});
      break;
    case 'R':
      session_.perform(plain(Action::Restart));
      break;
    case 'N':
      session_.perform({Action::Scene, {}, nextSceneName(session_.choice())});
      break;
    case 'B':
      session_.perform(rayCommand(Action::Shoot, mouseRay()));
      break;
    case 'P':
      session_.perform(rayCommand(Action::Pin, mouseRay()));
      break;
    case 'C':
      session_.perform(cameraCommand(framedCamera(session_.scene(), session_.layout(size_).view)));
      break;
    case 'Q':
    case kEscape:
      quit_ = true;
      break;
    default:
      break;
  }
}

std::optional<std::array<Pixel, 2>> Controls::cutLine() const {
  if (drag_ != Drag::Cut) return std::nullopt;
  return std::array<Pixel, 2>{start_, mouse_};
}

}  // namespace limber::demo

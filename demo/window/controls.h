// SPDX-License-Identifier: Zlib
#pragma once

#include "window/orbit_camera.h"
#include "window/session.h"

#include <array>
#include <optional>

namespace limber::demo {

enum class Button { Left, Middle, Right };

struct Modifiers {
  bool shift = false, control = false;
};

constexpr char kEscape = '\x1b';

/// A key and what it does. Letters are upper case, as on keyboards.
struct KeyInfo {
  char key;
  const char* name;
  const char* about;
};
constexpr std::size_t kKeyCount = 11;
/// All keys except those of layers.
const std::array<KeyInfo, kKeyCount>& keyList();

/// Makes commands from mouse and keyboard. It knows no window, so tests can play with it.
class Controls {
 public:
  Controls(Session& session, const WindowSize& size) : session_(session), size_(size) {}

  void resize(const WindowSize& size) { size_ = size; }

  /// The mouse is at the pixel of the last move().
  void move(Pixel pixel) { mouse_ = pixel; }
  void press(Button button, Modifiers modifiers);
  void release(Button button);
  void scroll(double steps);
  void press(char key);

  /// Performs the movement of the mouse so far. Call it once a frame.
  void finishMovement();

  /// Returns the line of the cut that is being drawn.
  std::optional<std::array<Pixel, 2>> cutLine() const;
  bool wantsToQuit() const { return quit_; }

 private:
  enum class Drag { None, Body, Orbit, Pan, Cut };

  Ray rayThrough(Pixel pixel) const;
  Ray mouseRay() const { return rayThrough(mouse_); }
  void grabOrOrbit();
  void cut();

  Session& session_;
  WindowSize size_;
  Drag drag_ = Drag::None;
  Button button_ = Button::Left;  // that drags
  Pixel mouse_, last_, start_;    // at present, at the last movement, where the drag began
  bool quit_ = false;
};

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#pragma once

#include "window/controls.h"
#include "window/orbit_camera.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

struct GLFWwindow;

namespace limber::demo {

/// A window with an OpenGL context, mouse, keyboard and ImGui. There is at most one.
class Window {
 public:
  /// Throws std::runtime_error with the reason, for example without a display.
  Window(const WindowSize& size, const std::string& title);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Begins a frame of ImGui and hands the events since the last one to the controls, except those that are
  /// for the panel. Without `interactive` only the keys that close the window count, as in a replay.
  void beginFrame(Controls& controls, bool interactive);
  /// Draws the panel over the picture; the window still shows the last frame.
  void drawPanel();
  void show();

  bool closed() const;
  void setTitle(const std::string& title);
  WindowSize size() const;  ///< of the mouse's coordinates
  WindowSize framebufferSize() const;
  static void* functionAddress(const char* name);

 private:
  /// One event of mouse or keyboard.
  struct Event {
    enum class Kind { Press, Release, Move, Scroll, Key } kind;
    Button button = Button::Left;
    Modifiers modifiers;
    Pixel pixel;
    double steps = 0.0;
    char key = 0;
  };

  void open(const WindowSize& size, const std::string& title);
  void listen();
  void openImGui();
  std::size_t eventsOfFrame() const;
  void tellImGui(std::size_t count);
  void handle(const Event& event, Controls& controls) const;

  GLFWwindow* window_ = nullptr;
  std::vector<Event> events_;
  Pixel mouse_, told_;             // at the last event, as ImGui knows it
  std::array<bool, 3> pressed_{};  // buttons, as ImGui knows them
  std::string title_;
};

}  // namespace limber::demo

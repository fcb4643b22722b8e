// SPDX-License-Identifier: Zlib
#include "window/window.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace limber::demo {
namespace {

[[noreturn]] void throwGlfwError(const std::string& what) {
  const char* reason = nullptr;
  glfwGetError(&reason);
  throw std::runtime_error(what + ": " + (reason ? reason : "unknown reason"));
}

std::optional<Button> buttonOf(int button) {
  if (button == GLFW_MOUSE_BUTTON_LEFT) return Button::Left;
  if (button == GLFW_MOUSE_BUTTON_MIDDLE) return Button::Middle;
  if (button == GLFW_MOUSE_BUTTON_RIGHT) return Button::Right;
  return std::nullopt;
}

/// GLFW's codes of letters, digits and the like are those of ASCII.
char keyOf(int key) {
  if (key == GLFW_KEY_ESCAPE) return kEscape;
  return key >= 32 && key < 127 ? static_cast<char>(key) : '\0';
}

constexpr int kImGuiButtons[] = {ImGuiMouseButton_Left, ImGuiMouseButton_Middle,
                                 ImGuiMouseButton_Right};  // of Button

bool closes(char key) { return key == 'Q' || key == kEscape; }

/// GLFW gives its callbacks a window.
Window& owner(GLFWwindow* window) { return *static_cast<Window*>(glfwGetWindowUserPointer(window)); }

}  // namespace

Window::Window(const WindowSize& size, const std::string& title) : title_(title) {
  if (!glfwInit()) throwGlfwError("cannot open a window");
  try {
    open(size, title);
    listen();
    openImGui();
  } catch (...) {
    glfwTerminate();
    throw;
  }
}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void Window::open(const WindowSize& size, const std::string& title) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);  // the renderer has its own
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  window_ = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
  if (!window_) throwGlfwError("cannot open a window with OpenGL 4.5");
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
}

void Window::openImGui() {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // no file is written
  ImGui::StyleColorsDark();
  ImGui::GetStyle().WindowRounding = 4.0f;
  ImGui::GetStyle().Colors[ImGuiCol_WindowBg].w = 0.88f;
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 450 core");
}

// --- events ------------------------------------------------------------------------------------------------

// ImGui calls these before its own. A position is that of the last movement: GLFW would tell where the mouse
// is now, after the movements that still wait. The events wait for the next frame, when ImGui knows what the
// mouse is over.
void Window::listen() {
  glfwSetWindowUserPointer(window_, this);
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int code, int action, int modifiers) {
    const std::optional<Button> button = buttonOf(code);
    if (!button) return;
    Event event{action == GLFW_PRESS ? Event::Kind::Press : Event::Kind::Release, *button, {}, {}};
    event.modifiers = {(modifiers & GLFW_MOD_SHIFT) != 0, (modifiers & GLFW_MOD_CONTROL) != 0};
    event.pixel = owner(window).mouse_;
    owner(window).events_.push_back(event);
  });
  glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
    owner(window).mouse_ = {x, y};
    owner(window).events_.push_back({Event::Kind::Move, {}, {}, {x, y}});
  });
  glfwSetScrollCallback(window_, [](GLFWwindow* window, double, double steps) {
    owner(window).events_.push_back({Event::Kind::Scroll, {}, {}, owner(window).mouse_, steps});
  });
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int) {
    const bool counts = action == GLFW_PRESS || (action == GLFW_REPEAT && keyOf(key) == '.');
    if (!counts || keyOf(key) == '\0') return;
    owner(window).events_.push_back({Event::Kind::Key, {}, {}, owner(window).mouse_, 0.0, keyOf(key)});
  });
}

/// A frame ends with a press or release, and before a release that follows a movement: sliders move only
/// while the button is down. So a press and a movement count where they happened, however long a frame takes.
std::size_t Window::eventsOfFrame() const {
  bool moved = false, clicked = false;
  for (std::size_t i = 0; i < events_.size(); ++i) {
    const Event::Kind kind = events_[i].kind;
    if (kind == Event::Kind::Key) continue;
    if (clicked || (moved && kind == Event::Kind::Release)) return i;
    moved = moved || kind == Event::Kind::Move;
    clicked = kind == Event::Kind::Press || kind == Event::Kind::Release;
  }
  return events_.size();
}

/// Before 1.87 ImGui asks GLFW where the mouse is now; later versions keep the order of events themselves.
void Window::tellImGui(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const Event& event = events_[i];
    told_ = event.pixel;
    if (event.kind == Event::Kind::Press) pressed_[static_cast<std::size_t>(event.button)] = true;
    if (event.kind == Event::Kind::Release) pressed_[static_cast<std::size_t>(event.button)] = false;
  }
#if IMGUI_VERSION_NUM < 18700
  ImGuiIO& io = ImGui::GetIO();
  io.MousePos = {static_cast<float>(told_.x), static_cast<float>(told_.y)};
  for (const Button button : {Button::Left, Button::Middle, Button::Right})
    io.MouseDown[kImGuiButtons[static_cast<std::size_t>(button)]] =
        pressed_[static_cast<std::size_t>(button)];
#endif
}

void Window::beginFrame(Controls& controls, bool interactive) {
  glfwPollEvents();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  const std::size_t count = eventsOfFrame();
  tellImGui(count);
  ImGui::NewFrame();
  controls.resize(size());
  for (std::size_t i = 0; i < count; ++i)
    if (interactive || closes(events_[i].key)) handle(events_[i], controls);
  events_.erase(events_.begin(), events_.begin() + static_cast<std::ptrdiff_t>(count));
  controls.finishMovement();
}

void Window::handle(const Event& event, Controls& controls) const {
  const ImGuiIO& io = ImGui::GetIO();
  controls.move(event.pixel);
  switch (event.kind) {
    case Event::Kind::Press:
      if (!io.WantCaptureMouse) controls.press(event.button, event.modifiers);
      break;
    case Event::Kind::Release:
      controls.release(event.button);
      break;
    case Event::Kind::Move:
      break;
    case Event::Kind::Scroll:
      if (!io.WantCaptureMouse) controls.scroll(event.steps);
      break;
    case Event::Kind::Key:
      if (!io.WantTextInput) controls.press(event.key);
      break;
  }
}

// --- pictures ----------------------------------------------------------------------------------------------

void Window::drawPanel() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Window::show() { glfwSwapBuffers(window_); }

// --- the window --------------------------------------------------------------------------------------------

bool Window::closed() const { return glfwWindowShouldClose(window_) != 0; }

void Window::setTitle(const std::string& title) {
  if (title == title_) return;
  title_ = title;
  glfwSetWindowTitle(window_, title.c_str());
}

WindowSize Window::size() const {
  WindowSize size;
  glfwGetWindowSize(window_, &size.width, &size.height);
  return {std::max(size.width, 1), std::max(size.height, 1)};
}

WindowSize Window::framebufferSize() const {
  WindowSize size;
  glfwGetFramebufferSize(window_, &size.width, &size.height);
  return {std::max(size.width, 1), std::max(size.height, 1)};
}

void* Window::functionAddress(const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); }

}  // namespace limber::demo

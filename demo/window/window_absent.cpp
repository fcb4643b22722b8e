// SPDX-License-Identifier: Zlib
// Takes the place of the window where GLFW or ImGui was missing when the demo was configured.
#include "window/run_window.h"

#include <stdexcept>

namespace limber::demo {

ExitCode runWindow(const DemoOptions&) {
  throw std::runtime_error(
      "this program was built without its window: install the Debian packages libglfw3-dev and libimgui-dev, "
      "configure again with CMake and build");
}

}  // namespace limber::demo

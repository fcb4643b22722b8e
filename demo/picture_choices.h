// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <string>

namespace limber::demo {

/// These parse what follows an option and return why it cannot be used, or an empty string.

/// auto, orbit, or six numbers with commas: where the eye is and where it looks.
std::string parseCamera(const std::string& text, CameraChoice& choice);

/// none, or some of contacts, velocities, boxes and constraints with commas.
std::string parseOverlay(const std::string& text, OverlayChoice& choice);

/// auto, osmesa, egl, egl:N for the Nth EGL device, or surfaceless for EGL without devices.
std::string parseContext(const std::string& text, render::ContextDesc& desc);

}  // namespace limber::demo

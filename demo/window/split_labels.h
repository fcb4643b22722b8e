// SPDX-License-Identifier: Zlib
#pragma once

#include "window/history.h"
#include "window/session.h"

namespace limber::demo {

/// Writes over each view of the split whose it is, with the panel also the time of a tick, energy and
/// stretch; and over the right one why btSoftBody does not play the scene. Between ImGui::NewFrame() and
/// ImGui::Render().
void drawSplitLabels(const Session& session, const History& history, const WindowSize& window);

}  // namespace limber::demo

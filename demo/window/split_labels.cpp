// SPDX-License-Identifier: Zlib
#include "window/split_labels.h"

#include <imgui.h>

#include <cstdio>
#include <string>

namespace limber::demo {
namespace {

constexpr float kLabelMargin = 8.0f;  // pixels
constexpr ImU32 kLabelText = IM_COL32(25, 28, 34, 255), kLabelBack = IM_COL32(245, 245, 245, 190);
constexpr ImU32 kStripColour = IM_COL32(205, 209, 214, 255);

void drawLabel(float x, const std::string& text) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  list.AddRectFilled({x, kLabelMargin}, {x + size.x + 8.0f, kLabelMargin + size.y + 6.0f}, kLabelBack, 3.0f);
  list.AddText({x + 4.0f, kLabelMargin + 3.0f}, kLabelText, text.c_str());
}

std::string textOf(const char* name, double ms, const bullet_soft::SpringFigures& figures) {
  char text[200];
  std::snprintf(text, sizeof text,
                "%s, %.2f ms a tick\nstretch %.2f %%, at most %.1f %%\nkinetic %.3g J, springs %.3g J", name,
                ms, 100.0 * figures.stretch, 100.0 * figures.largest, figures.kinetic, figures.elastic);
  return text;
}

/// Hides what is left of an older picture, and says why there is none.
void drawProblem(const std::string& problem, float low, float high, float bottom) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddRectFilled({low, 0.0f}, {high, bottom}, kStripColour);
  const std::string text = problem + ".\nThis half is empty instead of wrong.";
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  list.AddText({0.5f * (low + high - size.x), 0.5f * (bottom - size.y)}, kLabelText, text.c_str());
}

}  // namespace

void drawSplitLabels(const Session& session, const History& history, const WindowSize& window) {
  const ViewLayout layout = session.layout(window);
  if (!layout.split) return;
  const auto left = static_cast<float>(layout.left), width = static_cast<float>(layout.view.width);
  const auto right = static_cast<float>(window.width), bottom = static_cast<float>(window.height);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  if (layout.left > 0) list.AddRectFilled({0.0f, 0.0f}, {left, bottom}, kStripColour);
  if (const std::string problem = session.bulletProblem(); !problem.empty()) {
    drawProblem(problem, left + width, right, bottom);
    return drawLabel(left + kLabelMargin, "Limber");
  }
  list.AddLine({left + width, 0.0f}, {left + width, bottom}, kLabelText, 2.0f);
  const bullet_soft::BulletTwin& twin = *session.bulletTwin();
  if (!session.shows(Layer::Panel)) {
    drawLabel(left + kLabelMargin, "Limber");
    return drawLabel(left + width + kLabelMargin, "btSoftBody");
  }
  drawLabel(left + kLabelMargin, textOf("Limber", history.meanMs(), twin.figuresOf(session.scene())));
  drawLabel(left + width + kLabelMargin, textOf("btSoftBody", history.meanTwinMs(), twin.figures()));
}

}  // namespace limber::demo

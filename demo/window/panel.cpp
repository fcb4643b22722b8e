// SPDX-License-Identifier: Zlib
// Collects the figures of a session, and draws them with ImGui.

#include "window/panel.h"

#include "scenes/scene_list.h"

#include <imgui.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>

namespace limber::demo {

// --- figures -----------------------------------------------------------------------------------------------

TickSample sampleOf(const scenes::TickTimes& times, const Diagnostics& bodies) {
  const TickProfile& soft = times.soft;
  const double parts[kTickParts] = {soft.stepMs, soft.searchMs + soft.islandsMs,
                                    soft.readMs + soft.chooseMs + soft.writeMs + soft.readBackMs,
                                    std::max(times.total - soft.totalMs(), 0.0)};
  TickSample sample;
  for (std::size_t i = 0; i < kTickParts; ++i) sample.ms[i] = static_cast<float>(parts[i]);
  sample.totalMs = static_cast<float>(times.total);
  if (soft.awakeBodies > 0)
    sample.substeps = static_cast<float>(soft.substeps) / static_cast<float>(soft.awakeBodies);
  sample.energy = {static_cast<float>(bodies.kinetic), static_cast<float>(bodies.elastic),
                   static_cast<float>(bodies.potential)};
  sample.errorMm = static_cast<float>(1e3 * bodies.error);
  return sample;
}

void History::add(const TickSample& sample) {
  samples_.push_back(sample);
  if (samples_.size() > kLength) samples_.pop_front();
}

double History::mean(float TickSample::*value) const {
  const std::size_t count = std::min(samples_.size(), static_cast<std::size_t>(scenes::kTicksPerSecond));
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) sum += double(samples_[samples_.size() - 1 - i].*value);
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

// --- labels ------------------------------------------------------------------------------------------------

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

// --- the panel ---------------------------------------------------------------------------------------------

namespace {

constexpr float kPanelWidth = 310.0f, kPanelMargin = 8.0f;  // pixels
constexpr float kPlotHeight = 56.0f;
constexpr ImU32 kPartColours[kTickParts] = {IM_COL32(229, 115, 72, 255), IM_COL32(94, 155, 214, 255),
                                            IM_COL32(156, 196, 104, 255), IM_COL32(150, 150, 158, 255)};
constexpr ImU32 kEnergyColours[3] = {IM_COL32(229, 115, 72, 255), IM_COL32(94, 155, 214, 255),
                                     IM_COL32(190, 190, 120, 255)};

void drawPlayback(Session& session, Controls& controls) {
  const Pace& pace = session.pace();
  if (ImGui::Button(pace.paused ? "play" : "pause")) controls.press(' ');
  ImGui::SameLine();
  if (ImGui::Button("tick")) controls.press('.');
  ImGui::SameLine();
  if (ImGui::Button("restart")) controls.press('R');
  ImGui::SameLine();
  if (ImGui::Button("next scene")) controls.press('N');
  ImGui::SameLine();
  char speed[32];
  std::snprintf(speed, sizeof speed, "x %.3g###speed", pace.speed);
  if (ImGui::Button(speed)) controls.press('M');
  ImGui::SetNextItemWidth(-1.0f);
  if (!ImGui::BeginCombo("##scene", session.choice().name.c_str())) return;
  std::string chosen;
  for (const scenes::SceneEntry& entry : scenes::sceneList()) {
    if (std::string(entry.name) == "mesh") continue;
    if (ImGui::Selectable(entry.name, session.choice().name == entry.name)) chosen = entry.name;
  }
  ImGui::EndCombo();
  if (!chosen.empty()) session.perform({Action::Scene, {}, chosen});
}

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

void drawFigures(const Session& session, const History& history, const FrameFigures& figures) {
  const TickProfile& profile = session.scene().soft->profile();
  ImGui::Text("%.0f frames/s, draw %.1f ms, tick %.2f ms", figures.framesPerSecond, figures.drawMs,
              history.meanMs());
  ImGui::Text("%s, %zu awake, %s", counted(session.scene().soft->bodyCount(), "body", "bodies").c_str(),
              profile.awakeBodies, counted(scenes::pointCount(session.scene()), "point", "points").c_str());
  ImGui::Text("%s, %s, tick %lld", counted(profile.contacts, "contact", "contacts").c_str(),
              counted(profile.islands, "coupled island", "coupled islands").c_str(),
              static_cast<long long>(session.ticks()));
}

void drawLayers(Session& session) {
  for (std::size_t i = 0; i < kLayerCount; ++i) {
    if (static_cast<Layer>(i) == Layer::Panel) continue;
    const LayerInfo& info = layerList()[i];
    bool shown = session.shows(static_cast<Layer>(i));
    if (i % 3 != 0) ImGui::SameLine(105.0f * static_cast<float>(i % 3) + kPanelMargin);
    if (ImGui::Checkbox(info.name, &shown)) session.perform({Action::Show, {shown ? 1.0 : 0.0}, info.name});
  }
}

/// A frame for a plot, with a caption in it.
struct PlotArea {
  ImVec2 low, high;

  explicit PlotArea(const char* caption) : low(ImGui::GetCursorScreenPos()) {
    high = {low.x + ImGui::GetContentRegionAvail().x, low.y + kPlotHeight};
    ImGui::GetWindowDrawList()->AddRectFilled(low, high, IM_COL32(20, 22, 26, 255));
    ImGui::Dummy({high.x - low.x, kPlotHeight});
    caption_ = caption;
  }
  ~PlotArea() {
    ImGui::GetWindowDrawList()->AddText({low.x + 4.0f, low.y + 2.0f}, IM_COL32(235, 235, 235, 255),
                                        caption_.c_str());
  }
  PlotArea(const PlotArea&) = delete;
  PlotArea& operator=(const PlotArea&) = delete;

  float x(std::size_t i) const {
    return low.x + (high.x - low.x) * static_cast<float>(i) / static_cast<float>(History::kLength - 1);
  }
  /// `share` of the height, from the bottom.
  float y(float share) const { return high.y - (kPlotHeight - 16.0f) * std::clamp(share, 0.0f, 1.0f); }

 private:
  std::string caption_;
};

/// Returns the next of 1, 2, 5, 10, ... so that the scale of a plot seldom changes.
float roundedUp(float value) {
  if (value <= 0.0f) return 1.0f;
  const float power = std::pow(10.0f, std::floor(std::log10(std::max(value, 1e-6f))));
  for (const float step : {1.0f, 2.0f, 5.0f})
    if (value <= step * power) return step * power;
  return 10.0f * power;
}

void drawNames(const char* const* names, const ImU32* colours, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) ImGui::SameLine();
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(colours[i]), "%s", names[i]);
  }
}

/// Columns of the parts of each tick, stacked.
void drawTickPlot(const History& history) {
  float top = 0.0f;
  for (const TickSample& sample : history.samples()) top = std::max(top, sample.totalMs);
  top = roundedUp(top);
  char caption[48];
  std::snprintf(caption, sizeof caption, "tick, 0 to %.3g ms", static_cast<double>(top));
  {
    const PlotArea area(caption);
    for (std::size_t i = 0; i < history.samples().size(); ++i) {
      float below = 0.0f;
      for (std::size_t part = 0; part < kTickParts; ++part) {
        const float above = below + history.samples()[i].ms[part] / top;
        ImGui::GetWindowDrawList()->AddRectFilled({area.x(i), area.y(above)},
                                                  {area.x(i) + 1.3f, area.y(below)}, kPartColours[part]);
        below = above;
      }
    }
  }
  drawNames(kTickPartNames.data(), kPartColours, kTickParts);
}

/// Lines of values from 0 or the smallest to the largest.
void drawLinePlot(const History& history, const std::string& what, const char* unit, std::size_t count,
                  const ImU32* colours, const std::function<float(const TickSample&, std::size_t)>& value) {
  float low = 0.0f, top = 0.0f;
  for (const TickSample& sample : history.samples()) {
    for (std::size_t k = 0; k < count; ++k) {
      low = std::min(low, value(sample, k));
      top = std::max(top, value(sample, k));
    }
  }
  top = roundedUp(top);
  char range[48];
  std::snprintf(range, sizeof range, ", 0 to %.3g%s", static_cast<double>(top), unit);
  const PlotArea area((what + range).c_str());
  for (std::size_t k = 0; k < count; ++k) {
    std::vector<ImVec2> line;
    for (std::size_t i = 0; i < history.samples().size(); ++i)
      line.emplace_back(area.x(i), area.y((value(history.samples()[i], k) - low) / (top - low)));
    ImGui::GetWindowDrawList()->AddPolyline(line.data(), static_cast<int>(line.size()), colours[k], 0, 1.0f);
  }
}

void drawPlots(const History& history) {
  drawTickPlot(history);
  drawLinePlot(history, "substeps a body", "", 1, kPartColours,
               [](const TickSample& sample, std::size_t) { return sample.substeps; });
  drawLinePlot(history, "error estimate", " mm/s", 1, kPartColours,
               [](const TickSample& sample, std::size_t) { return sample.errorMm; });
  drawLinePlot(history, "energy", " J", 3, kEnergyColours,
               [](const TickSample& sample, std::size_t k) { return sample.energy[k]; });
  const char* const names[3] = {"kinetic", "elastic", "potential"};
  drawNames(names, kEnergyColours, 3);
}

void drawHelp() {
  ImGui::TextUnformatted(
      "left drag: pull a body, else orbit\n"
      "right drag: orbit   middle drag: pan\n"
      "wheel: zoom   Ctrl + left drag: cut");
  for (const KeyInfo& info : keyList()) ImGui::Text("%-5s  %s", info.name, info.about);
  for (const LayerInfo& layer : layerList()) ImGui::Text("%-5c  %s", layer.key, layer.name);
}

const char* formatOf(const SettingInfo& info) {
  return info.whole ? "%.0f" : info.logarithmic ? "%.3g" : "%.2f";
}

}  // namespace

void Panel::drawSetting(Session& session, std::size_t setting) {
  const SettingInfo& info = settingList()[setting];
  float value = static_cast<float>(session.settings().values[setting]);
  const ImGuiSliderFlags flags =
      ImGuiSliderFlags_AlwaysClamp | (info.logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
  const bool moved = ImGui::SliderFloat(info.label, &value, static_cast<float>(info.low),
                                        static_cast<float>(info.high), formatOf(info), flags);
  const ImVec2 low = ImGui::GetItemRectMin(), size{ImGui::CalcItemWidth(), ImGui::GetItemRectSize().y};
  sliders_.push_back({info.name, double(low.x), double(low.y), double(size.x), double(size.y)});
  if (!moved) return;
  const double number =
      std::clamp(info.whole ? std::round(double(value)) : double(value), info.low, info.high);
  session.perform({Action::Set, {number}, info.name});
}

void Panel::drawSettings(Session& session, bool ofBullet) {
  ImGui::PushItemWidth(170.0f);
  for (std::size_t i = 0; i < kSettingCount; ++i)
    if (isOfBullet(static_cast<Setting>(i)) == ofBullet) drawSetting(session, i);
  ImGui::PopItemWidth();
}

void Panel::drawBulletSettings(Session& session) {
  drawSettings(session, true);
  if (!session.bulletTwin()) return;
  std::string without;
  for (const std::string& note : session.bulletTwin()->notes())
    without += (without.empty() ? "" : ", ") + note;
  if (!without.empty()) ImGui::TextWrapped("%s", without.c_str());
}

void Panel::draw(Session& session, Controls& controls, const History& history, const FrameFigures& figures,
                 bool interactive) {
  ImGui::SetNextWindowPos({kPanelMargin, kPanelMargin}, ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize({kPanelWidth, 0.0f}, ImGuiCond_Always);
  if (ImGui::Begin("Limber", nullptr, ImGuiWindowFlags_NoResize)) {
    ImGui::BeginDisabled(!interactive);
    drawPlayback(session, controls);
    drawFigures(session, history, figures);
    sliders_.clear();
    if (ImGui::CollapsingHeader("settings", ImGuiTreeNodeFlags_DefaultOpen)) drawSettings(session, false);
    if (session.shows(Layer::Split) && ImGui::CollapsingHeader("btSoftBody", ImGuiTreeNodeFlags_DefaultOpen))
      drawBulletSettings(session);
    if (ImGui::CollapsingHeader("show", ImGuiTreeNodeFlags_DefaultOpen)) drawLayers(session);
    if (ImGui::CollapsingHeader("plots", ImGuiTreeNodeFlags_DefaultOpen)) drawPlots(history);
    if (ImGui::CollapsingHeader("keys")) drawHelp();
    ImGui::EndDisabled();
    if (!message_.empty()) ImGui::TextWrapped("%s", message_.c_str());
  }
  ImGui::End();
}

std::vector<SliderPlace> Panel::takeMovedSliders() {
  const auto same = [](const SliderPlace& a, const SliderPlace& b) {
    return a.name == b.name && a.x == b.x && a.y == b.y && a.width == b.width && a.height == b.height;
  };
  if (std::equal(sliders_.begin(), sliders_.end(), reported_.begin(), reported_.end(), same)) return {};
  reported_ = sliders_;
  return sliders_;
}

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
// The figures of a session, and what ImGui draws of them: the panel, and labels over the views of the split.
#pragma once

#include "scenes/scene.h"
#include "window/controls.h"
#include "window/session.h"

#include <array>
#include <cstddef>
#include <deque>
#include <string>
#include <vector>

namespace limber::demo {

// --- figures -----------------------------------------------------------------------------------------------

/// The parts of a tick that the plot shows, as TickProfile has them.
constexpr std::size_t kTickParts = 4;
constexpr std::array<const char*, kTickParts> kTickPartNames = {"springs", "contacts", "exchange", "Bullet"};

/// The figures of one tick.
struct TickSample {
  std::array<float, kTickParts> ms{};
  float totalMs = 0.0f;
  float twinMs = 0.0f;            ///< of btSoftBody, with the split
  float substeps = 0.0f;          ///< mean of the awake bodies
  float errorMm = 0.0f;           ///< mm/s, largest SoftBody::errorPerSecond()
  std::array<float, 3> energy{};  ///< J: kinetic, elastic, potential
};

TickSample sampleOf(const scenes::TickTimes& times, const Diagnostics& bodies);

/// The last ticks, for plots.
class History {
 public:
  static constexpr std::size_t kLength = 240;  // ticks

  void add(const TickSample& sample);
  void clear() { samples_.clear(); }
  const std::deque<TickSample>& samples() const { return samples_; }
  /// Returns the mean duration of a tick in the last second, ms.
  double meanMs() const { return mean(&TickSample::totalMs); }
  /// The same of btSoftBody.
  double meanTwinMs() const { return mean(&TickSample::twinMs); }

 private:
  double mean(float TickSample::*value) const;

  std::deque<TickSample> samples_;
};

// --- labels ------------------------------------------------------------------------------------------------

/// Writes over each view of the split whose it is, with the panel also the time of a tick, energy and
/// stretch; and over the right one why btSoftBody does not play the scene. Between ImGui::NewFrame() and
/// ImGui::Render().
void drawSplitLabels(const Session& session, const History& history, const WindowSize& window);

// --- the panel ---------------------------------------------------------------------------------------------

/// What the panel shows besides the session.
struct FrameFigures {
  double framesPerSecond = 0.0;
  double drawMs = 0.0;  ///< of the picture and the panel
};

/// Where a slider is, for scripts that move the mouse; pixels.
struct SliderPlace {
  std::string name;
  double x, y, width, height;
};

/// Draws the panel of ImGui. Between ImGui::NewFrame() and ImGui::Render().
class Panel {
 public:
  void draw(Session& session, Controls& controls, const History& history, const FrameFigures& figures,
            bool interactive);
  /// Returns where the sliders are, if that has changed since the last call.
  std::vector<SliderPlace> takeMovedSliders();
  /// Shows a line, until the next one.
  void setMessage(std::string message) { message_ = std::move(message); }

 private:
  void drawSetting(Session& session, std::size_t setting);
  void drawSettings(Session& session, bool ofBullet);
  void drawBulletSettings(Session& session);

  std::string message_;
  std::vector<SliderPlace> sliders_, reported_;
};

}  // namespace limber::demo

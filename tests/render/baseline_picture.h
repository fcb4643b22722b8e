// SPDX-License-Identifier: Zlib
#pragma once

#include "render/baselines/baseline.h"
#include "test_scene.h"

namespace limber::render::test {

/// Draws the stage's instances as a baseline of the bench does.
inline void drawAs(bench::Baseline& baseline, Stage& stage, const DrawOptions& options = {}) {
  stage.renderer();  // Makes its context current.
  baseline.beginFrame();
  stage.write(baseline);
  baseline.draw(stage.camera, stage.light, options);
}

inline Image pictureAs(bench::Baseline& baseline, Stage& stage, const DrawOptions& options = {}) {
  drawAs(baseline, stage, options);
  return stage.renderer().readPixels();
}

}  // namespace limber::render::test

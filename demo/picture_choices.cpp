// SPDX-License-Identifier: Zlib
#include "picture_choices.h"

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <vector>

namespace limber::demo {
namespace {

std::vector<std::string> splitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

bool parseNumber(const std::string& text, double& value) {
  char* end = nullptr;
  value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(value);
}

}  // namespace

std::string parseCamera(const std::string& text, CameraChoice& choice) {
  choice = {};
  if (text == "auto") return {};
  choice.path = text == "orbit" ? CameraPath::Orbit : CameraPath::Fixed;
  if (text == "orbit") return {};
  const std::vector<std::string> parts = splitAtCommas(text);
  double values[6] = {};
  bool good = parts.size() == 6;
  for (std::size_t i = 0; good && i < 6; ++i) good = parseNumber(parts[i], values[i]);
  if (!good) return text + " is neither auto nor orbit nor six numbers EYEX,EYEY,EYEZ,ATX,ATY,ATZ";
  choice.eye = {values[0], values[1], values[2]};
  choice.target = {values[3], values[4], values[5]};
  return choice.eye == choice.target ? text + " has the eye where it looks" : std::string();
}

std::string parseOverlay(const std::string& text, OverlayChoice& choice) {
  choice = {};
  if (text == "none") return {};
  for (const std::string& part : splitAtCommas(text)) {
    if (part == "contacts")
      choice.contacts = true;
    else if (part == "velocities")
      choice.velocities = true;
    else if (part == "boxes")
      choice.boxes = true;
    else if (part == "constraints")
      choice.constraints = true;
    else
      return "\"" + part + "\" is none of contacts, velocities, boxes, constraints";
  }
  return text.empty() ? "nothing is asked for: say none" : std::string();
}

std::string parseContext(const std::string& text, render::ContextDesc& desc) {
  desc = {};
  if (text == "auto") return {};
  desc.backend = render::Backend::Egl;
  if (text == "osmesa") desc.backend = render::Backend::OSMesa;
  if (text == "surfaceless") desc.backend = render::Backend::EglSurfaceless;
  if (text == "osmesa" || text == "egl" || text == "surfaceless") return {};
  const bool digits =
      text.size() > 4 && text.size() < 7 && text.find_first_not_of("0123456789", 4) == std::string::npos;
  if (text.rfind("egl:", 0) != 0 || !digits)
    return text + " is none of auto, osmesa, egl, egl:N, surfaceless";
  desc.eglDevice = std::atoi(text.c_str() + 4);
  return {};
}

}  // namespace limber::demo

// SPDX-License-Identifier: Zlib
#include "window/title.h"

#include "window/recording.h"

#include <sstream>

namespace limber::demo {
namespace {

void addMesh(std::ostream& out, const scenes::SceneOptions& options) {
  out << " --mesh " << options.meshFile;
  if (options.feel != scenes::Feel::Rubber) out << " --feel " << nameOf(options.feel);
  if (options.cook.points > 0) out << " --points " << options.cook.points;
  if (options.cook.mode == CookMode::Braces) out << " --braces";
  if (options.cook.pieces == PieceRule::Connected) out << " --connect";
}

void addSceneOptions(std::ostream& out, const SceneChoice& choice) {
  const scenes::SceneOptions& o = choice.options;
  if (o.meshFile.empty())
    out << " --scene " << choice.name;
  else
    addMesh(out, o);
  if (o.seed != 1) out << " --seed " << o.seed;
  if (o.count) out << " --count " << *o.count;
  if (o.stiffness) out << " --stiffness " << *o.stiffness;
  if (o.damping) out << " --damping " << *o.damping;
  if (o.mass) out << " --mass " << *o.mass;
  if (o.scale) out << " --scale " << *o.scale;
}

void addSettings(std::ostream& out, const Session& session) {
  for (std::size_t i = 0; i < kSettingCount; ++i) {
    const double value = session.settings().values[i];
    if (value != session.startSettings().values[i]) out << " --set " << settingList()[i].name << "=" << value;
  }
}

void addLayers(std::ostream& out, const Session& session) {
  if (session.shows(Layer::Strain)) out << " --mode wireframe";
  if (session.shows(Layer::Gallery)) out << " --quality gallery";
  if (session.shows(Layer::Split)) out << " --split";
  const char* before = " --overlay ";
  for (const Layer layer :
       {Layer::Contacts, Layer::Boxes, Layer::Velocities, Layer::Constraints, Layer::Islands}) {
    if (!session.shows(layer)) continue;
    out << before << layerList()[static_cast<std::size_t>(layer)].name;
    before = ",";
  }
}

void addCamera(std::ostream& out, const OrbitCamera& camera) {
  const Eigen::Vector3d eye = camera.eye(), &at = camera.target;
  out << " --camera " << eye.x() << "," << eye.y() << "," << eye.z() << "," << at.x() << "," << at.y() << ","
      << at.z();
}

}  // namespace

std::string titleOf(const Session& session) {
  const Pace& pace = session.pace();
  std::ostringstream out;
  out.precision(4);
  out << "limber-demo --window";
  addSceneOptions(out, session.choice());
  addSettings(out, session);
  addLayers(out, session);
  addCamera(out, session.camera());
  out << " - tick " << session.ticks();
  if (pace.paused) out << ", paused";
  if (!pace.paused && pace.speed != 1.0) out << ", speed " << pace.speed;
  return out.str();
}

}  // namespace limber::demo

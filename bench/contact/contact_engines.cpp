// SPDX-License-Identifier: Zlib
#include "contact/contact_engines.h"

#include "contact/contact_scene.h"
#include "engines/bare_engine.h"
#include "engines/bullet_soft_engines.h"
#include "engines/limber_engine.h"

namespace limber::bench {
namespace {

struct LimberSetting {
  const char* name;
  TuneSettings tune;
};

/// Limber's kinds of collision. A new kind is one more line here.
std::vector<LimberSetting> limberSettings() {
  return {{"limber points", [](SoftBodySettings& s) { s.collision = Collision::Points; }},
          {"limber surface", [](SoftBodySettings& s) { s.collision = Collision::Surface; }}};
}

/// Returns Limber as users have it: with the default volume term of closed bodies, which other benches omit.
ContactEngine limber(const LimberSetting& setting) {
  const auto tune = [own = setting.tune](SoftBodySettings& settings) {
    settings.volumeModulus = SoftBodySettings().volumeModulus;
    own(settings);
  };
  ContactEngine engine;
  engine.name = setting.name;
  engine.make = [tune](const ContactScene&) { return makeLimberEngine(tune); };
  engine.isOther = false;
  return engine;
}

/// Returns Limber with a budget.
ContactEngine limberWithin(int substeps) {
  ContactEngine engine = limber({"", [substeps](SoftBodySettings& s) { s.stepping.maxSubsteps = substeps; }});
  engine.name = "limber " + std::to_string(substeps) + " substeps";
  engine.isBudget = true;
  return engine;
}

using ContactsOf = SoftContacts (*)(const ContactScene&);

SoftContacts cheapestContacts(const ContactScene& scene) {
  return scene.role == Role::Pile ? SoftContacts::PointsAndFaces : SoftContacts::Points;
}

/// Returns btSoftBody with links as stiff as the springs. It does not sleep in btSoftRigidDynamicsWorld.
ContactEngine softBody(const std::string& name, int iterations, ContactsOf contacts,
                       double hardness = kHardContacts) {
  ContactEngine engine;
  engine.name = name;
  engine.make = [=](const ContactScene& scene) {
    return makeSoftBodyEngine(kContactTick, iterations, LinkStiffness::Calibrated, contacts(scene), hardness);
  };
  engine.sleeps = false;
  return engine;
}

template <SoftContacts kContacts>
SoftContacts always(const ContactScene&) {
  return kContacts;
}

ContactEngine deformable() {
  ContactEngine engine;
  engine.name = "btDeformable implicit";
  engine.make = [](const ContactScene&) { return makeDeformableEngine(true); };
  return engine;
}

ContactEngine spheres() {
  ContactEngine engine;
  engine.name = "loose spheres";
  engine.make = [](const ContactScene&) { return makeBareEngine(); };
  engine.isSpheres = true;
  engine.isOther = false;
  return engine;
}

}  // namespace

std::vector<ContactEngine> contactEngines() {
  std::vector<ContactEngine> engines;
  for (const LimberSetting& setting : limberSettings()) engines.push_back(limber(setting));
  for (const int substeps : {5, 10, 20, 40}) engines.push_back(limberWithin(substeps));
  for (const int iterations : {1, 4, 10}) {
    engines.push_back(
        softBody("btSoftBody " + std::to_string(iterations) + " it", iterations, cheapestContacts));
    engines.back().isReference = iterations == 4;
  }
  engines.push_back(deformable());
  engines.push_back(spheres());
  return engines;
}

std::vector<std::string> limberNames() {
  std::vector<std::string> names;
  for (const LimberSetting& setting : limberSettings()) names.push_back(setting.name);
  return names;
}

std::vector<ContactEngine> contactFlags() {
  std::vector<ContactEngine> engines = {
      softBody("SDF_RS", 4, always<SoftContacts::Points>),
      softBody("SDF_RS | VF_SS", 4, always<SoftContacts::PointsAndFaces>),
      softBody("VF_SS with kKHR 0.1", 4, always<SoftContacts::PointsAndFaces>, kBulletsHardness),
      softBody("SDF_RS | CL_SS", 4, always<SoftContacts::PointsAndClusters>),
      softBody("CL_RS | CL_SS", 4, always<SoftContacts::Clusters>),
      spheres()};
  engines[1].isReference = true;
  return engines;
}

}  // namespace limber::bench

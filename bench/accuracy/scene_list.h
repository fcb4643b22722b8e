// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

namespace limber::bench {

/// Returns a set-up of a body with these properties; both stiffnesses are `stiffness`.
BodySetup bodyOf(SharedNetwork network, double mass, double stiffness, double damping = 0.0);

/// Each function adds its scenes. With `quick` they are few and short.
void addOscillators(std::vector<Scene>& scenes, bool quick);  // oscillators.cpp: one spring
void addChains(std::vector<Scene>& scenes, bool quick);       // chains.cpp: hanging chains
void addWaves(std::vector<Scene>& scenes, bool quick);        // waves.cpp: waves along a bar
void addFreeShapes(std::vector<Scene>& scenes, bool quick);   // free_shapes.cpp: cube, block, cloth
void addImpacts(std::vector<Scene>& scenes, bool quick);      // impacts.cpp: bar against a wall, dropped cube
void addResting(std::vector<Scene>& scenes, bool quick);      // resting.cpp: on floors and an incline
void addRigidPartners(std::vector<Scene>& scenes,
                      bool quick);  // rigid_partners.cpp: boxes, stack

std::vector<Scene> allScenes(bool quick);

}  // namespace limber::bench

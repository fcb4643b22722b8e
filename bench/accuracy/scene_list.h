// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

namespace limber::bench {

/// Where and how a setup's springs are: without damping unless said.
BodySetup bodyOf(SharedNetwork network, double mass, double stiffness, double damping = 0.0);

/// Each adds its scenes; `quick` keeps them few and short.
void addOscillators(std::vector<Scene>& scenes, bool quick);  // oscillators.cpp: one spring
void addChains(std::vector<Scene>& scenes, bool quick);       // chains.cpp: what hangs
void addWaves(std::vector<Scene>& scenes, bool quick);        // waves.cpp: what runs along a bar
void addFreeShapes(std::vector<Scene>& scenes, bool quick);   // free_shapes.cpp: cube, block, cloth
void addImpacts(std::vector<Scene>& scenes, bool quick);      // impacts.cpp: bar against a wall, dropped cube
void addResting(std::vector<Scene>& scenes, bool quick);      // resting.cpp: on floors and an incline
void addRigidPartners(std::vector<Scene>& scenes,
                      bool quick);  // rigid_partners.cpp: free boxes, stacked cubes

std::vector<Scene> allScenes(bool quick);

}  // namespace limber::bench

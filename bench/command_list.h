// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

namespace limber::bench {

/// 1: something failed; 2: the command line is wrong.
enum ExitCode : int { kSuccess = 0, kFailure = 1, kUsage = 2 };

/// A table or plot that can be asked for by name.
struct Command {
  const char* name;
  const char* about;                       ///< one line
  ExitCode (*run)(int argc, char** argv);  ///< argv[0] is the name, its own options follow
};

const std::vector<Command>& commandList();

/// Runs the command that argv[1] names; an unknown name is refused with the list.
ExitCode runCommand(int argc, char** argv);

// --- the commands, each in FOLDER/FOLDER_command.cpp --------------------------------------------------

/// Plays scenes with a known outcome in Limber, btSoftBody and btDeformable, and reports the error of each
/// engine and the time of its ticks.
ExitCode runAccuracy(int argc, char** argv);

/// Measures the cost of bodies that fly, land, rest, sleep, drape and pile up, compared to btSoftBody,
/// btDeformable and as many separate spheres.
ExitCode runContact(int argc, char** argv);

/// Do bodies keep their shape? Tables of networks, bracing rules, masses, skins and materials.
ExitCode runNetworks(int argc, char** argv);

/// Measures the drawing of many bodies, and compares it with the ways of the paper and of Bullet's example
/// browser.
ExitCode runRender(int argc, char** argv);

/// Repeats Tables 1 and 2 of C. Hart's paper: cubes fall onto a floor, 1, 2, 4 ... of them until 50 ticks a
/// second are too many, then bisecting; with loose spheres beside them. The modes take turns, count by count,
/// so that all see the same machine.
ExitCode runScaling(int argc, char** argv);

/// What a spring costs per substep, by instruction set and number type, and what contact rows add to it.
ExitCode runSprings(int argc, char** argv);

/// Measures what several threads gain, and how much of a tick stays outside the parallel parts.
ExitCode runThreads(int argc, char** argv);

/// `limber-bench stability`: writes stability.csv and stability.txt.
ExitCode runStability(int argc, char** argv);

}  // namespace limber::bench

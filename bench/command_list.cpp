// SPDX-License-Identifier: Zlib
#include "command_list.h"

#include <cstdio>
#include <string>

namespace limber::bench {
namespace {

void printList(std::FILE* stream) {
  std::fprintf(stream, "usage: limber-bench NAME [options]   (NAME --help lists the options)\n");
  for (const Command& command : commandList())
    std::fprintf(stream, "  %-10s %s\n", command.name, command.about);
}

}  // namespace

const std::vector<Command>& commandList() {
  static const std::vector<Command> kCommands = {
      {"accuracy", "errors and costs beside btSoftBody and btDeformable, where the truth is known",
       &runAccuracy},
      {"contact", "what bodies cost that fly, land, rest, sleep and lie in a heap, beside other engines",
       &runContact},
      {"networks", "which braces keep which shape; masses, skins, materials", &runNetworks},
      {"render", "what drawing many bodies costs, beside the paper's and Bullet's own way", &runRender},
      {"springs", "what a spring costs per substep, by instruction set", &runSprings},
      {"scaling", "1, 2, 4 ... soft cubes until real time is lost", &runScaling},
      {"threads", "what several threads gain, and what more of them would", &runThreads},
      {"stability", "hundreds of hard cases, counted alike for every engine", &runStability},
  };
  return kCommands;
}

ExitCode runCommand(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "";
  if (name == "--help" || name == "-h" || name == "--list") {
    printList(stdout);
    return kSuccess;
  }
  for (const Command& command : commandList()) {
    if (name == command.name) return command.run(argc - 1, argv + 1);
  }
  if (!name.empty()) std::fprintf(stderr, "limber-bench: there is no bench %s\n", name.c_str());
  printList(stderr);
  return kUsage;
}

}  // namespace limber::bench

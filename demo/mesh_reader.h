// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh.h>
#include <limber/result.h>

#include <cstdint>
#include <functional>
#include <string>

namespace limber::demo {

/// What the reading of one file may use.
struct ReadLimits {
  int seconds = 60;        ///< of processor time
  int clockSeconds = 600;  ///< on the clock: on a busy machine the reader gets only a part of the processor
  std::uint64_t bytes = std::uint64_t{4} << 30;  ///< of address space, in addition to that of the program
};

using MeshReader = std::function<Result<TriangleMesh>(const std::string& path)>;

/// Reads a mesh file that may be damaged or malicious: calls `reader` in a child process with limits. A
/// crash, an endless loop or the use of too much memory becomes an error that names the file and the cause.
/// The child's output on stdout and stderr is dropped. It has the rights of the program: this is no
/// protection against files that take over the reader. Systems without fork() call `reader` directly. Call it
/// when no other thread may hold a lock that `reader` needs, but for those of malloc: the child has only the
/// calling thread, and waits in vain for them. (It is then ended as too slow.)
Result<TriangleMesh> readMesh(const std::string& path, const ReadLimits& limits = {},
                              const MeshReader& reader = importMesh);

}  // namespace limber::demo

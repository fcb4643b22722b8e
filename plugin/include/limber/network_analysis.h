// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_builder.h>
#include <limber/spring_network.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace limber {

/// How a network stands up to small deformations.
enum class Rigidity : std::uint8_t {
  Flexible,        ///< has mechanisms: deformations that stretch no spring
  NearlyFlexible,  ///< its softest oscillation has less than 1e-4 of the stiffest one's eigenvalue
  Soft,            ///< less than 1e-3
  Rigid
};

/// Large deformations that a body is let go from.
enum class Deformation : std::uint8_t {
  Squash,    ///< to a tenth along a random direction
  Twist,     ///< by a quarter turn about a random axis
  Noise,     ///< every point moved by up to half the size
  Push,      ///< one point pushed 0.2 of the size beyond the opposite side
  Mirror,    ///< the outer 30 % mirrored through the plane that cuts them off
  Flatten,   ///< into a plane
  Inversion  ///< all mirrored through the centre
};
constexpr std::size_t kDeformations = 7;

/// Runs that came back to the rest shape (RMS distance below 1e-3 of the size after the best rigid motion
/// without reflection).
struct ReturnRate {
  std::uint32_t runs = 0;
  std::uint32_t returned = 0;
  std::uint32_t mirrored = 0;  ///< of those that did not: ended as the exact mirror image
  double rate() const { return runs ? double(returned) / runs : 0.0; }
  double standardError() const;  ///< of rate(), binomial
};

struct AnalysisSettings {
  std::uint32_t runs = 20;    ///< of each kind of deformation; 0: none
  std::uint64_t seed = 1;     ///< of the deformations; they are others than those that bracing with this seed
                              ///< has tried
  double totalMass = 1.0;     ///< kg, for what depends on it
  double stiffness = 1000.0;  ///< N/m of a spring of stiffnessScale 1
  double gravity = 9.81;      ///< m/s^2
  Progress progress;          ///< once it returns false the rest is left out, see endedEarly; or empty
};

/// What can be said of a network before it is used. SI units.
struct NetworkAnalysis {
  NetworkKind kind = NetworkKind::Solid;  ///< by shape: all points on a line, in a plane, or neither
  std::size_t points = 0, springs = 0, braces = 0;
  std::size_t pieces = 0;   ///< that no spring joins
  bool endedEarly = false;  ///< settings.progress said so: what was not measured by then has its default

  // small deformations, about the rest shape, unit masses
  std::size_t rank = 0;        ///< of the rigidity matrix
  std::size_t mechanisms = 0;  ///< 3 #points - 6 (5 on a line) - rank, less 6 (in a plane 3, on a line 1)
                               ///< for each piece but one: pieces are judged each by itself. In a plane
                               ///< #points - 3 of them, on a line 2 #points - 4 are bending, which no springs
                               ///< can prevent. Points that lie out of it by less than a ten-thousandth
                               ///< count as in the plane or on the line
  std::size_t selfStresses = 0;  ///< #springs - rank
  double softestEigenvalue = 0.0,
         stiffestEigenvalue = 0.0;         ///< N/m per spring constant of 1 N/m; without mechanisms
  double modeRatio = 0.0;                  ///< softest over stiffest; 0 with mechanisms other than bending
  Rigidity rigidity = Rigidity::Flexible;  ///< of flat bodies within their plane, of ropes along their line
  bool globallyRigid = false;  ///< generically: Gortler, Healy, Thurston 2010, by the rank of a random stress
  bool globallyRigidKnown = false;  ///< not for more points than the test can take

  // large deformations, of solids only: ropes and cloths are meant to fold
  std::array<ReturnRate, kDeformations> returns;
  ReturnRate allReturns() const;  ///< of the first five kinds together

  double leastStiffness = 0.0;  ///< N/m: below it the body, or one of its pieces, collapses under its own
                                ///< weight when put down; 0: without gravity, and where no stiffness is
                                ///< enough (remarks say so)
  bool leastStiffnessKnown = false;  ///< not for ropes and cloths, nor where oscillations are too fast to be
                                     ///< followed (remarks say so)
  double criticalTimeStep = 0.0;     ///< s: velocity Verlet without damping is unstable above it
  double safeTimeStep = 0.0;         ///< s: stable at any deformation (Gershgorin)

  std::size_t springsOutside = 0;  ///< that leave the closed surface
  std::size_t piercingEdges = 0;   ///< of the surface, that pass through one of its triangles
  MeshReport mesh;
  double volume = 0.0;               ///< m^3; 0 unless watertight
  std::vector<std::string> remarks;  ///< for people: what is unusual or should be mended
};

/// Of a network that validate() finds nothing wrong with. Deterministic. Seconds for a thousand points,
/// whatever the stiffness scales.
NetworkAnalysis analyse(const SpringNetwork& network, const AnalysisSettings& settings = {});

/// Some lines for people, each with its end; remarks begin with "! ".
std::string describe(const NetworkAnalysis& analysis);

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

// Analyses spring networks before they are used. Needs the library limber_analysis. Thread rule: any thread;
// calls are independent.

#include <limber/export.h>
#include <limber/network_builder.h>
#include <limber/spring_network.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace limber {

/// Resistance of a network to small deformations.
enum class Rigidity : std::uint8_t {
  Flexible,        ///< has mechanisms: deformations that stretch no spring
  NearlyFlexible,  ///< the eigenvalue of its softest mode is less than 1e-4 of that of its stiffest one
  Soft,            ///< the same with 1e-3
  Rigid
};

/// Number of runs that returned to the rest shape (RMS distance below 1e-3 of the size after the best rigid
/// motion without reflection).
struct ReturnRate {
  std::uint32_t runs = 0;
  std::uint32_t returned = 0;
  std::uint32_t mirrored = 0;  ///< of the runs that did not return: those that ended as the exact mirror
                               ///< image
  double rate() const { return runs ? double(returned) / runs : 0.0; }
  LIMBER_API double standardError() const;  ///< of rate(), binomial
};

struct AnalysisSettings {
  std::uint32_t runs = 20;  ///< for each kind of deformation; 0: none
  std::uint64_t seed = 1;   ///< of the deformations; they differ from those that bracing tries with this seed
  double totalMass = 1.0;   ///< kg, for the results that depend on it
  double stiffness = 1000.0;  ///< N/m of a spring of stiffnessScale 1
  double gravity = 9.81;      ///< m/s^2
  ParallelFor parallel;       ///< may be empty; results do not depend on it
  Progress progress;  ///< may be empty, called on the calling thread; once it returns false the rest is
                      ///< skipped, see endedEarly
};

/// Properties of a network that can be computed before it is used. SI units.
struct NetworkAnalysis {
  NetworkKind kind = NetworkKind::Solid;  ///< by shape: all points on a line, in a plane, or neither
  bool folds = false;  ///< a rope, a cloth, or flat: it has no shape to return to or to stand in
  std::size_t points = 0, springs = 0, braces = 0;
  std::size_t pieces = 0;   ///< parts that no spring connects
  bool endedEarly = false;  ///< settings.progress returned false: results that were not computed have their
                            ///< defaults

  // Small deformations about the rest shape, with unit masses.
  std::size_t rank = 0;        ///< of the rigidity matrix
  std::size_t mechanisms = 0;  ///< 3 #points - 6 (5 on a line) - rank, less 6 (in a plane 3, on a line 1)
                               ///< for each piece but one, because each piece is analysed by itself. #points
                               ///< - 3 of them in a plane, and 2 #points - 4 on a line, are bending, which no
                               ///< springs can prevent. Points that deviate from the plane or line by less
                               ///< than a ten-thousandth count as in it
  std::size_t selfStresses = 0;  ///< #springs - rank
  double softestEigenvalue = 0.0,
         stiffestEigenvalue = 0.0;  ///< N/m for spring constants of 1 N/m; mechanisms excluded
  double modeRatio = 0.0;           ///< softest over stiffest; 0 if there are mechanisms other than bending
  Rigidity rigidity = Rigidity::Flexible;  ///< of flat bodies within their plane, of ropes along their line
  bool globallyRigid = false;  ///< generically: Gortler, Healy, Thurston 2010, by the rank of a random stress
  bool globallyRigidKnown = false;  ///< false if the network has too many points for the test

  // Large deformations. None if it folds.
  std::array<ReturnRate, kDeformations> returns;
  LIMBER_API ReturnRate allReturns() const;  ///< sum of the first five kinds

  std::optional<double> standingStiffness;  ///< N/m of a spring of stiffnessScale 1. With it the body, or its
                                            ///< weakest piece, keeps 90 % of its height when it is set down
                                            ///< on a floor as modelled; with less it sinks, topples or leans
                                            ///< over. A body that falls over before it has sunk so far stands
                                            ///< higher with it. 0 without gravity, infinite where no
                                            ///< stiffness is enough; none if it folds, and where some springs
                                            ///< are so stiff that it cannot be computed (remarks say so)
  double criticalTimeStep = 0.0;            ///< s: velocity Verlet without damping is unstable above it
  double safeTimeStep = 0.0;                ///< s: stable at any deformation (Gershgorin)

  std::size_t springsOutside = 0;  ///< springs that leave the closed surface
  std::size_t piercingEdges = 0;   ///< edges of the surface that pass through one of its triangles
  MeshReport mesh;
  double volume = 0.0;               ///< m^3; 0 unless watertight
  std::vector<std::string> remarks;  ///< for the user: unusual facts and faults that should be repaired
};

/// Analyses a network that passes validate(). Deterministic. Takes seconds for a thousand points, independent
/// of the stiffness scales.
LIMBER_API NetworkAnalysis analyse(const SpringNetwork& network, const AnalysisSettings& settings = {});

/// Returns a report of some lines, each with a line end; remarks begin with "! ".
LIMBER_API std::string describe(const NetworkAnalysis& analysis);

}  // namespace limber

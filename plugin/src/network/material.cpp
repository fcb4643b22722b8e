// SPDX-License-Identifier: Zlib

// This file measures the moduli of a body of springs: it solves for its small displacements under uniform
// stresses. It builds networks of tetrahedra with the elasticity of a material, chooses the settings of a
// body with the requested elasticity, and distributes the mass of a body of tetrahedra over its points.

#include "network/material.h"

#include "network/masses.h"

#include <limber/cook.h>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Fraction of the largest diagonal entry, which is added to the diagonal: without it, rigid motions would
/// make the matrix singular. The forces do not excite them. The softest modes of solids have 1e-5 of the
/// largest entry and more.
constexpr double kShift = 1e-10;

using Positions = std::vector<Vector3d>;

Positions scaledPoints(const ElasticBody& body) {
  Positions points = body.network.restPoints;
  for (Vector3d& p : points) p = p.cwiseProduct(body.scale);
  return points;
}

Eigen::Map<const MatrixXd> asMatrix(const Positions& points) {
  return {points.front().data(), 3, static_cast<Index>(points.size())};
}

/// Adds springs without tension: k n n^T along their directions n.
void addSprings(const ElasticBody& body, const Positions& points, Triplets& triplets) {
  for (const NetworkSpring& s : body.network.springs) {
    const Vector3d n = (points[s.b] - points[s.a]).normalized();
    const Matrix3d block = body.stiffness * s.stiffnessScale * n * n.transpose();
    addBlock(triplets, s.a, s.a, block);
    addBlock(triplets, s.b, s.b, block);
    addBlock(triplets, s.b, s.a, -block);
  }
}

/// At rest the volume term K/2 (V - V0)^2 / V0 of a tetrahedron has the Hessian K/V0 g g^T. g is the gradient
/// of the volume: for each corner a third of the area vector of the opposite face, pointing to the corner.
void addTetrahedra(const ElasticBody& body, const Positions& points, Triplets& triplets) {
  for (const Tetrahedron& t : body.network.tetrahedra) {
    const Vector3d a = points[t[0]], b = points[t[1]] - a, c = points[t[2]] - a, d = points[t[3]] - a;
    std::array<Vector3d, 4> g{Vector3d::Zero(), c.cross(d) / 6.0, d.cross(b) / 6.0, b.cross(c) / 6.0};
    g[0] = -(g[1] + g[2] + g[3]);
    const double factor = body.volumeModulus / std::abs(b.dot(g[1]));
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        if (t[i] >= t[j]) addBlock(triplets, t[i], t[j], factor * g[i] * g[j].transpose());
  }
}

/// Returns sqrt(K/V0) g for the volume term of the whole inside of the surface.
MatrixXd surfaceGradient(const ElasticBody& body, const Positions& points) {
  MatrixXd gradient = MatrixXd::Zero(3 * static_cast<Index>(points.size()), 1);
  for (const Triangle& t : body.network.surface)
    for (const std::uint32_t corner : t) gradient.block<3, 1>(3 * corner, 0) += areaVector(points, t) / 3.0;
  // the volume is a homogeneous function of third degree (Euler)
  const double volume = std::abs(gradient.col(0).dot(asMatrix(points).reshaped())) / 3.0;
  return gradient * std::sqrt(body.volumeModulus / volume);
}

}  // namespace

LinearResponse::LinearResponse(const ElasticBody& body) : points_(scaledPoints(body)) {
  Triplets triplets;
  addSprings(body, points_, triplets);
  if (body.volumeModulus > 0.0) addTetrahedra(body, points_, triplets);
  Eigen::SparseMatrix<double> stiffness = sumOf(triplets, static_cast<Index>(points_.size()));
  const double shift = kShift * stiffness.diagonal().maxCoeff();
  for (Index i = 0; i < stiffness.rows(); ++i) stiffness.coeffRef(i, i) += shift;
  factor_ = factorise(stiffness);
  if (body.volumeModulus <= 0.0 || !body.network.tetrahedra.empty()) return;
  volumeGradient_ = surfaceGradient(body, points_);
  volumeResponse_ = solve(factor_, volumeGradient_);
}

/// Includes the volume term, of rank one, by the formula of Sherman and Morrison. This keeps the matrix
/// sparse.
MatrixXd LinearResponse::displacements(const MatrixXd& forces) const {
  MatrixXd u = solve(factor_, forces);
  if (volumeGradient_.size() == 0) return u;
  const double gradientDotResponse = volumeGradient_.col(0).dot(volumeResponse_.col(0));
  return u - product(volumeResponse_, transposedProduct(volumeGradient_, u)) / (1.0 + gradientDotResponse);
}

namespace {

constexpr int kDirections = 40;

/// Returns one of kDirections directions, spread evenly over a half sphere by the golden angle.
Vector3d direction(int i) {
  const double z = (i + 0.5) / kDirections, radius = std::sqrt(1.0 - z * z);
  const double angle = i * kPi * (3.0 - std::sqrt(5.0));
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

/// Returns one of the uniform stresses xx, yy, zz, yz, xz, xy of 1 Pa.
Matrix3d unitStress(int i) {
  Matrix3d stress = Matrix3d::Zero();
  const int a = i < 3 ? i : (i - 2) % 3, b = i < 3 ? i : (i - 1) % 3;
  stress(a, b) = stress(b, a) = 1.0;
  return stress;
}

/// Returns the coefficients of the unit stresses in the stress d d^T.
std::array<double, 6> uniaxial(const Vector3d& d) {
  return {d[0] * d[0], d[1] * d[1], d[2] * d[2], d[1] * d[2], d[2] * d[0], d[0] * d[1]};
}

/// Adds the tractions of a stress along a direction that grows in proportion to the coordinate `across` of
/// the points, integrated against linear shape functions. The force of a corner is area / 12 times the sum of
/// the stresses at all corners, where its own stress counts twice.
void addTractions(const Positions& points, const Triangle& t, const Vector3d& along,
                  const Eigen::RowVectorXd& across, Eigen::Ref<MatrixXd> forces) {
  const double area = along.dot(areaVector(points, t));
  const double sum = across[t[0]] + across[t[1]] + across[t[2]];
  for (const std::uint32_t corner : t)
    forces.block<3, 1>(3 * Index(corner), 0) += area / 12.0 * (sum + across[corner]) * along;
}

/// Adds the loads of a body's bending, 3 #points x 6: stresses along each principal axis of the solid that
/// grow across each other. Returns the moduli, which are still the work of a body of 1 Pa.
std::array<BendingModulus, 6> addBending(const SpringNetwork& network, const Positions& points,
                                         Eigen::Ref<MatrixXd> forces) {
  const SolidMoments solid = solidMoments(points, network.surface);
  const SymmetricParts3 principal = symmetricParts3(solid.second);
  std::array<BendingModulus, 6> moduli;
  for (Index load = 0; load < 6; ++load) {
    const Index along = load / 2, across = (along + 1 + load % 2) % 3;
    const Eigen::RowVectorXd height =
        principal.vectors.col(across).transpose() * (asMatrix(points).colwise() - solid.centre);
    for (const Triangle& t : network.surface)
      addTractions(points, t, principal.vectors.col(along), height, forces.col(load));
    moduli[static_cast<std::size_t>(load)] = {solid.volume * principal.values[across],
                                              std::sqrt(principal.values[along] / principal.values[across])};
  }
  return moduli;
}

/// The mean strain under each unit stress, and the response to bending.
struct Responses {
  std::array<Matrix3d, 6> strains;
  std::array<BendingModulus, 6> bending;
};

Responses responsesOf(const ElasticBody& body) {
  const LinearResponse response(body);
  const Positions& points = response.points();
  MatrixXd forces = MatrixXd::Zero(3 * static_cast<Index>(points.size()), 12);
  double volume = 0.0;
  for (const Triangle& t : body.network.surface) {
    const Vector3d area = areaVector(points, t);
    volume += area.dot(points[t[0]]) / 3.0;
    for (int load = 0; load < 6; ++load)
      for (const std::uint32_t corner : t)
        forces.block<3, 1>(3 * corner, load) += unitStress(load) * area / 3.0;
  }
  Responses found;
  found.bending = addBending(body.network, points, forces.rightCols(6));
  const MatrixXd u = response.displacements(forces);
  for (int load = 0; load < 6; ++load) {
    Matrix3d sum = Matrix3d::Zero();
    for (const Triangle& t : body.network.surface)
      for (const std::uint32_t corner : t)
        sum += u.block<3, 1>(3 * corner, load) * areaVector(points, t).transpose() / 3.0;
    found.strains[static_cast<std::size_t>(load)] = (sum + sum.transpose()) / (2.0 * volume);
  }
  for (Index load = 0; load < 6; ++load)
    found.bending[static_cast<std::size_t>(load)].modulus /= forces.col(6 + load).dot(u.col(6 + load));
  return found;
}

}  // namespace

ElasticModuli measureModuli(const ElasticBody& body) {
  const Responses found =
      responsesOf({body.network, body.stiffness, body.volumeModulus, body.scale.cwiseAbs()});
  ElasticModuli moduli;
  for (int i = 0; i < kDirections; ++i) {
    const Vector3d d = direction(i);
    const std::array<double, 6> part = uniaxial(d);
    Matrix3d strain = Matrix3d::Zero();
    for (std::size_t load = 0; load < 6; ++load) strain += part[load] * found.strains[load];
    const double along = d.dot(strain * d);
    moduli.youngsModuli.push_back(1.0 / along);
    moduli.youngsModulus += 1.0 / (along * kDirections);
    moduli.poissonRatio += 0.5 * (along - strain.trace()) / (along * kDirections);
  }
  const auto [smallest, largest] =
      std::minmax_element(moduli.youngsModuli.begin(), moduli.youngsModuli.end());
  moduli.isotropy = *smallest / *largest;
  moduli.bulkModulus = 1.0 / (found.strains[0] + found.strains[1] + found.strains[2]).trace();
  moduli.bending = found.bending;
  return moduli;
}

// --- networks with the elasticity of a material ------------------------------------------------------------

namespace {

/// Tolerance of Poisson's ratio, and the largest number of measurements.
constexpr double kPoissonError = 5e-4;
constexpr int kMaxMeasurements = 6;

/// How many times longer than thick a body must be for its bending to count.
constexpr double kSlender = 3.0;

/// A body with a volume term, measured.
struct VolumeTrial {
  double modulus = 0.0;  ///< Pa of the volume term beside springs of 1 Pa
  double excess = 1.0;   ///< Young's modulus over that of the springs alone
  double poissonRatio = 0.0;
  double bending = 1.0;  ///< largest bending stiffness over Young's modulus, over that of the springs alone
};

/// Measures bodies of a network with different volume terms.
class VolumeTrials {
 public:
  VolumeTrials(const SpringNetwork& network, const Eigen::Vector3d& scale)
      : network_(&network),
        scale_(scale),
        springs_(measureModuli({network, network.stiffnessPerModulus, 0.0, scale})),
        reference_(scale == Eigen::Vector3d::Ones()
                       ? springs_.youngsModulus
                       : measureModuli({network, network.stiffnessPerModulus}).youngsModulus) {}

  VolumeTrial at(double modulus) const {
    const ElasticModuli moduli =
        modulus > 0.0 ? measureModuli({*network_, network_->stiffnessPerModulus, modulus, scale_}) : springs_;
    VolumeTrial trial{modulus, moduli.youngsModulus / reference_, moduli.poissonRatio, 1.0};
    for (std::size_t i = 0; i < moduli.bending.size(); ++i)
      if (springs_.bending[i].slenderness > kSlender)
        trial.bending = std::max(trial.bending, moduli.bending[i].modulus / moduli.youngsModulus *
                                                    springs_.youngsModulus / springs_.bending[i].modulus);
    return trial;
  }

 private:
  const SpringNetwork* network_;
  Eigen::Vector3d scale_;
  ElasticModuli springs_;  ///< without a volume term
  double reference_;       ///< Pa, Young's modulus of the springs at scale 1
};

/// Springs alone have lambda = mu = 2/5 E; a volume term of modulus K adds K to lambda. With
/// nu = lambda / (2 (lambda + mu)) that is  nu = (mu + K) / (2 (2 mu + K)),  so
/// K = mu (4 nu - 1) / (1 - 2 nu). A network is a little softer than this estimate, so the target nu is
/// corrected by the measured nu. stiffnessPerModulus holds without a volume term, at scale 1.
VolumeTrial trialOf(const VolumeTrials& trials, double poissonRatio) {
  const double mu = 0.4;
  double targetRatio = poissonRatio;
  VolumeTrial trial;
  for (int i = 0; i < kMaxMeasurements; ++i) {
    trial = trials.at(mu * (4.0 * targetRatio - 1.0) / (1.0 - 2.0 * targetRatio));
    const double error = poissonRatio - trial.poissonRatio;
    if (std::abs(error) < kPoissonError || (targetRatio <= 0.25 && error < 0.0)) break;
    targetRatio = std::clamp(targetRatio + error, 0.25, 0.5 * (targetRatio + 0.5));
  }
  return trial;
}

/// The factor by which the volume terms may stiffen a body against bending, and its tolerance. A plate bends
/// up to 1.25 times harder at a Poisson ratio of 1/2 than at 1/4.
constexpr double kLocking = 1.26, kLockingError = 0.04;

/// Lowers the volume modulus until it stiffens the body by kLocking against bending. Where a body is one or
/// two tetrahedra thick, all of them are on one side of the middle and change their volume when it bends:
/// they lock. The excess e = bending - 1 grows with the modulus as  e = a K / (1 + b K),  so  1/e = 1/(a K) +
/// b/a  is a line over 1/K.
VolumeTrial unlocked(const VolumeTrials& trials, VolumeTrial stiffer) {
  VolumeTrial trial = trials.at(stiffer.modulus / 8.0);
  for (int i = 0; i < kMaxMeasurements && std::abs(trial.bending - kLocking) > kLockingError; ++i) {
    const double x = 1.0 / trial.modulus, x0 = 1.0 / stiffer.modulus;
    const double y = 1.0 / std::max(trial.bending - 1.0, 1e-3),
                 y0 = 1.0 / std::max(stiffer.bending - 1.0, 1e-3);
    const double inverse = x + (1.0 / (kLocking - 1.0) - y) * (x - x0) / (y - y0);
    if (!(inverse > 0.0)) break;
    stiffer = trial;
    trial = trials.at(1.0 / inverse);
  }
  return trial;
}

VolumeTrial findTrial(const VolumeTrials& trials, double poissonRatio) {
  const VolumeTrial trial = trialOf(trials, poissonRatio);
  return trial.bending > kLocking + kLockingError ? unlocked(trials, trial) : trial;
}

}  // namespace

Result<void> validate(const Material& m) {
  if (!std::isfinite(m.youngsModulus) || m.youngsModulus <= 0.0)
    return Error{mustBe("youngsModulus", m.youngsModulus, "above 0")};
  if (!(m.poissonRatio >= 0.25 && m.poissonRatio < 0.5))
    return Error{mustBe("poissonRatio", m.poissonRatio, "from 0.25 to below 0.5")};
  if (!std::isfinite(m.density) || m.density <= 0.0) return Error{mustBe("density", m.density, "above 0")};
  if (m.dampingTime && !(std::isfinite(*m.dampingTime) && *m.dampingTime >= 0.0))
    return Error{mustBe("dampingTime", *m.dampingTime, "0 or more")};
  return {};
}

Material Material::jelly() { return {5e4, 0.4, 1000.0, 0.01}; }
Material Material::rubber() { return {1.5e6, 0.4, 1100.0, 0.003}; }
Material Material::foam() { return {1e5, 0.25, 60.0, 0.02}; }
Material Material::stiff() { return {1e7, 0.3, 1100.0, 0.001}; }

SpringNetwork materialNetwork(TetrahedralMesh filling, const std::function<bool(double)>& goOn,
                              double minGrowth) {
  SpringNetwork network;
  network.restPoints = std::move(filling.points);
  network.tetrahedra = std::move(filling.tetrahedra);
  network.surface = std::move(filling.surface);
  setMaterialSprings(network, goOn, minGrowth);
  network.massFractions = materialMasses(network);
  return network;
}

Result<SharedNetwork> buildMaterialNetwork(const TriangleMesh& mesh, const MaterialMesh& settings) {
  bool going = true;  // once false, it stays false
  const auto reportProgress = [&](const char* what, double done) {
    return going = going && (!settings.progress || settings.progress(what, done));
  };
  if (settings.spacing && !(std::isfinite(*settings.spacing) && *settings.spacing > 0.0))
    return Error{mustBe("spacing", *settings.spacing, "above 0")};
  const Result<WeldedMesh> welded = weld(mesh);
  if (!welded) return Error{welded.error()};
  if (!reportProgress("tetrahedra", 0.0)) return Error{kEnded};
  const auto partOf = [&](const char* what) {
    return [&reportProgress, what](double done) { return reportProgress(what, done); };
  };
  Result<TetrahedralMesh> filling = settings.spacing
                                        ? fillWithTetrahedra(*welded, *settings.spacing)
                                        : fillWithPoints(*welded, settings.points, partOf("tetrahedra"));
  if (!reportProgress("tetrahedra", 1.0)) return Error{kEnded};
  if (!filling) return Error{filling.error()};
  SpringNetwork network = materialNetwork(std::move(*filling), partOf("spring constants"));
  network.report = welded->report;
  if (!reportProgress("skin", 0.0)) return Error{kEnded};
  Result<SharedNetwork> skinned = withSkin(network, mesh, {SkinKind::Barycentric, 32, 0.0});
  if (!reportProgress("skin", 1.0)) return Error{kEnded};
  return skinned;
}

namespace {

/// Returns the sum of stiffnessScale times the square of the scaled rest length over the springs, m^2.
double stiffnessMoment(const SpringNetwork& network, const Eigen::Vector3d& scale) {
  double sum = 0.0;
  for (const NetworkSpring& s : network.springs)
    sum += s.stiffnessScale *
           (network.restPoints[s.b] - network.restPoints[s.a]).cwiseProduct(scale).squaredNorm();
  return sum;
}

/// Spring constant (N/m) and volume modulus for 1 Pa at the scale of a body, and the volume (m^3) of the
/// material at scale 1.
struct FormMaterial {
  double stiffness = 0.0, volume = 0.0;
  std::optional<double> volumeModulus{};
};

Result<FormMaterial> ofRopeOrSheet(const SpringNetwork& network, const Eigen::Vector3d& scale) {
  const double moment = stiffnessMoment(network, scale) / scale.prod();
  const bool isRope = network.kind == NetworkKind::Rope;
  if (network.thickness <= 0.0)
    return Error{std::string("the thickness of the ") + (isRope ? "rope" : "cloth") +
                 " is 0: a material needs it (see RopeSettings and ClothSettings)"};
  if (!isRope) {
    const double volume = network.thickness * areaOf(network.restPoints, network.surface);
    return FormMaterial{3.0 * volume / moment, volume};
  }
  double length = 0.0;
  for (const NetworkSpring& s : network.springs)
    if (s.kind == SpringKind::Structural)
      length += (network.restPoints[s.b] - network.restPoints[s.a]).norm();
  const double volume = 0.25 * kPi * network.thickness * network.thickness * length;
  return FormMaterial{volume / moment, volume};
}

Result<FormMaterial> formOf(const SpringNetwork& network, double poissonRatio, const Eigen::Vector3d& scale) {
  if (network.kind != NetworkKind::Solid) return ofRopeOrSheet(network, scale);
  const auto solidVolume = [&](double own) { return network.volume > 0.0 ? network.volume : own; };
  if (!network.tetrahedra.empty() && network.stiffnessPerModulus > 0.0) {
    const VolumeTrial trial = findTrial(VolumeTrials(network, scale), poissonRatio);
    return FormMaterial{network.stiffnessPerModulus / trial.excess,
                        solidVolume(volumeOf(network.restPoints, network.tetrahedra)),
                        trial.modulus / trial.excess};
  }
  const EdgeDefects defects = findEdgeDefects(network.surface);
  if (network.surface.empty() || defects.open > 0)
    return Error{"the surface of the network is open: a material needs its volume"};
  if (defects.inconsistent > 0 && !(network.volume > 0.0))
    return Error{
        "at " + std::to_string(defects.inconsistent) +
        " edges the triangles of the network face different sides: a material needs its volume (cook() "
        "or wrap() the mesh)"};
  const double volume = solidVolume(std::abs(signedVolume(network.restPoints, network.surface)));
  return FormMaterial{6.0 * volume * scale.prod() / stiffnessMoment(network, scale), volume};
}

}  // namespace

Result<SoftBodySettings> withMaterial(const SpringNetwork& network, const Material& material,
                                      SoftBodySettings settings) {
  if (Result<void> valid = validate(material); !valid) return Error{valid.error()};
  if (Result<void> valid = validate(settings); !valid) return Error{valid.error()};
  const Eigen::Vector3d scale = settings.scale.cwiseAbs();
  const Result<FormMaterial> form = formOf(network, material.poissonRatio, scale);
  if (!form) return Error{form.error()};
  settings.extensionStiffness = settings.compressionStiffness = form->stiffness * material.youngsModulus;
  if (form->volumeModulus) settings.volumeModulus = *form->volumeModulus * material.youngsModulus;
  if (material.dampingTime) settings.damping = *material.dampingTime * settings.extensionStiffness;
  settings.totalMass = material.density * form->volume * scale.prod();
  if (network.thickness > 0.0 && !settings.pointRadius)
    settings.pointRadius = 0.5 * std::cbrt(scale.prod()) * network.thickness;
  if (Result<void> valid = validate(settings); !valid)
    return Error{"a body of this material: " + valid.error()};
  return settings;
}

// --- masses ------------------------------------------------------------------------------------------------

namespace {

/// Mass that is added to the points of the fastest oscillations, as a fraction of the body's.
constexpr double kAdded = 0.07;

/// Largest mass of a point, as a multiple of the mass of the quarters of its tetrahedra: what the light
/// points gain must not come from a few heavy ones.
constexpr double kLargestGrowth = 1.3;

/// The interval in which the bound of stiffness over mass is searched, as a fraction of the largest ratio,
/// and the halvings of its logarithm.
constexpr double kSlowest = 1e-9;
constexpr int kHalvings = 60;

std::vector<double> quartersOfVolumes(const SpringNetwork& network) {
  std::vector<double> quarters(network.restPoints.size(), 0.0);
  for (const Tetrahedron& t : network.tetrahedra)
    for (const std::uint32_t point : t) quarters[point] += volumeOf(network.restPoints, t) / 4.0;
  return quarters;
}

/// Adds the stiffness of the volume terms of a material of Poisson's ratio 0.39, whose volume modulus is the
/// Young's modulus of the springs: K/V g g^T with the volume's gradient g, a third of the area vector of the
/// opposite face.
void addVolumeTerms(const SpringNetwork& network, std::vector<Matrix3d>& blocks) {
  const std::vector<Vector3d>& x = network.restPoints;
  for (const Tetrahedron& t : network.tetrahedra) {
    const double factor = 1.0 / (network.stiffnessPerModulus * volumeOf(x, t));
    for (std::size_t i = 0; i < 4; ++i) {
      const Vector3d gradient = areaVector(x[t[(i + 1) % 4]], x[t[(i + 2) % 4]], x[t[(i + 3) % 4]]) / 3.0;
      blocks[t[i]] += factor * gradient * gradient.transpose();
    }
  }
}

/// Returns the largest stiffness of each point while its neighbours are held, as a multiple of that of a
/// spring of stiffnessScale 1.
std::vector<double> stiffnessOfPoints(const SpringNetwork& network) {
  std::vector<Matrix3d> blocks(network.restPoints.size(), Matrix3d::Zero());
  for (const NetworkSpring& s : network.springs) {
    const Vector3d along = (network.restPoints[s.b] - network.restPoints[s.a]).normalized();
    for (const std::uint32_t end : {s.a, s.b}) blocks[end] += s.stiffnessScale * along * along.transpose();
  }
  addVolumeTerms(network, blocks);
  std::vector<double> stiffness;
  stiffness.reserve(blocks.size());
  for (const Matrix3d& block : blocks) stiffness.push_back(symmetricValues(block)[2]);
  return stiffness;
}

/// Returns the smallest masses of the points for the smallest bound of stiffness over mass that adds at most
/// kAdded to the given masses of sum 1.
std::vector<double> smallestMasses(const std::vector<double>& masses, const std::vector<double>& stiffness) {
  double fast = 0.0;
  for (std::size_t i = 0; i < masses.size(); ++i) fast = std::max(fast, stiffness[i] / masses[i]);
  double slow = kSlowest * fast;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = std::sqrt(slow * fast);
    double added = 0.0;
    for (std::size_t p = 0; p < masses.size(); ++p) added += std::max(0.0, stiffness[p] / middle - masses[p]);
    (added > kAdded ? slow : fast) = middle;
  }
  std::vector<double> smallest;
  smallest.reserve(stiffness.size());
  for (const double s : stiffness) smallest.push_back(s / fast);
  return smallest;
}

}  // namespace

std::vector<double> materialMasses(const SpringNetwork& network) {
  std::vector<double> quarters = quartersOfVolumes(network);
  const double volume = std::accumulate(quarters.begin(), quarters.end(), 0.0);
  for (double& quarter : quarters) quarter /= volume;
  MassProgramme programme =
      massProgramme(network.restPoints, network.surface, solidMoments(network.restPoints, network.surface));
  programme.minFractions = smallestMasses(quarters, stiffnessOfPoints(network));
  for (std::size_t i = 0; i < quarters.size(); ++i)
    programme.maxFractions[i] = std::max(programme.minFractions[i], kLargestGrowth * quarters[i]);
  programme.desired = std::move(quarters);
  return matchMoments(programme).fractions;
}

}  // namespace limber

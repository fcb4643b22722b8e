// SPDX-License-Identifier: Zlib
// Computes the weights of skins: barycentric ones in tetrahedra and triangles, and those of radial
// interpolation.

#include "network/skin.h"

#include "mesh/linear_algebra.h"
#include "network/tetrahedra.h"

#include <Eigen/LU>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVector3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;
using Lu = Eigen::PartialPivLU<MatrixXd>;

constexpr std::uint32_t kNoTriangle = 0xffffffffu;

Vector4d barycentric(const std::vector<Vector3d>& points, const Tetrahedron& t, const Vector3d& place) {
  const Vector3d &origin = points[t[0]], x = place - origin;
  const Vector3d b = points[t[1]] - origin, c = points[t[2]] - origin, d = points[t[3]] - origin;
  const Vector3d area = c.cross(d);
  const double volume = b.dot(area);
  const Vector3d rest = Vector3d(x.dot(area), b.dot(x.cross(d)), b.dot(c.cross(x))) / volume;
  return {1.0 - rest.sum(), rest[0], rest[1], rest[2]};
}

/// The faces that belong to only one tetrahedron, and the indices of these tetrahedra.
struct Border {
  std::vector<Triangle> faces;
  std::vector<std::uint32_t> owner;  ///< #faces
};

Border borderOf(const std::vector<Tetrahedron>& tetrahedra, const FaceNeighbours& neighbours) {
  Border border;
  border.faces = surfaceOf(tetrahedra, neighbours);
  for (std::uint32_t t = 0; t < tetrahedra.size(); ++t)
    for (const std::uint32_t neighbour : neighbours[t])
      if (neighbour == kOutside) border.owner.push_back(t);
  return border;
}

/// Moves from tetrahedron to tetrahedron, through the face that the place lies farthest beyond. Stops in the
/// tetrahedron that contains the place, at the border, or after as many steps as there are tetrahedra.
std::uint32_t findTetrahedron(const Vector3d& place, std::uint32_t start, const std::vector<Vector3d>& points,
                              const std::vector<Tetrahedron>& tetrahedra, const FaceNeighbours& neighbours) {
  std::uint32_t current = start;
  for (std::size_t step = 0; step < tetrahedra.size(); ++step) {
    Eigen::Index corner = 0;
    const double smallest = barycentric(points, tetrahedra[current], place).minCoeff(&corner);
    const std::uint32_t next = neighbours[current][static_cast<std::size_t>(corner)];
    if (smallest >= 0.0 || next == kOutside) return current;
    current = next;
  }
  return current;
}

/// Returns the nearest triangle that faces the same direction as the place. A part of the body that only
/// nearly touches faces the opposite direction.
std::uint32_t nearestFacingTriangle(const TriangleBvh& bvh, const SkinProblem& problem, std::size_t place) {
  const TriangleHit hit = bvh.nearestWithin(problem.places[place], HUGE_VAL, problem.normals[place]);
  return hit ? hit.triangle : bvh.nearest(problem.places[place]).triangle;
}

/// Returns the height of the point over the plane of the triangle divided by the distance from its centroid.
double steepness(const std::vector<Vector3d>& points, const Triangle& t, std::uint32_t point) {
  const Vector3d away = points[point] - centroid(points, t);
  const double distance = away.norm();
  return distance > 0.0 ? std::abs(away.dot(areaVector(points, t).normalized())) / distance : 0.0;
}

/// Smallest steepness of a fourth corner; otherwise the steepest of all points is used.
constexpr double kMinSteepness = 0.3;

/// Returns a point on the opposite side of the body that makes a tetrahedron with the triangle.
std::uint32_t fourthCorner(const std::vector<Vector3d>& points, const std::vector<Triangle>& surface,
                           const TriangleBvh& bvh, const Triangle& t) {
  const double size = (points[t[1]] - points[t[0]]).norm();
  const Vector3d inward = -areaVector(points, t).normalized();
  const auto hit = bvh.firstHit(centroid(points, t), inward, 1e-3 * size, HUGE_VAL);
  std::uint32_t best = kNoTriangle;
  double steepest = kMinSteepness;
  const auto keepSteeper = [&](std::uint32_t point) {
    const double steep = steepness(points, t, point);
    if (steep > steepest) best = point, steepest = steep;
  };
  if (hit)
    for (const std::uint32_t point : surface[hit.triangle]) keepSteeper(point);
  if (best != kNoTriangle) return best;
  steepest = 0.0;
  for (std::uint32_t point = 0; point < points.size(); ++point) keepSteeper(point);
  // a triangle without area has none: its weights are not finite, which is an error
  return best != kNoTriangle ? best : t[0];
}

}  // namespace

SkinWeights tetrahedronWeights(const SkinProblem& problem, const std::vector<Tetrahedron>& tetrahedra) {
  const FaceNeighbours neighbours = findFaceNeighbours(tetrahedra);
  const Border border = borderOf(tetrahedra, neighbours);
  const TriangleBvh bvh(problem.points, border.faces);
  SkinWeights result;
  for (std::size_t p = 0; p < problem.places.size(); ++p) {
    const Vector3d& place = problem.places[p];
    const std::uint32_t start = border.owner[nearestFacingTriangle(bvh, problem, p)];
    const std::uint32_t found = findTetrahedron(place, start, problem.points, tetrahedra, neighbours);
    result.add(tetrahedra[found], barycentric(problem.points, tetrahedra[found], place).data());
  }
  return result;
}

SkinWeights triangleWeights(const SkinProblem& problem, const std::vector<Triangle>& surface) {
  const TriangleBvh bvh(problem.points, surface);
  std::vector<std::uint32_t> fourth(surface.size(), kNoTriangle);
  SkinWeights result;
  for (std::size_t p = 0; p < problem.places.size(); ++p) {
    const std::uint32_t i = nearestFacingTriangle(bvh, problem, p);
    const Triangle& t = surface[i];
    if (fourth[i] == kNoTriangle) fourth[i] = fourthCorner(problem.points, surface, bvh, t);
    const Tetrahedron tetrahedron{t[0], t[1], t[2], fourth[i]};
    result.add(tetrahedron, barycentric(problem.points, tetrahedron, problem.places[p]).data());
  }
  return result;
}

namespace {

// Interpolating f at points x_i by  s(x) = sum l_i k(|x - x_i|) + c + a . x  with  sum l_i = 0, sum l_i x_i =
// 0  is linear in the values f_i: with the symmetric matrix M of these conditions,
//     s(x) = b(x)^T M^-1 (f, 0),   b(x) = (k(|x - x_1|), ..., k(|x - x_n|), 1, x),
// so the weights of a place are the first n entries of M^-1 b(x).
//
// This is also the best prediction of a random field with the covariance k about an affine field (kriging: G.
// Matheron, "The intrinsic random functions and their applications", 1973). Dense skins use B. Matern's
// covariance (1960) of fields that are twice differentiable and smooth over lengths well above the body's. On
// boxes, where the points sample each field on flat faces only, the cubic kernel |r|^3 (J. Duchon, 1977) of
// less smooth fields has three times the error. Sparse skins use |r|^3, which has no length scale: its
// weights change less when a neighbour is replaced.
//
// In kriging, a point can be a measurement with an error of variance v_i: v_i is added to the diagonal of M.
// So points across a gap in the body lose weight continuously, and the affine motions stay exact. M is then
// different for each place. With the diagonal matrix V of the v_i > 0 of a place, the matrix R that selects
// their rows, and w = M^-1 b (Woodbury),
//     (M + R^T V R)^-1 b = w - M^-1 R^T V^1/2 (1 + V^1/2 R M^-1 R^T V^1/2)^-1 V^1/2 R w.

/// Places that are solved together: enough for fast matrix kernels, with little memory.
constexpr Index kBatch = 256;
/// Points span space if their spread along the smallest direction is this fraction of the largest spread.
constexpr double kMinSpread = 1e-4;
/// The same for the neighbours of a place, which needs a larger value for good weights.
constexpr double kMinLocalSpread = 0.1;

MatrixXd asRows(const std::vector<Vector3d>& positions) {
  MatrixXd rows(static_cast<Index>(positions.size()), 3);
  for (Index i = 0; i < rows.rows(); ++i) rows.row(i) = positions[static_cast<std::size_t>(i)];
  return rows;
}

/// Coordinates about the mean of the points, in units of the largest distance from it. The entries of the
/// system are of the order of 1, and there is no cancellation far from the origin.
struct Frame {
  RowVector3d origin;
  double unit;

  MatrixXd toFrame(const MatrixXd& rows) const { return (rows.rowwise() - origin) / unit; }
};

Frame frameOf(const MatrixXd& points) {
  const RowVector3d middle = points.colwise().mean();
  return {middle, (points.rowwise() - middle).rowwise().norm().maxCoeff()};
}

MatrixXd chosenRows(const MatrixXd& rows, const std::vector<Index>& chosen) {
  MatrixXd result(static_cast<Index>(chosen.size()), rows.cols());
  for (std::size_t i = 0; i < chosen.size(); ++i) result.row(static_cast<Index>(i)) = rows.row(chosen[i]);
  return result;
}

double cube(double r) { return r * r * r; }

/// The covariance of a field at places r apart, and that of a measurement with the variance v for |r|^3.
struct Kernel {
  double (*covariance)(double r);
  double (*variance)(double v);
};

constexpr Kernel kCubic{&cube, [](double v) { return v; }};

/// Matern's covariance of smoothness 5/2, with a small part of the cubic one. The cubic part dominates only
/// over lengths well below a tenth of the body; it keeps weights small where places lie slightly off all
/// points. The first odd power of Matern's series, -(r/l)^5 / 45, makes its fields rough, as |r|^3 does in
/// the cubic one. So variances of the order of lengths cubed become those of lengths to the fifth power. A
/// tenth of them is enough to exclude points across a gap.
constexpr double kCorrelationLength = 2.0;  // length, in radii of the body
constexpr double kCubicFraction = 1e-4, kGapFraction = 0.1;
constexpr Kernel kSmooth{[](double r) {
                           const double s = r / kCorrelationLength;
                           return (1.0 + s + s * s / 3.0) * std::exp(-s) + kCubicFraction * cube(r);
                         },
                         [](double v) {
                           const double rough =
                               std::pow(v, 5.0 / 3.0) / std::pow(kCorrelationLength, 5.0) / 45.0;
                           return kCubicFraction * v + kGapFraction * rough;
                         }};

/// Returns k(|x - x_i|) of all points for one place.
VectorXd covariances(const Kernel& kernel, const MatrixXd& points, const RowVector3d& place) {
  return (points.rowwise() - place).rowwise().norm().unaryExpr(kernel.covariance);
}

MatrixXd affinePart(const MatrixXd& rows) {
  MatrixXd part(rows.rows(), 4);
  part.col(0).setOnes();
  part.rightCols<3>() = rows;
  return part;
}

MatrixXd interpolationMatrix(const Kernel& kernel, const MatrixXd& points) {
  const Index n = points.rows();
  MatrixXd m = MatrixXd::Zero(n + 4, n + 4);
  for (Index i = 0; i < n; ++i) m.col(i).head(n) = covariances(kernel, points, points.row(i));
  m.topRightCorner(n, 4) = affinePart(points);
  m.bottomLeftCorner(4, n) = affinePart(points).transpose();
  return m;
}

MatrixXd rightSides(const Kernel& kernel, const MatrixXd& points, const MatrixXd& places) {
  MatrixXd sides(points.rows() + 4, places.rows());
  for (Index i = 0; i < places.rows(); ++i)
    sides.col(i).head(points.rows()) = covariances(kernel, points, places.row(i));
  sides.bottomRows<4>() = affinePart(places).transpose();
  return sides;
}

/// Makes the smallest change of the weights (columns) that restores  P^T w = (1, x),  which rounding
/// disturbs.
void makeAffineExact(const MatrixXd& points, const MatrixXd& places, MatrixXd& weights) {
  const MatrixXd p = affinePart(points);
  MatrixXd misfit = transposedProduct(p, weights) - affinePart(places).transpose();
  solveSmall(transposedProduct(p, p), misfit);
  weights -= product(p, misfit);
}

/// Applies Woodbury's formula (see above). `solution` is the whole of M^-1 b for one place, `inverse` is
/// M^-1, `unit` the unit of the variances.
void fadeOut(const MatrixXd& inverse, const SparseRows& variances, Index place, double unit,
             VectorXd& solution) {
  std::vector<Index> faded;
  std::vector<double> deviation;
  for (SparseRows::InnerIterator v(variances, place); v; ++v) {
    faded.push_back(v.col());
    deviation.push_back(std::sqrt(kSmooth.variance(v.value() / unit)));
  }
  if (faded.empty()) return;
  const auto count = static_cast<Index>(faded.size());
  const Eigen::Map<const VectorXd> d(deviation.data(), count);
  const MatrixXd columns = chosenRows(inverse, faded).transpose() * d.asDiagonal();  // M^-1 is symmetric
  const MatrixXd system = MatrixXd::Identity(count, count) + d.asDiagonal() * chosenRows(columns, faded);
  const MatrixXd right = d.cwiseProduct(VectorXd(chosenRows(solution, faded)));
  solution -= product(columns, MatrixXd(Lu(system).solve(right)));
}

struct RowSpread {
  RowVector3d middle;
  Vector3d weakest;          ///< direction, unit vector
  double smallest, largest;  ///< standard deviations
};

RowSpread spreadOf(const MatrixXd& rows) {
  const RowVector3d middle = rows.colwise().mean();
  const MatrixXd centred = rows.rowwise() - middle;
  const Eigen::Matrix3d covariance = transposedProduct(centred, centred) / static_cast<double>(rows.rows());
  const SymmetricParts3 parts = symmetricParts3(covariance);
  const Vector3d deviations = parts.values.cwiseMax(0.0).cwiseSqrt();
  return {middle, parts.vectors.col(0), deviations[0], deviations[2]};
}

/// Returns the nearest point at a distance of at least the neighbours' largest deviation from their plane:
/// the plane through their mean, normal to the weakest direction. If there is none, returns the farthest one.
Index nearestOffPlane(const MatrixXd& points, const VectorXd& distance, const RowSpread& spread) {
  const VectorXd height = ((points.rowwise() - spread.middle) * spread.weakest).cwiseAbs();
  Index best = 0;
  height.maxCoeff(&best);
  for (Index i = 0; i < points.rows(); ++i) {
    if (height[i] >= spread.largest && (height[best] < spread.largest || distance[i] < distance[best]))
      best = i;
  }
  return best;
}

/// Returns the nearest points, ascending. Up to three of the farthest are replaced if they do not span space
/// well.
std::vector<Index> neighboursOf(const MatrixXd& points, const RowVector3d& place, const VectorXd& variances,
                                Index count) {
  const VectorXd distance = covariances(kCubic, points, place) + variances;
  std::vector<Index> chosen(static_cast<std::size_t>(points.rows()));
  std::iota(chosen.begin(), chosen.end(), Index(0));
  const auto end = chosen.begin() + std::min(count, points.rows());
  std::partial_sort(chosen.begin(), end, chosen.end(), [&](Index i, Index j) {
    return distance[i] != distance[j] ? distance[i] < distance[j] : i < j;
  });
  chosen.erase(end, chosen.end());
  for (std::size_t last = chosen.size(); last-- > 1 && chosen.size() - last <= 3;) {
    const RowSpread spread = spreadOf(chosenRows(points, chosen));
    if (spread.smallest >= kMinLocalSpread * spread.largest) break;
    const Index other = nearestOffPlane(points, distance, spread);
    if (std::find(chosen.begin(), chosen.end(), other) == chosen.end()) chosen[last] = other;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace

bool spansSpace(const std::vector<Vector3d>& points) {
  if (points.size() < 4) return false;
  const RowSpread spread = spreadOf(asRows(points));
  return spread.smallest > kMinSpread * spread.largest;
}

SkinWeights denseWeights(const SkinProblem& problem) {
  const Frame frame = frameOf(asRows(problem.points));
  const MatrixXd points = frame.toFrame(asRows(problem.points)),
                 places = frame.toFrame(asRows(problem.places));
  const Index n = points.rows();
  const Lu factors(interpolationMatrix(kSmooth, points));
  const MatrixXd inverse = problem.variances.nonZeros() > 0 ? MatrixXd(factors.inverse()) : MatrixXd();
  std::vector<std::uint32_t> all(problem.points.size());
  std::iota(all.begin(), all.end(), 0u);
  SkinWeights result;
  result.weights.reserve(problem.points.size() * problem.places.size());
  result.points.reserve(problem.points.size() * problem.places.size());
  for (Index first = 0; first < places.rows(); first += kBatch) {
    const MatrixXd batch = places.middleRows(first, std::min(kBatch, places.rows() - first));
    MatrixXd solutions = factors.solve(rightSides(kSmooth, points, batch));
    for (Index i = 0; i < batch.rows(); ++i) {
      VectorXd solution = solutions.col(i);
      fadeOut(inverse, problem.variances, first + i, cube(frame.unit), solution);
      solutions.col(i) = solution;
    }
    MatrixXd weights = solutions.topRows(n);
    makeAffineExact(points, batch, weights);
    for (Index i = 0; i < batch.rows(); ++i) result.add(all, weights.col(i).data());
  }
  return result;
}

SkinWeights sparseWeights(const SkinProblem& problem, std::uint32_t neighbours) {
  const MatrixXd points = asRows(problem.points), places = asRows(problem.places);
  SkinWeights result;
  for (Index i = 0; i < places.rows(); ++i) {
    const VectorXd variances = problem.variances.row(i).transpose();
    const std::vector<Index> chosen = neighboursOf(points, places.row(i), variances, Index(neighbours));
    const MatrixXd neighbourPoints = chosenRows(points, chosen);
    const Frame frame = frameOf(neighbourPoints);
    const MatrixXd scaled = frame.toFrame(neighbourPoints), place = frame.toFrame(places.row(i));
    MatrixXd system = interpolationMatrix(kCubic, scaled);
    for (std::size_t j = 0; j < chosen.size(); ++j)
      system(Index(j), Index(j)) += variances[chosen[j]] / cube(frame.unit);
    MatrixXd weights = Lu(system).solve(rightSides(kCubic, scaled, place));
    weights.conservativeResize(neighbourPoints.rows(), 1);
    makeAffineExact(scaled, place, weights);
    result.add(chosen, weights.data());
  }
  return result;
}

}  // namespace limber

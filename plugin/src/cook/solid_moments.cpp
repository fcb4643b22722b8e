// SPDX-License-Identifier: Zlib
#include "cook/solid_moments.h"

#include <Eigen/Geometry>

namespace limber {

// Of the tetrahedra from the points' middle, where rounding is least, to each triangle. One with corners v_i
// has the second moments V/20 (sum v_i v_i^T + (sum v_i) (sum v_i)^T).
SolidMoments solidMoments(const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                          const std::vector<Triangle>& surface) {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(), first = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < points.cols(); ++i) origin += points.col(i);
  origin /= static_cast<double>(points.cols());
  SolidMoments m;
  for (const Triangle& t : surface) {
    const Eigen::Vector3d a = points.col(t[0]) - origin, b = points.col(t[1]) - origin,
                          c = points.col(t[2]) - origin, sum = a + b + c;
    const double part = a.dot(b.cross(c)) / 6.0;
    m.volume += part;
    first += part / 4.0 * sum;
    m.second +=
        part / 20.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  const Eigen::Vector3d centre = first / m.volume;
  m.centre = origin + centre;
  m.second = m.second / m.volume - centre * centre.transpose();
  return m;
}

}  // namespace limber

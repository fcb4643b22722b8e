// SPDX-License-Identifier: Zlib
#include "bullet/body_in_world.h"
#include "bullet/bullet_objects.h"
#include "bullet/contact_report.h"
#include "bullet/soft_body_data.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

bool hasCorner(const Triangle& triangle, std::uint32_t point) {
  return triangle[0] == point || triangle[1] == point || triangle[2] == point;
}

/// How much a triangle of the body faces that way, -1 to 1; two-sided ones face both ways.
double facing(const SoftBodyData& body, std::uint32_t triangle, const Eigen::Vector3d& way) {
  const Triangle& t = body.surface.topology->triangles[triangle];
  const Points& x = body.state.position;
  const Eigen::Vector3d a = x.col(t[0]), normal = (x.col(t[1]) - a).cross(x.col(t[2]) - a).stableNormalized();
  const double along = normal.dot(way);
  return body.surface.topology->oneSided[triangle] ? along : std::abs(along);
}

/// The triangle that has all points of the side and faces that way most; of equals, the first.
std::uint32_t triangleOf(const SoftBodyData& body, const ContactSide& side, const Eigen::Vector3d& way) {
  const IndexLists& around = body.surface.topology->trianglesAround;
  std::uint32_t best = ContactSide::kNone;
  double most = -2.0;
  for (const std::uint32_t* t = around.begin(side.points[0]); t != around.end(side.points[0]); ++t) {
    const Triangle& corners = body.surface.topology->triangles[*t];
    if (!hasCorner(corners, side.points[1]) || !hasCorner(corners, side.points[2])) continue;
    const double much = facing(body, *t, way);
    if (much > most) most = much, best = *t;
  }
  return best;
}

/// Gives the weights to the triangle's corners.
void spread(ContactSide& side, std::uint32_t triangle, const Triangle& corners) {
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (corners[static_cast<std::size_t>(j)] == side.points[static_cast<std::size_t>(i)]) {
        weights[j] += side.weights[i];
        break;
      }
  side = {triangle, {corners[0], corners[1], corners[2]}, weights};
}

void findTriangle(const SoftBodyData& body, ContactSide& side, const Eigen::Vector3d& way) {
  if (!body.surface.topology || side.triangle != ContactSide::kNone || side.weights.isZero(0.0)) return;
  const std::uint32_t triangle = triangleOf(body, side, way);
  if (triangle != ContactSide::kNone) spread(side, triangle, body.network->surface[triangle]);
}

}  // namespace

void findTriangles(SoftContact& contact) {
  const Eigen::Vector3d normal = toEigen(contact.normal);
  findTriangle(dataOf(*contact.body), contact.side, -normal);
  if (contact.otherBody) findTriangle(dataOf(*contact.otherBody), contact.otherSide, normal);
}

void dropGone(SoftBodyData& body) {
  ContactReport& r = body.report;
  std::size_t kept = 0;
  const bool here = !r.contacts.empty() && anyInWorld(body);
  for (std::size_t i = 0; here && i < r.contacts.size(); ++i) {
    if (!isThere(*body.world, r.partners[i])) continue;
    if (kept != i) r.contacts[kept] = r.contacts[i], r.partners[kept] = r.partners[i];
    ++kept;
  }
  r.contacts.resize(kept);
  r.partners.resize(kept);
}

const std::vector<SoftContact>& readReport(SoftBodyData& body) {
  dropGone(body);
  ContactReport& report = body.report;
  if (!report.hasTriangles)
    for (SoftContact& contact : report.contacts) findTriangles(contact);
  report.hasTriangles = true;
  return report.contacts;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber

// SPDX-License-Identifier: Zlib
#include "collide/vertex_triangle.h"

#include "collide/feature_meeting.h"
#include "collide/normal_cone.h"

namespace limber {
namespace {

using Eigen::Vector3d;

/// Of a vertex behind a triangle but not beneath it: cosine of the slope at which it may be.
constexpr double kSteepFoot = 0.5;

/// Barycentric coordinates of the foot of `p` in the triangle's plane.
Vector3d footIn(const MovingFeature<3>::Corners& triangle, const Vector3d& p) {
  const Vector3d u = triangle.col(1) - triangle.col(0), v = triangle.col(2) - triangle.col(0);
  const Vector3d normal = u.cross(v), to = p - triangle.col(0);
  const double squared = normal.squaredNorm();
  const double second = normal.dot(to.cross(v)) / squared, third = normal.dot(u.cross(to)) / squared;
  return {1.0 - second - third, second, third};
}

/// Moves a foot that is slightly beside its triangle into it.
bool moveInto(Vector3d& barycentric) {
  if (!(barycentric.minCoeff() >= -kBeside)) return false;
  barycentric = barycentric.cwiseMax(0.0);
  barycentric /= barycentric.sum();
  return true;
}

struct VertexTriangle {
  const SurfacePair& pair;
  MovingFeature<1> vertex;
  MovingFeature<3> triangle;
  VertexBehind at;
  double side = 1.0;  ///< -1: seen from behind

  Vector3d normal(double time) const { return side * normalOf<3>(triangle.at(time)); }
  double height(double time) const {
    return normal(time).dot((vertex.start + time * vertex.motion) - triangle.at(time).col(0));
  }
};

void addAt(VertexTriangle& meeting, double time, ContactSearch& search) {
  meeting.at.barycentric = footIn(meeting.triangle.at(time), meeting.vertex.at(time));
  if (!moveInto(meeting.at.barycentric)) return;
  const Vector3d normal = meeting.normal(time);
  const MovingSurface& mine = meeting.at.ofB ? meeting.pair.b : meeting.pair.a;
  if (!facesOutward(mine, time, meeting.at.vertex, -normal)) return;
  addVertexOnTriangle(meeting.pair, meeting.at, normal, time, search);
}

void addBehind(VertexTriangle& meeting, double depth, double limit, ContactSearch& search) {
  if (meeting.pair.self || depth > limit) return;
  const MovingFeature<3>::Corners& t = meeting.triangle.start;
  VertexBehind& at = meeting.at;
  at.barycentric = footIn(t, meeting.vertex.start);
  at.beneath = moveInto(at.barycentric);
  if (!at.beneath) at.barycentric = nearestBarycentric({t.col(0), t.col(1), t.col(2)}, meeting.vertex.start);
  at.depth = (t * at.barycentric - meeting.vertex.start).norm();
  if (!at.beneath && (at.depth > limit || depth < kSteepFoot * at.depth)) return;
  search.behind.push_back(at);
}

/// When a vertex in front of the triangle's plane comes within reach of it, by conservative advancement as in
/// findMeeting(); kNever if it does not, or not within the tick.
double timeOfLanding(const VertexTriangle& meeting, double height) {
  const double reach = meeting.pair.reach(), met = kMetShare * meeting.pair.margin;
  double time = 0.0;
  Vector3d normal = meeting.normal(0.0);
  for (int i = 0; i < kMostAdvances && height - reach > met; ++i) {
    const double approach = approachAlong(normal, meeting.vertex, meeting.triangle);
    if (approach <= 0.0 || time + (height - reach) / approach > 1.0) return kNever;
    time += (height - reach) / approach;
    normal = meeting.normal(time);
    height = meeting.height(time);
  }
  return height - reach > met ? kNever : time;
}

}  // namespace

void addVertexOnTriangle(const SurfacePair& pair, const VertexBehind& at, const Vector3d& normal, double time,
                         ContactSearch& search) {
  const SurfaceTopology& t = *(at.ofB ? pair.a : pair.b).topology;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.a = atVertex(at.vertex);
  c.b = onTriangle(t, at.triangle, at.barycentric);
  if (at.ofB) std::swap(c.a, c.b);
  c.normal = at.ofB ? Vector3d(-normal) : normal;
  c.time = time;
  candidate.rank = at.ofB ? kTriangleVertex : kVertexTriangle;
  candidate.scale = t.depthLimit[at.triangle];
  candidate.vertex = meetingVertex(pair, at.vertex, at.ofB);
  addCandidate(pair, candidate, search);
}

void meetVertexTriangle(const SurfacePair& pair, bool ofB, std::uint32_t v, std::uint32_t triangle,
                        ContactSearch& search) {
  const MovingSurface &mine = ofB ? pair.b : pair.a, &other = ofB ? pair.a : pair.b;
  VertexTriangle meeting{pair,
                         featureOf<1>(mine, std::array<std::uint32_t, 1>{v}),
                         featureOf<3>(other, other.topology->triangles[triangle]),
                         {},
                         1.0};
  meeting.at.ofB = ofB;
  meeting.at.vertex = v;
  meeting.at.triangle = triangle;
  Vector3d normal = meeting.normal(0.0);
  if (normal.squaredNorm() == 0.0) return;
  double height = normal.dot(meeting.vertex.start - meeting.triangle.start.col(0));
  if (height < 0.0) {
    if (other.topology->oneSided[triangle])
      return addBehind(meeting, -height, other.topology->depthLimit[triangle], search);
    meeting.side = -1.0;
    normal = -normal;
    height = -height;
  }
  const double gap = height - pair.reach();
  if (gap > pair.margin && approachAlong(normal, meeting.vertex, meeting.triangle) < gap) return;
  const double time = gap > 0.0 ? timeOfLanding(meeting, height) : 0.0;
  if (time != kNever)
    addAt(meeting, time, search);
  else if (gap <= pair.margin)
    addAt(meeting, 0.0, search);
}

}  // namespace limber

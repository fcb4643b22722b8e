// SPDX-License-Identifier: Zlib

// This file lets the triangles of a surface, and of the surface that is drawn, follow the elements of a
// network that separates.

#include "solver/split.h"

#include <Eigen/LU>

#include <algorithm>
#include <map>

namespace limber {

using Eigen::Vector3d;

namespace {

Facet sorted(const Triangle& t) {
  Facet facet = {t[0], t[1], t[2]};
  std::sort(facet.begin(), facet.end());
  return facet;
}

/// Returns the element that has most of the points; the first one of several.
std::uint32_t hostOf(const Separation& s, const std::vector<std::uint32_t>& points) {
  std::uint32_t host = 0;
  std::size_t most = 0;
  for (const std::uint32_t point : points)
    for (const std::uint32_t element : s.old.around[point]) {
      std::size_t count = 0;
      for (const std::uint32_t other : points)
        if (cornerFrom(s, element, other) != kNoPoint) ++count;
      if (count < most || (count == most && element >= host)) continue;
      most = count;
      host = element;
    }
  return host;
}

/// Gives a triangle of old points those of its element.
Triangle follow(const Separation& s, const Triangle& t) {
  if (std::none_of(t.begin(), t.end(), [&](std::uint32_t point) { return s.divided(point); })) return t;
  const std::uint32_t host = hostOf(s, {t[0], t[1], t[2]});
  Triangle result = t;
  for (std::uint32_t& point : result)
    if (const std::uint32_t corner = cornerFrom(s, host, point); corner != kNoPoint) point = corner;
  return result;
}

/// Returns the face of a tetrahedron that comes from a facet, oriented outward.
Triangle faceOf(const Separation& s, std::uint32_t element, const Facet& facet) {
  constexpr std::size_t kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  for (std::size_t left = 0; left < 4; ++left) {
    if (std::find(facet.begin(), facet.end(), s.old.all[element][left]) != facet.end()) continue;
    const auto& corner = s.elements[element];
    return {corner[kFaces[left][0]], corner[kFaces[left][1]], corner[kFaces[left][2]]};
  }
  return {};
}

/// Returns the faces that a crack opens between tetrahedra.
std::vector<Triangle> openedFaces(const Separation& s) {
  std::vector<Triangle> faces;
  if (s.old.corners != 4) return faces;
  for (const ElementPair& n : s.neighbours) {
    if (!n.separated) continue;
    const Triangle a = faceOf(s, n.a, n.facet), b = faceOf(s, n.b, n.facet);
    if (sorted(a) == sorted(b)) continue;
    faces.push_back(a);
    faces.push_back(b);
  }
  return faces;
}

// --- the surface that is drawn -----------------------------------------------------------------------------

/// A vertex of the drawn surface and the point, or skinned point, that it follows after the separation.
using Follower = std::pair<std::uint32_t, std::uint32_t>;

/// Returns the vertex that follows a point: the present one if it may, else a copy.
std::uint32_t vertexFor(RenderSurface& render, std::map<Follower, std::uint32_t>& made, std::uint32_t vertex,
                        std::uint32_t point) {
  if (render.vertexToPoint[vertex] == point) return vertex;
  const auto [it, isNew] =
      made.try_emplace(Follower(vertex, point), static_cast<std::uint32_t>(render.vertexToPoint.size()));
  if (isNew) {
    render.vertexToPoint.push_back(point);
    if (!render.uvs.empty()) render.uvs.push_back(Eigen::Vector2f(render.uvs[vertex]));
  }
  return it->second;
}

void splitPlain(const Separation& s, RenderSurface& render) {
  std::map<Follower, std::uint32_t> made;
  const std::vector<std::uint32_t> pointOf = render.vertexToPoint;
  for (Triangle& t : render.triangles) {
    const Triangle old = {pointOf[t[0]], pointOf[t[1]], pointOf[t[2]]};
    const Triangle now = follow(s, old);
    for (std::size_t c = 0; c < 3; ++c) t[c] = vertexFor(render, made, t[c], now[c]);
  }
}

/// Returns the barycentric coordinates of a place in a tetrahedron.
Eigen::Vector4d weightsIn(const Separation& s, std::uint32_t element, const Vector3d& place) {
  const auto& corner = s.old.all[element];
  const std::vector<Vector3d>& x = s.before.restPoints;
  Eigen::Matrix3d edges;
  for (int c = 0; c < 3; ++c) edges.col(c) = x[corner[static_cast<std::size_t>(c) + 1]] - x[corner[0]];
  const Vector3d w = edges.inverse() * (place - x[corner[0]]);
  return {1.0 - w.sum(), w[0], w[1], w[2]};
}

/// Lets a skin follow the separation: near the crack all vertices of a triangle follow tetrahedra of one
/// side. So no triangle is stretched across the crack.
class SkinSplitter {
 public:
  SkinSplitter(const Separation& s, RenderSurface& render) : s_(s), render_(render) {
    const Skin& skin = render.skin;
    for (std::size_t i = 0; i < skin.size(); ++i) {
      Vector3d place = Vector3d::Zero();
      for (std::uint32_t w = skin.firstWeight[i]; w < skin.firstWeight[i + 1]; ++w)
        place += double(skin.weights[w]) * s.before.restPoints[skin.points[w]];
      rest_.push_back(place);
    }
    for (const auto& element : s.old.all) {
      Vector3d sum = Vector3d::Zero();
      for (const std::uint32_t point : element) sum += 0.25 * s.before.restPoints[point];
      centers_.push_back(sum);
    }
  }

  void split() {
    for (Triangle& t : render_.triangles) {
      std::vector<std::uint32_t> points;
      Vector3d middle = Vector3d::Zero();
      for (const std::uint32_t vertex : t) {
        const std::vector<std::uint32_t> own = pointsOf(vertex);
        points.insert(points.end(), own.begin(), own.end());
        middle += rest_[render_.vertexToPoint[vertex]] / 3.0;
      }
      const auto divided = [&](std::uint32_t point) { return s_.divided(point); };
      if (std::none_of(points.begin(), points.end(), divided)) continue;
      const int side = s_.request.side[nearest(middle, points, 0)];
      for (std::uint32_t& vertex : t) vertex = vertexIn(hostOfVertex(vertex, side), vertex);
    }
  }

 private:
  std::vector<std::uint32_t> pointsOf(std::uint32_t vertex) const {
    const Skin& skin = render_.skin;
    const std::uint32_t skinned = render_.vertexToPoint[vertex];
    return {skin.points.begin() + skin.firstWeight[skinned],
            skin.points.begin() + skin.firstWeight[skinned + 1]};
  }

  /// Returns the element whose centre is nearest to a place, of those on the side around the points; if there
  /// is none, or side is 0, of all around them. Points of a dense skin are all over the body: so are its
  /// elements.
  std::uint32_t nearest(const Vector3d& place, const std::vector<std::uint32_t>& points, int side) const {
    constexpr std::size_t kFewPoints = 32;
    std::uint32_t best = kNoPoint;
    double least = 0.0;
    const auto consider = [&](std::uint32_t e) {
      if (side * s_.request.side[e] < 0 || (side != 0 && s_.request.side[e] == 0)) return;
      const double distance = (centers_[e] - place).squaredNorm();
      if (best != kNoPoint && distance >= least) return;
      best = e;
      least = distance;
    };
    if (points.size() > kFewPoints) {
      for (std::uint32_t e = 0; e < centers_.size(); ++e) consider(e);
    } else {
      for (const std::uint32_t point : points)
        for (const std::uint32_t element : s_.old.around[point]) consider(element);
    }
    return best == kNoPoint && side != 0 ? nearest(place, points, 0) : best;
  }

  /// Returns the element on the side that a vertex follows: if possible the one that it follows already.
  std::uint32_t findHost(std::uint32_t vertex, int side) const {
    const std::vector<std::uint32_t> points = pointsOf(vertex);
    if (points.size() <= 4) {
      const std::uint32_t own = hostOf(s_, points);
      const auto hasCorner = [&](std::uint32_t point) { return cornerFrom(s_, own, point) != kNoPoint; };
      const bool whole = std::all_of(points.begin(), points.end(), hasCorner);
      if (whole && (side == 0 || s_.request.side[own] * side > 0)) return own;
    }
    return nearest(rest_[render_.vertexToPoint[vertex]], points, side);
  }

  std::uint32_t hostOfVertex(std::uint32_t vertex, int side) {
    const auto [it, isNew] = hosts_.try_emplace({vertex, side}, 0);
    if (isNew) it->second = findHost(vertex, side);
    return it->second;
  }

  /// Returns the vertex that follows a tetrahedron in place of an old one.
  std::uint32_t vertexIn(std::uint32_t host, std::uint32_t vertex) {
    const auto [it, isNew] = hosted_.try_emplace(Follower(vertex, host), 0);
    if (!isNew) return it->second;
    Skin& skin = render_.skin;
    const Vector3d place = rest_[render_.vertexToPoint[vertex]];
    const Eigen::Vector4d weights = weightsIn(s_, host, place);
    const auto skinned = static_cast<std::uint32_t>(skin.size());
    for (std::size_t c = 0; c < 4; ++c) {
      skin.points.push_back(s_.elements[host][c]);
      skin.weights.push_back(static_cast<float>(weights[static_cast<Eigen::Index>(c)]));
    }
    skin.firstWeight.push_back(static_cast<std::uint32_t>(skin.points.size()));
    rest_.push_back(place);
    return it->second = vertexFor(render_, made_, vertex, skinned);
  }

  const Separation& s_;
  RenderSurface& render_;
  std::vector<Vector3d> rest_;                                    // #skinned points
  std::vector<Vector3d> centers_;                                 // #elements
  std::map<std::pair<std::uint32_t, int>, std::uint32_t> hosts_;  // of a vertex on a side
  std::map<Follower, std::uint32_t> hosted_, made_;
};

/// Draws a face that follows points.
void drawFace(const Triangle& face, RenderSurface& render) {
  Triangle drawn = {};
  for (std::size_t c = 0; c < 3; ++c) {
    std::uint32_t follows = face[c];
    if (Skin& skin = render.skin; skin.size() > 0) {
      follows = static_cast<std::uint32_t>(skin.size());
      skin.points.push_back(face[c]);
      skin.weights.push_back(1.0F);
      skin.firstWeight.push_back(static_cast<std::uint32_t>(skin.points.size()));
    }
    drawn[c] = static_cast<std::uint32_t>(render.vertexToPoint.size());
    render.vertexToPoint.push_back(follows);
    if (!render.uvs.empty()) render.uvs.push_back(Eigen::Vector2f::Zero());
  }
  render.triangles.push_back(drawn);
}

}  // namespace

void splitSurface(const Separation& s, SpringNetwork& network) {
  for (std::size_t i = 0; i < network.surface.size(); ++i) {
    Triangle& t = network.surface[i];
    t = s.old.corners == 3 ? Triangle{s.elements[i][0], s.elements[i][1], s.elements[i][2]} : follow(s, t);
  }
  RenderSurface& render = network.render;
  if (render.skin.size() == 0)
    splitPlain(s, render);
  else if (s.old.corners == 4)
    SkinSplitter(s, render).split();
  for (const Triangle& face : openedFaces(s)) {
    network.surface.push_back(face);
    if (!render.triangles.empty()) drawFace(face, render);
  }
}

}  // namespace limber

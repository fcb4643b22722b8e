// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <cstddef>
#include <type_traits>

// What a `.limber` file of version 1 holds after its header, said once for the writer and the reader: a
// Stream has value() for a number, count() for a std::size_t (8 bytes everywhere) and array() for a count and
// that many elements. A changed layout is a new version.

namespace limber {

/// Calls scalar(x) for every number of an array's element, in the order of the file.
template <class Element, class F>
void forEachScalar(Element& element, F scalar) {
  using T = std::remove_const_t<Element>;
  if constexpr (std::is_arithmetic_v<T>) {
    scalar(element);
  } else if constexpr (std::is_same_v<T, NetworkSpring>) {
    scalar(element.a);
    scalar(element.b);
    scalar(element.kind);
    scalar(element.stiffnessScale);
  } else {  // std::array or a vector of Eigen's
    for (decltype(element.size()) i = 0; i < element.size(); ++i) scalar(element[i]);
  }
}

template <class Stream, class Report>
void transferReport(Stream& stream, Report& report) {
  stream.count("vertices", report.vertices);
  stream.count("points", report.points);
  stream.count("triangles", report.triangles);
  stream.count("degenerate triangles", report.degenerateTriangles);
  stream.count("duplicate triangles", report.duplicateTriangles);
  stream.count("isolated vertices", report.isolatedVertices);
  stream.count("components", report.components);
  stream.count("open edges", report.openEdges);
  stream.count("non-manifold edges", report.nonManifoldEdges);
  stream.count("inconsistent edges", report.inconsistentEdges);
}

template <class Stream, class Network>
void transferNetwork(Stream& stream, Network& network) {
  stream.value("network kind", network.kind);
  stream.value("stiffness per modulus", network.stiffnessPerModulus);
  transferReport(stream, network.report);
  stream.array("rest points", network.restPoints);
  stream.array("mass shares", network.massShares);
  stream.array("springs", network.springs);
  stream.array("surface triangles", network.surface);
  stream.array("tetrahedra", network.tetrahedra);
  stream.array("skin offsets", network.render.skin.firstWeight);
  stream.array("skin points", network.render.skin.points);
  stream.array("skin weights", network.render.skin.weights);
  stream.array("render vertices", network.render.vertexToPoint);
  stream.array("texture coordinates", network.render.uvs);
  stream.array("render triangles", network.render.triangles);
}

}  // namespace limber

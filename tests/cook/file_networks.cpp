// SPDX-License-Identifier: Zlib
#include "cook/file_networks.h"

#include "mesh/bytes.h"

namespace limber::test {
namespace {

RenderSurface skinnedTriangle() {
  RenderSurface render;
  render.skin.firstWeight = {0, 1, 3, 6};
  render.skin.points = {4, 0, 1, 1, 2, 3};
  render.skin.weights = {1.0f, 0.5f, 0.5f, 0.25f, 0.25f, 0.5f};
  render.vertexToPoint = {0, 1, 2, kNoPoint};
  render.uvs = {{0.0f, 0.0f}, {1.0f, 0.125f}, {0.25f, 1.0f}, {-0.5f, 2.0f}};
  render.triangles = {{0, 1, 2}};
  return render;
}

MeshReport numberedReport() {
  MeshReport report;
  report.vertices = 11;
  report.points = 5;
  report.triangles = 4;
  report.degenerateTriangles = 3;
  report.duplicateTriangles = 2;
  report.isolatedVertices = 6;
  report.components = 1;
  report.openEdges = 7;
  report.nonManifoldEdges = 8;
  report.inconsistentEdges = 9;
  return report;
}

}  // namespace

SpringNetwork everyMemberNetwork() {
  SpringNetwork network;
  network.restPoints = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.125, 0.25, 0.375}};
  network.massFractions = {0.125, 0.25, 0.125, 0.25, 0.25};
  network.springs = {{0, 1, SpringKind::Structural, 1.0},    {0, 2, SpringKind::Shear, 0.5},
                     {0, 3, SpringKind::Bending, 1.0 / 3.0}, {0, 4, SpringKind::Brace, 0.1},
                     {1, 2, SpringKind::Structural, 1e-300}, {3, 4, SpringKind::Brace, 1e300}};
  network.surface = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  network.tetrahedra = {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 3, 1, 4}, {1, 3, 2, 4}};
  network.stiffnessPerModulus = 0.7;
  network.render = skinnedTriangle();
  network.report = numberedReport();
  return network;
}

std::vector<std::uint8_t> forged(std::vector<std::uint8_t> bytes) {
  const std::size_t size = bytes.size() - kHeaderBytes;
  writeLittleEndian(std::uint64_t{size}, bytes.data() + 12);
  writeLittleEndian(hashPayload(bytes.data() + kHeaderBytes, size), bytes.data() + 20);
  return bytes;
}

}  // namespace limber::test

// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>
#include <limber/spring_network.h>

#include "cook/file_networks.h"
#include "import/temporary_folder.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace limber {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

Bytes readBytes(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(stream), {});
}

Result<SharedNetwork> parse(const Bytes& bytes) { return fromBytes(bytes.data(), bytes.size()); }

template <class T>
void expectSameBits(const std::vector<T>& a, const std::vector<T>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(std::memcmp(&a[i], &b[i], sizeof(T)), 0) << i;
}

void expectSameSprings(const SpringNetwork& a, const SpringNetwork& b) {
  ASSERT_EQ(a.springs.size(), b.springs.size());
  for (std::size_t i = 0; i < a.springs.size(); ++i) {
    EXPECT_EQ(a.springs[i].a, b.springs[i].a);
    EXPECT_EQ(a.springs[i].b, b.springs[i].b);
    EXPECT_EQ(a.springs[i].kind, b.springs[i].kind);
    EXPECT_EQ(a.springs[i].stiffnessScale, b.springs[i].stiffnessScale);
  }
}

void expectSameReport(const MeshReport& a, const MeshReport& b) {
  static_assert(sizeof(MeshReport) == 10 * sizeof(std::size_t), "a new count belongs into the file");
  EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
}

void expectSame(const SpringNetwork& a, const SpringNetwork& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.stiffnessPerModulus, b.stiffnessPerModulus);
  EXPECT_EQ(a.thickness, b.thickness);
  EXPECT_EQ(a.volume, b.volume);
  expectSameBits(a.restPoints, b.restPoints);
  expectSameBits(a.massFractions, b.massFractions);
  expectSameSprings(a, b);
  expectSameBits(a.surface, b.surface);
  expectSameBits(a.tetrahedra, b.tetrahedra);
  expectSameBits(a.render.skin.firstWeight, b.render.skin.firstWeight);
  expectSameBits(a.render.skin.points, b.render.skin.points);
  expectSameBits(a.render.skin.weights, b.render.skin.weights);
  expectSameBits(a.render.vertexToPoint, b.render.vertexToPoint);
  expectSameBits(a.render.uvs, b.render.uvs);
  expectSameBits(a.render.triangles, b.render.triangles);
  expectSameReport(a.report, b.report);
}

void expectRoundTrip(const SpringNetwork& network) {
  const Bytes bytes = toBytes(network);
  const Result<SharedNetwork> back = parse(bytes);
  ASSERT_TRUE(back) << back.error();
  expectSame(**back, network);
  EXPECT_EQ(toBytes(**back), bytes);
}

NetworkSettings equalLength() {
  NetworkSettings settings;
  settings.braces = BraceRule::EqualLength;
  settings.braceWeight = 1.0;
  return settings;
}

TEST(NetworkFile, everyMemberComesBackBitForBit) { expectRoundTrip(test::everyMemberNetwork()); }

TEST(NetworkFile, networksOfAllKindsComeBack) {
  expectRoundTrip(**buildRope());
  expectRoundTrip(**buildCloth());
  expectRoundTrip(**buildNetwork(small_meshes::cube(3), equalLength()));
  expectRoundTrip(**buildNetwork(small_meshes::icosphere(2), equalLength()));
}

TEST(NetworkFile, signsOfZeroAndTheSmallestNumbersComeBack) {
  SpringNetwork network = test::everyMemberNetwork();
  network.restPoints[0] = {-0.0, 5e-324, -5e-324};
  network.render.uvs[0] = {-0.0f, 1e-45f};
  expectRoundTrip(network);
}

TEST(NetworkFile, equalNetworksGiveEqualBytes) {
  const TriangleMesh mesh = small_meshes::icosphere(1);
  EXPECT_EQ(toBytes(**buildNetwork(mesh, equalLength())), toBytes(**buildNetwork(mesh, equalLength())));
}

// the format is stable: files of version 1 are always readable, and written with the same bytes
TEST(NetworkFile, goldenFileOfVersionOne) {
  const std::string file = LIMBER_GOLDEN_DIR "/version-1.limber";
  const Result<SharedNetwork> network = loadNetwork(file);
  ASSERT_TRUE(network) << network.error();
  expectSame(**network, test::everyMemberNetwork());
  EXPECT_EQ(toBytes(**network), readBytes(file));
}

// files of version 3 too, which have a thickness or a volume
TEST(NetworkFile, goldenFileOfVersionThree) {
  SpringNetwork network = test::everyMemberNetwork();
  network.groups = {{"seam", {1, 3}, {0, 2}}};
  network.thickness = 0.3;
  network.volume = 0.1;
  const std::string file = LIMBER_GOLDEN_DIR "/version-3.limber";
  const Result<SharedNetwork> read = loadNetwork(file);
  ASSERT_TRUE(read) << read.error();
  expectSame(**read, network);
  EXPECT_EQ((*read)->groups[0].name, "seam");
  EXPECT_EQ(toBytes(network), readBytes(file));
}

TEST(NetworkFile, headerIsLittleEndian) {
  const Bytes bytes = toBytes(test::everyMemberNetwork());
  const Bytes start = {0x89, 'L', 'I', 'M', 'B', 'R', '\r', '\n', 1, 0, 0, 0};
  EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 12), start);
  const std::size_t size = bytes.size() - test::kHeaderBytes;
  EXPECT_EQ(bytes[12] + 256u * bytes[13], size);
}

TEST(NetworkFile, savedFilesLoad) {
  const TemporaryFolder folder;
  const std::string file = folder.path() + "/body.limber";
  EXPECT_EQ(saveNetwork(test::everyMemberNetwork(), file).error(), "");
  EXPECT_EQ(readBytes(file), toBytes(test::everyMemberNetwork()));
  EXPECT_EQ(saveNetwork(**buildRope(), file).error(), "");  // replaces the old file
  const Result<SharedNetwork> network = loadNetwork(file);
  ASSERT_TRUE(network) << network.error();
  expectSame(**network, **buildRope());
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(NetworkFile, whatCannotBeWrittenLeavesNothingBehind) {
  const TemporaryFolder folder;
  const SpringNetwork network = test::everyMemberNetwork();
  const std::string nowhere = folder.path() + "/none/body.limber";
  SpringNetwork wrong = network;
  wrong.springs[0].b = 1000;
  EXPECT_EQ(saveNetwork(wrong, nowhere).error(), nowhere + ": " + validate(wrong).error());
  EXPECT_EQ(saveNetwork(network, nowhere).error(), "cannot write " + nowhere + ": No such file or directory");
  EXPECT_EQ(saveNetwork(network, folder.path()).error(),
            "cannot write " + folder.path() + ": it is not a regular file");
  EXPECT_EQ(saveNetwork(network, "/dev/null").error(), "cannot write /dev/null: it is not a regular file");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 0);
}

// several writers at once use different temporary names and leave each other's files alone
TEST(NetworkFile, othersPartsAreLeftAlone) {
  const TemporaryFolder folder;
  const std::string file = folder.path() + "/body.limber";
  const std::string other = folder.write("body.limber.0.part", "another's");
  EXPECT_EQ(saveNetwork(test::everyMemberNetwork(), file).error(), "");
  EXPECT_EQ(readBytes(other).size(), 9u);
  EXPECT_TRUE(loadNetwork(file));
}

TEST(NetworkFile, whatCannotBeReadIsNamed) {
  const TemporaryFolder folder;
  const std::string missing = folder.path() + "/none.limber";
  EXPECT_EQ(loadNetwork(missing).error(), "cannot read " + missing + ": No such file or directory");
  EXPECT_EQ(loadNetwork(folder.path()).error(), "cannot read " + folder.path() + ": Is a directory");
}

TEST(NetworkFile, foreignFilesAreRefused) {
  const TemporaryFolder folder;
  const std::string text = folder.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n and more\n");
  EXPECT_EQ(loadNetwork(text).error(),
            text + ": not a .limber file: it does not begin with the bytes of one");
  const std::string shortText = folder.write("short", "PNG");
  EXPECT_EQ(loadNetwork(shortText).error(),
            shortText + ": not a .limber file: it does not begin with the bytes of one");
  const std::string empty = folder.write("empty.limber", "");
  EXPECT_EQ(loadNetwork(empty).error(), empty + ": not a .limber file: it is empty");
}

TEST(NetworkFile, otherVersionsAreRefused) {
  Bytes bytes = toBytes(test::everyMemberNetwork());
  for (const std::uint8_t version : {std::uint8_t{0}, std::uint8_t{4}}) {
    bytes[8] = version;
    EXPECT_EQ(parse(bytes).error(), "a .limber file of version " + std::to_string(version) +
                                        ", this library reads versions 1 to 3");
  }
}

TEST(NetworkFile, groupsNeedVersionTwo) {
  SpringNetwork network = test::everyMemberNetwork();
  EXPECT_EQ(toBytes(network)[8], 1) << "older libraries read networks without groups";
  network.groups = {{"arms", {0, 2}, {0, 1, 4}}, {"no members", {}, {}}};
  const Bytes bytes = toBytes(network);
  EXPECT_EQ(bytes[8], 2);
  const auto read = parse(bytes);
  ASSERT_TRUE(read) << read.error();
  ASSERT_EQ((*read)->groups.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*read)->groups[i].name, network.groups[i].name);
    EXPECT_EQ((*read)->groups[i].springs, network.groups[i].springs);
    EXPECT_EQ((*read)->groups[i].points, network.groups[i].points);
  }
  network.groups[0].springs = {2, 1};
  EXPECT_EQ(parse(toBytes(network)).error(), "group 0 (arms) has spring 1 after 2");
}

TEST(NetworkFile, everyTruncationIsRefused) {
  const Bytes bytes = toBytes(test::everyMemberNetwork());
  for (std::size_t size = 1; size < bytes.size(); ++size) {
    // a copy of exactly this length, so that a sanitizer sees any read beyond it
    const std::string reason = parse(Bytes(bytes.begin(), bytes.begin() + std::ptrdiff_t(size))).error();
    EXPECT_EQ(reason.rfind("the file is too short: ", 0), 0u) << size << ": " << reason;
  }
}

TEST(NetworkFile, bytesBehindTheEndAreRefused) {
  Bytes bytes = toBytes(test::everyMemberNetwork());
  const std::string size = std::to_string(bytes.size() - test::kHeaderBytes);
  bytes.resize(bytes.size() + 3);
  EXPECT_EQ(parse(bytes).error(),
            "the file is too long: 3 bytes follow the " + size + " bytes after its header");
  EXPECT_EQ(parse(test::forged(bytes)).error(), "3 bytes follow the end of its contents");
}

TEST(NetworkFile, everyChangedByteIsRefused) {
  const Bytes bytes = toBytes(test::everyMemberNetwork());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (unsigned change = 1; change < 256; ++change) {
      Bytes damaged = bytes;
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ change);
      EXPECT_FALSE(parse(damaged)) << "byte " << at << " changed by " << change;
    }
  }
}

TEST(NetworkFile, whatTheNetworkPromisesIsChecked) {
  SpringNetwork network = test::everyMemberNetwork();
  network.springs[2].b = 5;
  EXPECT_EQ(parse(toBytes(network)).error(), "spring 2 uses point 5 of 5");
  network = test::everyMemberNetwork();
  network.springs[3].kind = static_cast<SpringKind>(4);
  EXPECT_EQ(parse(toBytes(network)).error(), "element 3 of the springs has the unknown kind 4");
  network = test::everyMemberNetwork();
  network.kind = static_cast<NetworkKind>(3);
  EXPECT_EQ(parse(toBytes(network)).error(), "the network kind has the unknown kind 3");
}

// checked before anything is allocated: a vector of that length could not be allocated
TEST(NetworkFile, countsBeyondTheBytesAreRefused) {
  const Bytes bytes = toBytes(test::everyMemberNetwork());
  const std::size_t countAt = test::kHeaderBytes + 1 + 8 + 10 * 8;  // of the rest points
  ASSERT_EQ(bytes[countAt], 5);
  for (const int high : {2, 4, 7}) {
    Bytes damaged = bytes;
    damaged[countAt + std::size_t(high)] = 0x7f;
    const std::string reason = parse(test::forged(damaged)).error();
    EXPECT_EQ(reason.rfind("the bytes end before its ", 0), 0u) << reason;
  }
}

}  // namespace
}  // namespace limber
